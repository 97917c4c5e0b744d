"""What `prose.py` counts and what it leaves out.

    python3 -m unittest discover -s tests/prose
"""

import tempfile
import unittest
from pathlib import Path

from prose import comments_of, long_sentences, outside_tables, paragraphs, phrases, without_code

PAGE = """# So many headings

It stands
beside the door, of which there are two. See `beside` too.

| measured | on |
| --- | --- |
| 3 ms | 26 November 2026 |

Measured on 25 November.

    indented code beside

```rust
// fenced code beside
```
<!-- prose: off -->
It is told so many times.
<!-- prose: on -->
"""


class Prose(unittest.TestCase):
    def test_phrases_of_a_page(self):
        names = sorted(name for name, _ in phrases(without_code(PAGE)))
        self.assertEqual(names, ["beside", "beside", "dates", "dates", "of which, of whom", "so many", "stand, stands"])

    def test_dates_in_tables_are_not_prose(self):
        prose = outside_tables(PAGE)
        self.assertIn("25 November", prose)
        self.assertNotIn("26 November", prose)

    def test_sentences(self):
        long = " ".join(["Word"] * 41) + ". "
        short = " ".join(["Word"] * 40) + ". "
        found, number = long_sentences(paragraphs(f"{long}{short}A third one, e.g. This.\n\n- {long}\n"))
        self.assertEqual((len(found), number), (2, 4))

    def test_comments_of_rust(self):
        source = 'let a = "// no comment"; // It stands\n// beside it.\nlet b = 1;\n/// So\n/// many lines.\n'
        self.assertEqual(self.comments(source, ".rs"), ["It stands beside it.", "So many lines."])

    def test_comments_of_python(self):
        source = '"""Beside."""\nx = "stands"  # So many\n'
        self.assertEqual([" ".join(comment.split()) for comment in self.comments(source, ".py")], ["Beside. So many"])

    def comments(self, source, suffix):
        with tempfile.TemporaryDirectory() as directory:
            path = Path(directory) / f"source{suffix}"
            path.write_text(source)
            return comments_of(path)


if __name__ == "__main__":
    unittest.main()
