"""Files that allow `unsafe` code, compared with those that ARCHITECTURE.md lists.

    python3 tests/structure/unsafe_code.py      # exit code 1 where they differ

The workspace denies the lint `unsafe_code`; a file that needs it says `#![allow(unsafe_code)]`.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def listed(page):
    """The paths of the invariant's paragraph; one without a folder lies in that of the path before it."""
    start = page.index("**Invariant: `unsafe` is only**")
    paragraph = re.split(r"\n- |\n\n", page[start:], maxsplit=1)[0]
    found = []
    for name in re.findall(r"`([\w/]+(?:\.rs)?)`", paragraph):
        if "/" in name:
            found.append(name)
        elif name.endswith(".rs"):
            found.append(f"{found[-1].rsplit('/', 1)[0]}/{name}")
    return {name for name in found if name.endswith(".rs") or (ROOT / name).is_dir()}


def allowed():
    """Files that allow it; a `mod.rs` as its folder."""
    told = subprocess.run(
        ["git", "grep", "-l", "--untracked", "allow(unsafe_code)", "--", "*.rs"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )
    return {name.removesuffix("/mod.rs") for name in told.stdout.splitlines()}


def main():
    page = listed((ROOT / "ARCHITECTURE.md").read_text())
    files = allowed()
    for name in sorted(files - page):
        print(f"{name} allows unsafe code, and ARCHITECTURE.md does not list it")
    for name in sorted(page - files):
        print(f"{name} is listed in ARCHITECTURE.md, and does not allow unsafe code")
    return int(files != page)


if __name__ == "__main__":
    sys.exit(main())
