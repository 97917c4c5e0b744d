"""Runs the scripts of this directory, each with its program, and writes their rows for `contact_bench --others FILE`.

usage: run.py [FILE] [PART OF A SCRIPT'S NAME ...]        (default: out/contact_bench_others.jsonl; install.sh installs the programs)

A program that is missing is named in a line and skipped.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
PLACE = Path(os.environ.get("CONTACT_PEERS_VENV", Path.home() / ".cache" / "peers" / "contact"))
# The environment of install.sh, this Python, and that of the system, to which packages of Debian belong.
PYTHONS = [path for path in (str(PLACE / "bin" / "python"), sys.executable, "/usr/bin/python3") if Path(path).exists()]
COMMANDS = {"calculix": "ccx"}


def python_with(program):
    """The Python that runs the scripts of a program."""
    if program in COMMANDS and not shutil.which(COMMANDS[program]):
        return None
    module = "numpy" if program in COMMANDS else program
    return next((python for python in PYTHONS if not subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode), None)


def main():
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "out/contact_bench_others.jsonl")
    parts = sys.argv[2:]
    lines = []
    for script in sorted(HERE.glob("*_*.py")):
        program = script.stem.rsplit("_", 1)[1]
        if parts and not any(part in script.stem for part in parts):
            continue
        python = python_with(program)
        if python is None:
            print(f"{script.name}: {program} is not installed (install.sh)")
            continue
        done = subprocess.run([python, str(script)], capture_output=True, text=True)
        lines += [line for line in done.stdout.splitlines() if line.startswith("{")]
        if done.returncode:
            print(f"{script.name}: failed: {(done.stderr.strip().splitlines() or ['no message'])[-1]}")
        else:
            print(f"{script.name}: done")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text("".join(line + "\n" for line in lines))
    print(target)


main()
