#!/bin/sh
# The programs that run.py compares with, in an environment of their own: $CONTACT_PEERS_VENV or ~/.cache/peers/contact.
# GetFEM and CalculiX are packages of the system; on Debian: apt-get install python3-getfem python3-scipy calculix-ccx
set -e
place="${CONTACT_PEERS_VENV:-$HOME/.cache/peers/contact}"
python3 -m venv "$place"
"$place/bin/pip" install --quiet "ngsolve==6.2.2608" "mfem==4.10.0.1" "felupe==11.3.0" "tamaas==2.9.0" "ContactMechanics==1.8.3"
