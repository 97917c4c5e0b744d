#!/usr/bin/env python3
"""Measures what a user waits for: from nothing, and from an edit of the form, to the printed numbers of a program.

    python3 tests/compile_cost/waiting.py [--debug] [--target DIRECTORY] [starter] [contact_law]

Each program is copied out of the repository, as a user would, built and run, changed in one number of its form, and run again, three
times; the median is printed, by the clock and in seconds of CPU of everything that cargo starts. What is downloaded is
downloaded before. Without `--target` the dependencies are built anew, and that time is printed, too.
"""

import argparse
import os
import pathlib
import re
import resource
import shutil
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Where the program is, the file of its form, and a number there.
PROGRAMS = {
    "starter": ("starter", "src/main.rs", "1 + growth * t"),
    "contact_law": ("tests/contact_law", "src/tresca.rs", "integral(Omega, inner("),
}


def copied(name, directory):
    """The program in a directory of its own, with its dependencies at their place in the repository."""
    place, _, _ = PROGRAMS[name]
    # With new times: cargo would take what another copy has left in the build directory for this one.
    shutil.copytree(ROOT / place, directory, copy_function=shutil.copy, ignore=shutil.ignore_patterns("target", "Cargo.lock"))
    shutil.copy(ROOT / "Cargo.lock", directory)
    manifest = directory / "Cargo.toml"
    absolute = lambda found: f'path = "{(ROOT / place / found.group(1)).resolve()}"'
    manifest.write_text(re.sub(r'path = "([^"]*)"', absolute, manifest.read_text()))
    profile = manifest.read_text()
    if "[profile.release]" not in profile:
        # That of the starter, which a user copies.
        starter = (ROOT / "starter/Cargo.toml").read_text()
        manifest.write_text(profile + "\n" + starter[starter.index("[profile.dev]") : starter.index("[workspace]")])


def run(directory, target, release):
    """Seconds by the clock and of CPU until the program has printed its numbers."""
    command = ["cargo", "run", "--quiet", "--offline"] + (["--release"] if release else [])
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    environment.pop("CARGO_INCREMENTAL", None)
    subprocess.run(command, cwd=directory, env=environment, check=True, stdout=subprocess.DEVNULL)
    clock, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return clock, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*", default=list(PROGRAMS))
    parser.add_argument("--debug", action="store_true")
    parser.add_argument("--target", help="a build directory whose dependencies are kept")
    arguments = parser.parse_args()
    release = not arguments.debug
    print(f"load {os.getloadavg()[0]:.1f}, {'release' if release else 'debug'}; seconds by the clock, of CPU")
    for name in arguments.programs:
        with tempfile.TemporaryDirectory() as temporary:
            directory = pathlib.Path(temporary) / "program"
            copied(name, directory)
            target = pathlib.Path(arguments.target or pathlib.Path(temporary) / "target").resolve()
            clock, cpu = run(directory, target, release)
            print(f"{name}: first {clock:.1f}, {cpu:.1f}", flush=True)
            source = directory / PROGRAMS[name][1]
            text, number = source.read_text(), PROGRAMS[name][2]
            assert number in text, f"{number!r} does not stand in {source}"
            times = []
            # So little that the programs' own checks of their results still pass.
            for factor in ("1.00000000001", "1.00000000002", "1.00000000003"):
                changed = f"{factor} * {number}"
                source.write_text(text.replace(number, changed, 1))
                times.append(run(directory, target, release))
            clock, cpu = (statistics.median(column) for column in zip(*times))
            print(f"{name}: after an edit {clock:.1f}, {cpu:.1f}", flush=True)


if __name__ == "__main__":
    main()
