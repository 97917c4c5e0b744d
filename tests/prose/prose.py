"""Sentences, comments and phrases of a text, as `check.py` counts them."""

import io
import re
import tokenize

PHRASES = {
    "so many": r"so many",
    "is told": r"(?:is|are|was|were|be|been) told",
    "stand, stands": r"stands?",
    "beside": r"beside",
    "of which, of whom": r"of (?:which|whom)",
    "nothing else running": r"nothing else (?:ran|running)|with nothing else",
    "times of day": r"(?:at|of) (?:noon|night)|night of|in the (?:morning|evening|afternoon)|that evening|same evening",
    "dates": r"\d{1,2} (?:January|February|March|April|May|June|July|August|September|October|November|December)"
             r"(?: \d{4})?|on the \d{1,2}th|\d{4}-\d{2}-\d{2}",
}
PATTERNS = {name: re.compile(rf"\b(?:{words})\b", re.IGNORECASE) for name, words in PHRASES.items()}

OFF = re.compile(r"<!-- prose: off -->.*?<!-- prose: on -->", re.DOTALL)
FENCE = re.compile(r"^ *```.*?^ *```[^\n]*$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
SENTENCE_END = re.compile(r"(?<=[.!?])[\"')\]*_]*\s+(?=[\"'(\[*_`]*[^\sa-z])")
ABBREVIATION = re.compile(r"\b(?:e\.g|i\.e|cf|vs|etc|Fig|Eq|Sec|No|al|resp|approx)\.$")


def without_code(text):
    """A page without excluded parts, fenced code and code that is indented by four spaces after an empty line."""
    text = FENCE.sub("", OFF.sub("", text))
    kept, after_empty, in_code = [], True, False
    for line in text.splitlines():
        indented = line.startswith("    ") and not line.lstrip().startswith(("- ", "* "))
        in_code = indented and (in_code or after_empty)
        if not in_code:
            kept.append(line)
        after_empty = not line.strip() or line.startswith("#") or in_code
    return "\n".join(kept)


def is_table(line):
    return line.lstrip().startswith("|")


def outside_tables(text):
    """All words of a page that are neither code nor in a table, on one line."""
    lines = [line for line in without_code(text).splitlines() if not is_table(line)]
    return " ".join(" ".join(lines).split())


def paragraphs(text):
    """The paragraphs and list items of a page: no headings, tables, pictures or code."""
    found, current = [], []
    for line in [*without_code(text).splitlines(), ""]:
        bare = line.strip()
        item = re.match(r"(?:[-*]|\d+\.) ", bare)
        ends = not bare or bare.startswith("#") or is_table(line) or bare.startswith("<")
        if (ends or item) and current:
            found.append(LINK.sub(r"\1", " ".join(current)))
            current = []
        if not ends:
            current.append(bare[item.end():] if item else bare)
    return found


def sentences(paragraph):
    """The sentences of a paragraph. An abbreviation ends none."""
    found = []
    for part in SENTENCE_END.split(paragraph):
        if found and ABBREVIATION.search(found[-1]):
            found[-1] += " " + part
        else:
            found.append(part)
    return [sentence for sentence in found if words(sentence)]


def words(sentence):
    """The words of a sentence: code is one word, numbers and signs are none."""
    return re.findall(r"[^\W\d_](?:[\w'’-]*\w)?", re.sub(r"`[^`]*`", " code ", sentence))


def long_sentences(texts, most=40):
    """The sentences with more than `most` words, and the number of all."""
    everything = [sentence for text in texts for sentence in sentences(text)]
    return [sentence for sentence in everything if len(words(sentence)) > most], len(everything)


def phrases(text):
    """Each phrase of a text with the words around it."""
    text = " ".join(text.split())
    for name, pattern in PATTERNS.items():
        for match in pattern.finditer(text):
            yield name, text[max(match.start() - 60, 0):match.end() + 60]


def comments_of(path):
    """The comments of a source file, those on lines one after the other joined."""
    text = path.read_text()
    lines = python_comments(text) if path.suffix == ".py" else line_comments(text, r"//[/!]?" if path.suffix == ".rs" else "#")
    blocks, last = [], None
    for number, comment in lines:
        if last is not None and number == last + 1:
            blocks[-1] += " " + comment
        else:
            blocks.append(comment)
        last = number
    return blocks


def line_comments(text, mark):
    """The numbers and texts of lines with a comment. A mark inside a string counts where an even number of quotes precedes it."""
    pattern = re.compile(rf"(?:^|\s){mark} ?(.*)$")
    for number, line in enumerate(text.splitlines()):
        match = pattern.search(line)
        if match and line[:match.start()].count('"') % 2 == 0:
            yield number, match.group(1)


def python_comments(text):
    """Comments and documentation strings."""
    begins_statement = True
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string.lstrip("#! ")
        elif token.type == tokenize.STRING and begins_statement and token.string.lstrip("rbfu").startswith('"""'):
            yield token.start[0], token.string.strip('rbfu"')
        if token.type not in (tokenize.COMMENT, tokenize.NL):
            begins_statement = token.type in (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
