"""The two inverse problems of docs/inverse_problems.md here and in scikit-fem: one table of one run.

usage: inverse_both.py OURS heat|structure [--cells N [N ...]] [--symmetric]

OURS is the program `inverse_problems` (cargo build --release --bin inverse_problems). Each case runs in a process of its own on either
side, so that its peak memory is its own; where the values differ by more than a billionth of them the case is named as failed.
"""

import argparse
import pathlib
import subprocess
import sys

CASES = ["16 × 2 × 8", "16 × 8 × 8", "32 × 8 × 8"]
PEER = pathlib.Path(__file__).with_name("inverse_skfem.py")


def cells_of_last_row(command):
    """The entries of the last line of the table that a program prints."""
    found = subprocess.run(command, capture_output=True, text=True)
    if found.returncode != 0:
        return None, (found.stderr.strip().splitlines() or [f"status {found.returncode}"])[-1]
    rows = [line for line in found.stdout.splitlines() if line.startswith("|")]
    return [entry.strip() for entry in rows[-1].strip("|").split("|")], None


parser = argparse.ArgumentParser()
parser.add_argument("ours")
parser.add_argument("problem", choices=["heat", "structure"])
parser.add_argument("--cells", type=int, nargs="+", default=[64, 128, 256, 512, 1024])
parser.add_argument("--symmetric", action="store_true", help="SuperLU with minimum degree on the symmetric pattern")
options = parser.parse_args()
how = ["--symmetric"] if options.symmetric else []
cases = options.cells if options.problem == "heat" else range(len(CASES))
print("| cells | unknowns | J | the first value | seconds of a value | scikit-fem | times | with gradient | scikit-fem | times | processor seconds | scikit-fem | of ours in factor and solves | MB | scikit-fem |")
print("| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |")
for case in cases:
    choice = ["--cells", str(case)] if options.problem == "heat" else ["--case", str(case)]
    alone = ["--iterations", "0"] if options.problem == "structure" else []
    ours, why = cells_of_last_row([options.ours, options.problem, *choice, *alone])
    if ours is None:
        sys.exit(f"{options.ours} failed: {why}")
    theirs, why = cells_of_last_row([sys.executable, str(PEER), options.problem, *choice, *how])
    name, unknowns, value, first, of_value, of_both, processor, in_solver, _, memory = ours
    if theirs is None:
        print(f"| {name} | {unknowns} | {value} | {first} | {of_value} | failed: {why} | | {of_both} | | | {processor} | | {in_solver} | {memory} | |", flush=True)
        continue
    difference = abs(float(value) / float(theirs[2]) - 1)
    if difference > 1e-9:
        sys.exit(f"{name}: values differ by {difference:.1e}")
    times = [f"{float(theirs[3]) / float(of_value):.1f}", f"{float(theirs[4]) / float(of_both):.1f}"]
    print(
        f"| {name} | {unknowns} | {value} | {first} | {of_value} | {theirs[3]} | {times[0]} | {of_both} | {theirs[4]} | {times[1]} "
        f"| {processor} | {theirs[5]} | {in_solver} | {memory} | {theirs[7]} |",
        flush=True,
    )
