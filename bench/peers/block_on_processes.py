"""A hanging block of Q2 hexahedra on processes and on threads: this library over PETSc, its own multigrid, DOLFINx over PETSc.

usage: python3 bench/peers/block_on_processes.py [CELLS] [--processes 1 2] [--rounds 3]
Before: cargo build --release -p forms-distributed --features petsc      (DOLFINx: Debian's python3-dolfinx)
Each program solves to a relative residual of 1e-10; those over PETSc have CG with GAMG and its default options. The seconds are
those from the mesh to the solution, the least of the rounds, which alternate between the programs.
"""

import argparse
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
# Each process has one thread. Open MPI asks before it runs more processes than cores, or as root.
ENVIRONMENT = os.environ | {
    "OMP_NUM_THREADS": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
}


def run(command):
    """The numbers that a program tells by names, or why there are none."""
    try:
        done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True)
    except FileNotFoundError as error:
        return str(error)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines()
        return next((line for line in lines if "Error" in line), lines[0] if lines else "failed")
    numbers = {}
    for line in done.stdout.splitlines():
        name, *values = line.split()
        try:
            numbers[name] = float(values[0])
        except (IndexError, ValueError):
            pass
    return numbers


parser = argparse.ArgumentParser()
parser.add_argument("cells", nargs="?", default="16")
parser.add_argument("--processes", nargs="+", default=["1", "2"])
parser.add_argument("--rounds", type=int, default=3)
options = parser.parse_args()
script = pathlib.Path(__file__).with_name("block_dolfinx.py")
programs = {}
for count in options.processes:
    mpirun, many = ["mpirun", "-n", count], "es" if int(count) > 1 else ""
    programs[f"multigrid of forms_fem, {count} thread{many[1:]}"] = [BUILT / "hanging_block", options.cells, "multigrid", count]
    programs[f"PETSc, whole mesh, {count} process{many}"] = [*mpirun, BUILT / "hanging_block", options.cells, "cg"]
    programs[f"PETSc, parts, {count} process{many}"] = [*mpirun, BUILT / "parts", "hanging", options.cells, "2", "cg"]
    programs[f"DOLFINx, {count} process{many}"] = [*mpirun, "/usr/bin/python3", script, options.cells]
found = {name: [] for name in programs}
for _ in range(options.rounds):
    for name, command in programs.items():
        found[name].append(run([str(part) for part in command]))
print("| program | seconds | in set-up and solution | iterations | largest peak [MB] | ∫ \\|∇u\\|² + \\|u\\|² |")
print("| --- | --: | --: | --: | --: | --: |")
for name, rounds in found.items():
    told = [numbers for numbers in rounds if not isinstance(numbers, str)]
    if not told:
        print(f"| {name} | {rounds[0]} | | | | |")
        continue
    best = min(told, key=lambda numbers: numbers["seconds"])
    text = lambda name, digits: f"{best[name]:.{digits}f}" if name in best else ""
    print(f"| {name} | {text('seconds', 2)} | {text('solve_seconds', 2)} | {text('iterations', 0)} | {text('megabytes', 0)} | {text('size', 9)} |")
