#!/usr/bin/env python3
"""Counts the functions that rustc compiles in a program, and says which are the largest.

    cargo rustc --release -p forms-examples --bin 01_poisson -- \\
        -C codegen-units=1 -C no-prepopulate-passes --emit=llvm-ir=01_poisson.ll
    python3 tests/compile_cost/instances.py 01_poisson.ll [--at-most 2000]

The argument is what rustc hands to LLVM. Its functions are the program's own and the instances of generic ones: kernels in
the assembler's loops, and what is generic in libraries and not compiled there (fem/problem/src/instantiate.rs).
"""

import argparse
import collections
import re
import sys


def functions(path):
    """Name and number of lines of each function that is defined."""
    name = None
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("define "):
                name, count = re.search(r'@"?([^"(]+)"?\(', line).group(1), 0
            if name is not None:
                count += 1
                if line.startswith("}"):
                    yield readable(name), count
                    name = None


def readable(symbol):
    """The path in a symbol, without its hash and what encodes punctuation; newer symbols as they are."""
    rest = re.match(r"_ZN(.*)E", symbol)
    if rest is None:
        return symbol
    rest, parts = rest.group(1), []
    while number := re.match(r"\d+", rest):
        start = number.end()
        length = int(number.group())
        parts.append(rest[start : start + length])
        rest = rest[start + length :]
    path = "::".join(part for part in parts if not re.fullmatch(r"h[0-9a-f]{16}", part))
    for code, sign in [("$LT$", "<"), ("$GT$", ">"), ("$RF$", "&"), ("$C$", ","), ("$u20$", " "), ("..", "::")]:
        path = path.replace(code, sign)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("--at-most", type=int, help="fail if there are more functions")
    arguments = parser.parse_args()
    lines, count = collections.Counter(), collections.Counter()
    for name, length in functions(arguments.file):
        lines[name] += length
        count[name] += 1
    total = sum(count.values())
    print(f"{total} functions, {sum(lines.values())} lines; the largest, with their lines and instances:")
    for name, length in lines.most_common(10):
        print(f"{length:8} {count[name]:5}  {name[:100]}")
    if total == 0:
        sys.exit("no function: is this LLVM's intermediate representation?")
    if arguments.at_most is not None and total > arguments.at_most:
        sys.exit(f"{total} functions are more than {arguments.at_most}")


if __name__ == "__main__":
    main()
