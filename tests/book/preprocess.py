"""The preprocessor of the book for formulas and links, as docs/book.toml names it. mdBook runs it.

With the argument `heads` it typesets the formulas in head comments of programs, which are on the pages by then.
"""

import json
import sys
from pathlib import Path

from links import Links
from mathml import Unknown, typeset
from plain_formulas import typeset_head


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
    if "supports" in sys.argv[1:]:
        return
    context, book = json.load(sys.stdin)
    root = Path(context["root"]) / context["config"]["book"]["src"]
    repository = context["config"]["output"]["html"].get("git-repository-url")
    found = list(chapters(book))
    if sys.argv[1:2] == ["heads"]:
        for chapter in found:
            if Path(chapter["path"]).parent.name == "tutorials":
                try:
                    chapter["content"] = typeset_head(chapter["content"])
                except Unknown as error:
                    sys.exit(f"{chapter['path']}: {error}")
        json.dump(book, sys.stdout)
        return
    links = Links(root, {chapter["path"]: chapter["content"] for chapter in found})
    for chapter in found:
        text = links.in_page(chapter["path"], chapter["content"], repository)
        chapter["content"] = typeset(chapter["path"], text)
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
