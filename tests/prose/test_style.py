"""No page or comment has the left side of a row of CONTRIBUTING.md's table of style.

    python3 -m unittest discover -s tests/prose
"""

import re
import subprocess
import unittest
from pathlib import Path

from prose import OFF, comments_of

ROOT = Path(__file__).resolve().parents[2]


def replaced_phrases():
    """The left column of the table."""
    table = (ROOT / "CONTRIBUTING.md").read_text().split("| instead of | write |")[1].split("<!-- prose: on -->")[0]
    cells = [line.split("|")[1].strip() for line in table.splitlines() if line.startswith("|") and "---" not in line]
    return [cell.removesuffix(" (commit)") for cell in cells]


def texts():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", "*.md", "*.rs", "*.py"],
                            cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        path = ROOT / name
        if path.is_file():
            text = OFF.sub("", path.read_text()) if path.suffix == ".md" else "\n".join(comments_of(path))
            yield name, re.sub(r"\s+", " ", text).lower()


class Style(unittest.TestCase):
    def test_replaced_phrases_are_gone(self):
        phrases = replaced_phrases()
        self.assertGreaterEqual(len(phrases), 20)
        found = [f"{name}: {phrase}" for name, text in texts() for phrase in phrases if phrase.lower() in text]
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
