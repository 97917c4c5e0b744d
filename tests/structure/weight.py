"""The weight of the sources: lines, visitors, signatures that are generic over a form, functions that are kept from being
inlined, and blocks that compile instances in a library. `weight.py` prints the counts of the checked-out files, and
`weight.py --check` fails where one of them is above its limit. Limits are ratchets: lower them when a count falls. What adds a capability
raises them in its own commit."""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Name, pattern, whether tests count, limit.
COUNTS = [
    ("visitors of a form", r"\b(?:trait|for) \w*Visitor\b(?!.*syn)", False, 0),
    ("signatures generic over a form", r"[<,(] ?(?:[A-Z]\w*|\w+: &?impl) ?:? (?:contract::)?(?:Form|Functional|Expression|Integrals|Compiled|WithIntegrals)<", False, 12),
    ("#[inline(never)]", r"#\[inline\(never\)\]", False, 274),
    ("instantiate! blocks", r"^\s*instantiate!\(", False, 98),
]
LINES = [("lines of Rust without tests", False, 193_000), ("lines of Rust", True, 268_900)]


def sources():
    """The Rust files of the repository: (path, whether it is a test)."""
    listed = subprocess.run(["git", "ls-files", "--", "*.rs"], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        path = pathlib.PurePosixPath(name)
        is_test = "tests" in path.parts or path.name == "tests.rs" or path.parts[0] in ("fuzz",) or "toy_backend" in path.parts
        yield ROOT / name, is_test


def main():
    files = [(path.read_text(), is_test) for path, is_test in sources()]
    failed = False
    rows = [(name, sum(text.count("\n") for text, is_test in files if with_tests or not is_test), limit)
            for name, with_tests, limit in LINES]
    for name, pattern, with_tests, limit in COUNTS:
        found = re.compile(pattern, re.MULTILINE)
        rows.append((name, sum(len(found.findall(text)) for text, is_test in files if with_tests or not is_test), limit))
    for name, count, limit in rows:
        failed |= count > limit
        print(f"{name:32} {count:8} of at most {limit}")
    if failed and "--check" in sys.argv:
        sys.exit("a count is above its limit")


if __name__ == "__main__":
    main()
