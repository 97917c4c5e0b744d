"""Links and included pages of the book.

A line `<!-- page: path -->` becomes the page at that path, which is kept next to what it describes, outside of the book's
directory. Links to such a page, from anywhere, lead to the place where the book has it.
"""

import os
import re
from pathlib import Path

INCLUDED = re.compile(r"^<!-- page: (\S+) -->$", re.MULTILINE)
# Code of any kind, which has no links, or a link with its label and target.
LINK = re.compile(r"^ *```.*?^ *```$|\[((?:`[^`\n]*`|[^\[\]`])*)\]\(([^()\s]+)\)|(`+).*?\3", re.DOTALL | re.MULTILINE)


class Links:
    """The places of included pages in the book: `root` is the directory of its pages, `chapters` their texts by path."""

    def __init__(self, root, chapters):
        self.root = Path(root).resolve()
        self.places = {}
        for page, text in chapters.items():
            for path in INCLUDED.findall(text):
                self.places[self.resolve(self.root / page, path)] = page

    @staticmethod
    def resolve(page, target):
        return Path(os.path.normpath(page.parent / target))

    def in_page(self, page, text, repository):
        """The text of a page of the book with the included one and with its links."""
        place = self.root / page

        def included(match):
            source = self.resolve(place, match[1])
            return LINK.sub(lambda link: self.rebased(link, source, place), source.read_text())

        text = LINK.sub(lambda link: self.rebased(link, place, place), text)
        text = INCLUDED.sub(included, text)
        return text if repository else LINK.sub(lambda link: self.without_repetition(link, place), text)

    def rebased(self, link, source, place):
        """A link of the file `source` as one of the page at `place`."""
        label, target = link[1], link[2]
        if target is None or "://" in target or target.startswith(("#", "mailto:")):
            return link[0]
        path, mark, anchor = target.partition("#")
        file = self.resolve(source, path)
        if file in self.places:
            file = self.root / self.places[file]
        elif source == place:
            return link[0]
        return f"[{label}]({os.path.relpath(file, place.parent)}{mark}{anchor})"

    def without_repetition(self, link, place):
        """A link out of the book is its label, where that names the file: the next preprocessor would write the path behind it."""
        label, target = link[1], link[2]
        if target is None or "://" in target or target.startswith("#"):
            return link[0]
        file = self.resolve(place, target.partition("#")[0])
        name = label.strip("`")
        names_it = name == file.stem or str(file).endswith(f"/{name}")
        return label if names_it and not file.is_relative_to(self.root) else link[0]
