#!/usr/bin/env python3
"""Instructions of assemblies, counted one by one, beside those of counts.json.

    count.py PROGRAM [--update]

PROGRAM is the example `counted_assembly` in the development profile. A processor steps through it under ptrace (Linux on x86-64), since neither
valgrind (no AVX-512) nor the processor's own counters (hidden in virtual machines) are there everywhere. Counts hold for one version of rustc and one
set of vector instructions: with others there is nothing to compare, and the script says so.
"""

import ctypes
import json
import os
import pathlib
import platform
import subprocess
import sys

COUNTS = pathlib.Path(__file__).parent / "counts.json"
BOUND = 0.03
TRACEME, PEEKUSER, SINGLESTEP, SYSCALL = 0, 3, 9, 24
# Registers in `struct user` of x86-64: the number of a system call and its first argument.
ORIG_RAX, RDI = 15 * 8, 14 * 8
WRITE, STANDARD_OUTPUT = 1, 1

libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long] * 4
libc.ptrace.restype = ctypes.c_long


def trace(request, process, address=0):
    ctypes.set_errno(0)
    result = libc.ptrace(request, process, address, 0)
    if ctypes.get_errno():
        raise OSError(ctypes.get_errno(), "ptrace: " + os.strerror(ctypes.get_errno()))
    return result


def wait(process):
    """The exit code, or None where the process has stopped."""
    _, status = os.waitpid(process, 0)
    if os.WIFSTOPPED(status):
        return None
    return os.waitstatus_to_exitcode(status)


def instructions(program, case):
    """The first line that the program prints, and its instructions from there to its end."""
    reader, writer = os.pipe()
    process = os.fork()
    if process == 0:
        os.dup2(writer, 1)
        try:
            trace(TRACEME, 0)
            os.execv(program, [program, case])
        finally:
            os._exit(126)
    os.close(writer)
    code, printed, entering = wait(process), False, True
    while code is None and not printed:
        trace(SYSCALL, process)
        code = wait(process)
        if code is None:
            call = (trace(PEEKUSER, process, ORIG_RAX), trace(PEEKUSER, process, RDI))
            printed = not entering and call == (WRITE, STANDARD_OUTPUT)
            entering = not entering
    count = 0
    while code is None:
        trace(SINGLESTEP, process)
        code = wait(process)
        count += 1
    with os.fdopen(reader) as stream:
        line = stream.readline().strip()
    if code != 0 or not printed:
        raise OSError(f"{case}: exit code {code}")
    return line, count


def main():
    if sys.platform != "linux" or platform.machine() != "x86_64":
        print("SKIPPED: instructions are counted on Linux with x86-64 alone")
        return
    program = os.path.abspath(sys.argv[1])
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    cases = subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines()
    found = {"rustc": rustc, "vectors": None, "counts": {}}
    for case in cases:
        try:
            found["vectors"], found["counts"][case] = instructions(program, case)
        except PermissionError as error:
            print(f"SKIPPED: {error}")
            return
    if "--update" in sys.argv[2:]:
        COUNTS.write_text(json.dumps(found, indent=2, ensure_ascii=False) + "\n")
    known = json.loads(COUNTS.read_text())
    same = all(known[key] == found[key] for key in ("rustc", "vectors"))
    failed = []
    for case, count in found["counts"].items():
        before = known["counts"].get(case)
        change = count / before - 1 if before else None
        print(f"{case:48} {count:9}" + (f"  {change:+7.2%}" if change is not None else "  new"))
        if before is None or change > BOUND:
            failed.append(case)
    if not same:
        print(f"NOT COMPARED: counts.json is of {known['rustc']}, {known['vectors']}; this is {rustc}, {found['vectors']}")
    elif failed:
        sys.exit(f"more than {BOUND:.0%} above counts.json, or not in it (count.py PROGRAM --update): {', '.join(failed)}")


main()
