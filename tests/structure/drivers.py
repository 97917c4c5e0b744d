"""Lengths of the formulations of the comparison: at most 25 lines of a form, at most 15 of a function that drives it.

    python3 tests/structure/drivers.py             # all of them
    python3 tests/structure/drivers.py --check     # those that are too long, and the status 1 if there are any

A form is a `mod`, a driver a function next to it; braces and signatures do not count.
"""
import pathlib
import re
import sys

FORMULATIONS = pathlib.Path(__file__).parents[2] / "examples/contact_bench/formulations"
MOST = {"mod": 25, "fn": 15}


def lengths(text):
    """Kind, name and number of lines of the items that are not inside of a `mod` with a body."""
    lines = text.split("\n")
    index = 0
    while index < len(lines):
        item = re.match(r"( *)(?:pub )?(mod|fn) (\w+)(?!.*;$)", lines[index])
        index += 1
        if item is None:
            continue
        begin = next(at for at in range(index - 1, len(lines)) if lines[at].endswith("{"))
        end = next(at for at in range(begin, len(lines)) if lines[at].startswith(item[1] + "}"))
        yield item[2], item[3], end - begin - 1
        if item[2] == "mod":
            index = end


def main(arguments):
    too_long = 0
    for path in sorted(path for path in FORMULATIONS.glob("*.rs") if path.name != "main.rs"):
        for kind, name, length in lengths(path.read_text()):
            is_too_long = length > MOST[kind]
            too_long += is_too_long
            if is_too_long or "--check" not in arguments:
                print(f"{path.name:28} {kind:3} {name:20} {length:3} of at most {MOST[kind]}")
    return 1 if too_long and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
