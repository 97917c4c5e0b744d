"""Seconds from saving an edit of a formulation to its table.

usage: python3 examples/contact_bench/edit_to_table.py [FORMULATION] [PROBLEMS] [OPTIONS OF contact_bench ...]

FORMULATION is a file of `formulations` without its ending (nitsche), PROBLEMS a list with commas (lame,hertz,wavy). Everything is built first. Then the first
integral in the file's forms gets the factor 1.0001, the program is built and run as a user does it, and the file is as it was again. The machine has to be
idle: its load is printed.
"""

import os
import pathlib
import re
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def edited(text):
    """The text with another factor in the first integral of a form."""
    return re.sub(r"(integral\(\w+(?:\(u\))?, )", r"\g<1>1.0001 * ", text, count=1)


def main(formulation="nitsche", problems="lame,hertz,wavy", *options):
    path = HERE / "formulations" / f"{formulation}.rs"
    before = path.read_text()
    if edited(before) == before:
        sys.exit(f"{path} has no integral")
    name = formulation.replace("_", " ")
    run = ["cargo", "run", "--release", "--locked", "--bin", "contact_bench", "--", "--problems", problems, "--formulations", name, *options]
    build = run[: run.index("--")]
    build[1] = "build"
    subprocess.run(build, cwd=ROOT, check=True)
    load = os.getloadavg()[0]
    try:
        path.write_text(edited(before))
        start, used = time.perf_counter(), os.times()
        subprocess.run(build, cwd=ROOT, check=True)
        built = time.perf_counter()
        subprocess.run(run, cwd=ROOT, check=True)
        end, after = time.perf_counter(), os.times()
    finally:
        path.write_text(before)
    processor = sum(after[2:4]) - sum(used[2:4])
    print(f"{name} on {problems}: {end - start:.1f} s, {built - start:.1f} s of them to build; {processor:.1f} s of processor time; load before {load:.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
