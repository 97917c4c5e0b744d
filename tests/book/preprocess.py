"""The preprocessor of the book for formulas and links, as docs/book.toml names it. mdBook runs it."""

import json
import sys
from pathlib import Path

from links import Links
from mathml import typeset


def chapters(value):
    """The chapters below a value of the book that have a page."""
    if isinstance(value, list):
        for item in value:
            yield from chapters(item)
    elif isinstance(value, dict):
        if isinstance(chapter := value.get("Chapter"), dict) and chapter.get("path"):
            yield chapter
        for member in value.values():
            yield from chapters(member)


def main():
    if sys.argv[1:2] == ["supports"]:
        return
    context, book = json.load(sys.stdin)
    root = Path(context["root"]) / context["config"]["book"]["src"]
    repository = context["config"]["output"]["html"].get("git-repository-url")
    found = list(chapters(book))
    links = Links(root, {chapter["path"]: chapter["content"] for chapter in found})
    for chapter in found:
        text = links.in_page(chapter["path"], chapter["content"], repository)
        chapter["content"] = typeset(chapter["path"], text)
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
