"""Public Rust items and their documentation, as `check.py` counts them: the first line names the item, errors have a section."""

import re

# An item at the beginning of a line of source, outside of tests.
ITEM = re.compile(r"^\s*pub (?:const |async |unsafe |extern \"\w+\" )*(fn|struct|enum|trait|type|mod|union)\s+(\w+)")
RESULT = re.compile(r"\s*->\s*(?:[\w:]+::)?(?:Result|Outcome)\b")
# Words that begin a riddle or refer to another item.
RIDDLES = ("What", "Where", "How", "Which", "Who", "Why", "When", "If", "The same", "As", "Like", "Another", "That", "Those", "It", "Its", "Of", "Nothing")
RIDDLE = re.compile(rf"(?:{'|'.join(RIDDLES)})\b")
# A word in s before an article or the like: "Adds a row", but not "Values of a field". Some words are verbs before anything.
ALWAYS_VERBS = (
    "Accepts|Adds|Begins|Calls|Checks|Condenses|Descends|Draws|Fails|Finds|Forgets|Goes|Grows|Hands|Keeps|Lets|Loads|Looks|Makes|Marks|Minimises"
    "|Moves|Prescribes|Puts|Replaces|Sends|Shows|Solves|Stores|Takes|Tells|Tests|Writes"
)
ARTICLES = "an?|the|all|each|every|its|one|this|these|what|some|no|another|several|two|further"
VERB = re.compile(rf"(?:{ALWAYS_VERBS})\b(?! of\b)|[A-Z][a-z]+s (?:{ARTICLES})\b")
ERRORS = re.compile(r"^# Errors\b", re.MULTILINE)


def documented_items(source):
    """(line number, kind, name, documentation, signature) of each public item with a doc comment."""
    lines = source.splitlines()
    docs, attribute = [], 0
    for number, line in enumerate(lines):
        bare = line.strip()
        if bare.startswith("#[cfg(test)]") and number + 1 < len(lines) and lines[number + 1].strip().startswith("mod tests {"):
            return
        if attribute:
            attribute += bare.count("[") - bare.count("]")
            continue
        if bare.startswith("///"):
            docs.append(bare[3:].removeprefix(" "))
            continue
        if bare.startswith("#["):
            attribute = bare.count("[") - bare.count("]")
            continue
        found = ITEM.match(line)
        if found and docs:
            signature = line
            following = number
            while found[1] == "fn" and not re.search(r"[{;]\s*$", signature) and following + 1 < len(lines):
                following += 1
                signature += " " + lines[following].strip()
            yield number + 1, found[1], found[2], "\n".join(docs), signature
        docs = []


def first_line(docs):
    return docs.strip().split("\n")[0]


def is_riddle(docs):
    """True if the first line refers to another item, or asks, in place of naming this one."""
    return bool(RIDDLE.match(first_line(docs)))


def is_verb_phrase(docs):
    """True if the first line begins with a verb."""
    return bool(VERB.match(first_line(docs)))


def after_arguments(signature):
    """The text behind the list of arguments: the result, bounds and the body's beginning."""
    depth, start = 0, signature.find("(")
    # Bounds before the list may have parentheses of their own: `fn f<F: Fn(u32) -> u32>(..)`.
    angle = 0
    for place, character in enumerate(signature):
        arrow = character == ">" and signature[place - 1] == "-"
        angle += (character == "<") - (character == ">" and not arrow) if depth == 0 else 0
        if character == "(" and angle == 0:
            start = place
            break
    for place in range(start, len(signature)):
        depth += (signature[place] == "(") - (signature[place] == ")")
        if depth == 0:
            return signature[place + 1:]
    return ""


def lacks_errors(kind, docs, signature):
    """True for a function whose result may be an error that no section describes."""
    return kind == "fn" and bool(RESULT.match(after_arguments(signature))) and not ERRORS.search(docs)
