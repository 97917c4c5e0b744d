"""Links and included pages of the book: python3 -m unittest discover -s tests/book"""

import tempfile
import unittest
from pathlib import Path

from links import Links


class Pages(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory()
        self.root = Path(self.directory.name).resolve()
        (self.root / "docs/included").mkdir(parents=True)
        (self.root / "examples").mkdir()
        (self.root / "examples/results.md").write_text("# R\n[a](other.rs) [m](../docs/method.md#x) `[c](d.md)`\n")
        chapters = {"method.md": "", "included/results.md": "<!-- page: ../../examples/results.md -->\n"}
        self.links = Links(self.root / "docs", chapters)

    def tearDown(self):
        self.directory.cleanup()

    def page(self, name, text, repository=""):
        return self.links.in_page(name, text, repository)

    def test_included_page(self):
        text = self.page("included/results.md", "<!-- page: ../../examples/results.md -->\n")
        self.assertEqual(text, "# R\n[a](../../examples/other.rs) [m](../method.md#x) `[c](d.md)`\n\n")

    def test_links_to_it(self):
        self.assertEqual(self.page("method.md", "[r](../examples/results.md#R)"), "[r](included/results.md#R)")

    def test_links_out_of_the_book(self):
        text = "[`laws`](../contact/src/laws) and [a test](../fem/tests/x.rs)"
        self.assertEqual(self.page("method.md", text), "`laws` and [a test](../fem/tests/x.rs)")
        self.assertEqual(self.page("method.md", text, "https://example.org"), text)
        self.assertEqual(self.page("method.md", "[time](time.md#impact)"), "[time](time.md#impact)")

    def test_code(self):
        text = "```rust\n[r](../examples/results.md)\n```\n`[r](../examples/results.md)`"
        self.assertEqual(self.page("method.md", text), text)


if __name__ == "__main__":
    unittest.main()
