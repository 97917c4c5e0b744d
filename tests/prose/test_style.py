"""Rules of CONTRIBUTING.md's section on style: no page or comment has the left side of a row of its table. User pages say for whom
they are, their tables have at most seven columns, and tutorials begin with a picture and have suggested edits.

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


def user_pages():
    pages = [path for path in sorted((ROOT / "docs").rglob("*.md")) if "decisions" not in path.parts and "included" not in path.parts]
    return {path: path.read_text() for path in pages if path.name != "SUMMARY.md"}


class Style(unittest.TestCase):
    def test_user_pages_say_for_whom_they_are(self):
        self.assertEqual([path.name for path, text in user_pages().items() if not text.split("\n")[2].startswith("For ")], [])

    def test_tables_have_at_most_seven_columns(self):
        heads = re.compile(r"^\|[ :|-]+\|$", re.MULTILINE)
        wide = [path.name for path, text in user_pages().items() for head in heads.findall(text) if head.count("|") > 8]
        self.assertEqual(wide, [])

    def test_tutorials_have_a_picture_and_edits(self):
        tutorials = [text for path, text in user_pages().items() if path.parent.name == "tutorials"]
        self.assertEqual(len(tutorials), 12)
        for text in tutorials:
            self.assertTrue(text.split("\n")[4].startswith("!["), text[:40])
            edits = text.split("| change | what happens |\n| --- | --- |\n")[1].split("\n\n")[0]
            self.assertGreaterEqual(edits.count("\n") + 1, 3, text[:40])

    def test_replaced_phrases_are_gone(self):
        phrases = replaced_phrases()
        self.assertGreaterEqual(len(phrases), 20)
        found = [f"{name}: {phrase}" for name, text in texts() for phrase in phrases if phrase.lower() in text]
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
