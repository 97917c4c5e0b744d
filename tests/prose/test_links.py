"""Links of pages lead to files and headings of the repository.

    python3 -m unittest discover -s tests/prose
"""

import re
import subprocess
import unittest
from pathlib import Path

from prose import FENCE

ROOT = Path(__file__).resolve().parents[2]
TARGET = re.compile(r"\]\(([^()\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


def pages():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", "*.md"],
                            cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", FENCE.sub("", text))


def anchors(page):
    """The anchors of a page: those of its headings, as GitHub and mdBook make them, and its own."""
    text = page.read_text()
    headings = HEADING.findall(FENCE.sub("", text))
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "") for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in plain} | set(re.findall(r'<a id="([^"]+)"', text))


def broken_links():
    for page in pages():
        for target in TARGET.findall(without_code(page.read_text())):
            if "://" in target or target.startswith("mailto:"):
                continue
            path, _, anchor = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
                yield f"{page.relative_to(ROOT)}: {target}"


class Links(unittest.TestCase):
    def test_anchors(self):
        self.assertIn("the-template", anchors(ROOT / "docs/decisions/README.md"))

    def test_every_link_leads_somewhere(self):
        self.assertEqual(list(broken_links()), [])


if __name__ == "__main__":
    unittest.main()
