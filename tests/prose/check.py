"""The prose of pages and comments: counts the phrases that CONTRIBUTING.md replaces, and first lines of documentation that do
not name their item, and fails above a limit.

    python3 tests/prose/check.py                    # the table; exit code 1 above a limit
    python3 tests/prose/check.py --show NAME        # each place of one row

The limits form a ratchet: they may only be lowered. Lower one when its count has fallen; the table says where. The goals are
those of the project for pages and comments together. Text between the marks `<!-- prose: off -->` and `<!-- prose: on -->` is not counted.
"""

import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

from items import documented_items, first_line, is_riddle, is_verb_phrase, lacks_errors
from prose import comments_of, long_sentences, outside_tables, paragraphs, phrases, without_code

ROOT = Path(__file__).resolve().parents[2]

# name: (limit in pages, limit in comments, goal for both together)
LIMITS = {
    "so many": (0, 0, 0),
    "is told": (0, 0, 0),
    "stand, stands": (0, 0, 59),
    "beside": (0, 0, 79),
    "of which, of whom": (0, 0, 19),
    "nothing else running": (0, 0, 0),
    "times of day": (0, 0, 0),
}
# Dates in user pages (README and docs without decisions), outside tables and code.
DATES = (0, 0)
# Sentences with more than 40 words in pages, per thousand sentences.
LONG_SENTENCES = (6, 20)

# Public items of these directories with documentation: limits, a ratchet too. First lines are noun phrases, those of functions too.
DOCUMENTED = ("fem/*.rs", "contact/*.rs", "forms-core/*.rs")
NOT_DOCUMENTED = ("/tests/", "/tests.rs", "/benches/", "/examples/")
ITEM_LIMITS = {
    "first line refers or asks": 0,
    "verb first": 0,
    "Result without # Errors": 0,
}

# Lines of the user pages on what there was when they were rewritten (docs without decisions and the book's table of contents), half of
# those before: a ratchet. Pages on later features have a limit each.
USER_LINES = 1950
LATER_PAGES = {
    "bounds.md", "contact_bench.md", "contact_bench_bodies.md", "contact_bench_loads.md", "contact_bench_matrix.md", "contact_bench_problems.md", "contact_bench_programs.md", "continuation.md", "cut_backgrounds.md", "cut_domains.md", "gap_pressures.md", "level_set_descent.md", "mean_gaps.md", "mesh_parts.md", "mortar.md", "nearly_incompressible.md",
    "newton_failures.md", "points_segments_means.md", "sliding_histories.md", "smooth_formulations.md", "threads.md",
}
LATER_PAGE_LINES = 60

# Lines of a page, and characters of an entry in the changelog, which are two lines of a wide editor.
PAGE_LINES = {"README.md": 150, "docs/decisions/*.md": 60}
CHANGELOG_ENTRY = 240


def tracked(*patterns):
    """The files of the repository that match, new ones included."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )
    return sorted(path for name in set(listed.stdout.splitlines()) if (path := ROOT / name).is_file())


def is_user_page(path):
    name = path.relative_to(ROOT).as_posix()
    return name == "README.md" or (name.startswith("docs/") and not name.startswith("docs/decisions/"))


def sizes(pages):
    """The pages and the entries that are too long, a line each."""
    for path, text in pages.items():
        name = path.relative_to(ROOT).as_posix()
        for pattern, most in PAGE_LINES.items():
            if fnmatch(name, pattern) and name != "docs/decisions/README.md" and text.count("\n") > most:
                yield f"{name} has {text.count(chr(10))} lines, more than {most}"
    counted = {path: text.count("\n") for path, text in pages.items() if is_user_page(path) and path.name != "SUMMARY.md" and path.parent != ROOT}
    for path in [path for path in counted if path.name in LATER_PAGES]:
        if (later := counted.pop(path)) > LATER_PAGE_LINES:
            yield f"{path.name} has {later} lines, more than {LATER_PAGE_LINES}"
    lines = sum(counted.values())
    if lines > USER_LINES:
        yield f"the user pages have {lines} lines, more than {USER_LINES}"
    for entry in (ROOT / "CHANGELOG.md").read_text().splitlines():
        if entry.startswith("- ") and len(entry) > CHANGELOG_ENTRY:
            yield f"CHANGELOG.md: an entry has {len(entry)} characters, more than {CHANGELOG_ENTRY}: {entry[:60]}…"


def items_of_sources():
    """The items with a fault: (row of `ITEM_LIMITS`, place, first line)."""
    for path in tracked(*DOCUMENTED):
        name = path.relative_to(ROOT).as_posix()
        if any(part in f"/{name}" for part in NOT_DOCUMENTED):
            continue
        for number, kind, item, docs, signature in documented_items(path.read_text()):
            faults = {
                "first line refers or asks": is_riddle(docs),
                "verb first": is_verb_phrase(docs),
                "Result without # Errors": lacks_errors(kind, docs, signature),
            }
            for row in (row for row, fault in faults.items() if fault):
                yield row, f"{name}:{number} {kind} {item}", first_line(docs)


def main(arguments):
    shown = arguments[1] if arguments[:1] == ["--show"] else None
    pages = {path: path.read_text() for path in tracked("*.md")}
    sources = {path: comments_of(path) for path in tracked("*.rs", "*.py", ".ci/run")}

    counts = {name: [0, 0] for name in LIMITS}
    dates = long = sentences = 0
    for kind, texts in enumerate((pages, sources)):
        for path, text in texts.items():
            found = list(phrases(without_code(text) if kind == 0 else "\n\n".join(text)))
            for name in LIMITS:
                counts[name][kind] += sum(one == name for one, _ in found)
            if kind == 0:
                dated = [one for one in phrases(outside_tables(text)) if one[0] == "dates" and is_user_page(path)]
                dates += len(dated)
                found = [one for one in found if one[0] != "dates"] + dated
                longer, number = long_sentences(paragraphs(text))
                long, sentences = long + len(longer), sentences + number
                found += [("long sentences", sentence) for sentence in longer]
            if shown:
                print("".join(f"{path.relative_to(ROOT)}: {excerpt}\n" for name, excerpt in found if name == shown), end="")
    faults = list(items_of_sources())
    if shown:
        print("".join(f"{place}: {line}\n" for row, place, line in faults if row == shown), end="")
        return

    rows = [(name, *counts[name], *LIMITS[name]) for name in LIMITS]
    print(f"{'':22} {'pages':>7} {'limit':>6} {'comments':>9} {'limit':>6} {'goal':>5}")
    failed = False
    for name, in_pages, in_comments, page_limit, comment_limit, goal in rows:
        failed |= in_pages > page_limit or in_comments > comment_limit
        print(f"{name:22} {in_pages:7} {page_limit:6} {in_comments:9} {comment_limit:6} {goal:5}")
    per_thousand = round(1000 * long / max(sentences, 1))
    failed |= dates > DATES[0] or per_thousand > LONG_SENTENCES[0]
    print(f"{'dates in user pages':22} {dates:7} {DATES[0]:6} {'':9} {'':6} {DATES[1]:5}")
    print(f"{'long sentences, 1/1000':22} {per_thousand:7} {LONG_SENTENCES[0]:6} {'':9} {'':6} {LONG_SENTENCES[1]:5}")
    print(f"{long} of {sentences} sentences in pages have more than 40 words")
    for row, limit in ITEM_LIMITS.items():
        count = sum(one == row for one, _, _ in faults)
        failed |= count > limit
        print(f"{row:30} {'':9} {count:9} {limit:6}")
    too_long = list(sizes(pages))
    print("\n".join(too_long))
    if failed or too_long:
        sys.exit("too long, or above a limit: `check.py --show NAME` lists the places; CONTRIBUTING.md says what to write instead")


main(sys.argv[1:])
