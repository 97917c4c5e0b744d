"""A book that mdBook wrote: every page of its source is in it, every file and anchor that a page names is there, tutorials
with forms show their formulas, and formulas of pages are typeset.

    mdbook build docs && python3 tests/book/check_links.py docs target/book
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.anchors, self.targets, self.formulas = set(), [], 0
        text = path.read_text()
        self.declares_forms = "#[forms]" in text
        # LaTeX that was left as it is, and a formula whose underscores were taken for emphasis.
        self.broken_formulas = re.findall(r'language-math|<em>[^<]*[∫∂∇Σ][^<]*</em>', text)
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors.update(attributes[name] for name in ("id", "name") if attributes.get(name))
        self.targets += [attributes[name] for name in ("href", "src") if attributes.get(name)]
        self.formulas += tag == "math"


def main(source, root):
    written = (page.relative_to(source) for page in source.rglob("*.md") if page.name != "SUMMARY.md")
    pages_of_source = [page.with_name("index.md") if page.name == "README.md" else page for page in written]
    left_out = [str(page) for page in pages_of_source if not (root / page.with_suffix(".html")).exists()]
    if left_out:
        sys.exit(f"not in SUMMARY.md: {', '.join(left_out)}")
    # print.html holds all pages once more, 404.html's links are those of a server's root.
    paths = [path for path in root.rglob("*.html") if path.name not in ("print.html", "404.html", "toc.html")]
    pages = {path.resolve(): Page(path) for path in paths}
    broken, links = [], 0
    for path, page in pages.items():
        for target in page.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            links += 1
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            if not file.exists() or (anchor and file in pages and anchor not in pages[file].anchors):
                broken.append(f"{path.relative_to(root.resolve())}: {target}")
    tutorials = [page for path, page in pages.items() if path.parent.name == "tutorials" and page.declares_forms]
    without = sum(page.formulas == 0 for page in tutorials)
    print(f"{len(pages)} pages, {links} links, {sum(page.formulas for page in pages.values())} formulas")
    broken += [f"{path.relative_to(root.resolve())}: {one}" for path, page in pages.items() for one in page.broken_formulas]
    print("\n".join(broken))
    if broken or without or not tutorials:
        sys.exit(f"{len(broken)} broken links or formulas; {without} of {len(tutorials)} tutorials without formulas")


main(Path(sys.argv[1]), Path(sys.argv[2]))
