"""Formulas of programs' head comments, which are written in Unicode, as MathML: `∫_Ω σ(u):ε(v) = 0`.

In a head comment a formula is a code span, or a block ```text, with a sign that no code has; or one letter, as `n_y`. It becomes LaTeX, which
`mathml.py` reads. Anything unknown is an error with the page's name.
"""

import re

from mathml import Unknown, mathml

SIGNS = {
    "∫": r"\int ", "∂": r"\partial ", "∇": r"\nabla ", "·": r"\cdot ", "≤": r"\le ", "≥": r"\ge ", "−": "-", "½": r"\tfrac{1}{2}",
}
SUPERSCRIPTS = {"²": "2", "³": "3", "⁴": "4", "ʸ": "y"}
SUBSCRIPTS = {"₀": "0", "₋": "-"}
FUNCTIONS = ("cos", "div", "Div", "exp", "ln", "max", "sin")
# Characters of a formula that fits into a narrow window. A longer one scrolls by itself.
LONGEST = 40
FORMULA_SIGN = re.compile(f"[{''.join(SIGNS)}{''.join(SUPERSCRIPTS)}{''.join(SUBSCRIPTS)}√⟦⟧Δα-ωΑ-Ω]|^[A-Za-z](?:_[a-z])?$")
TOKEN = re.compile(r"_(\w+)|\^\(|√\(|([A-Za-z]{2,})|(.)", re.DOTALL)
SPAN = re.compile(r"^ *```text\n(.*?)^ *```$|^ *```.*?^ *```$|`([^`\n]+)`", re.DOTALL | re.MULTILINE)


def closing(text, start):
    """The place of the bracket that closes the one before `start`."""
    depth = 1
    for place in range(start, len(text)):
        depth += (text[place] == "(") - (text[place] == ")")
        if depth == 0:
            return place
    raise Unknown(") is missing")


def function(name, before, after):
    """The name of a function, apart from letters next to it: r ln r, but ln(r)."""
    begin = r"\," if re.search(r"[\w)] *$", before) else ""
    end = "" if after.startswith("(") else r"\,"
    return rf"{begin}\operatorname{{{name}}}{end}"


def latex(plain):
    """A formula in Unicode as LaTeX."""
    written, place = [], 0
    while place < len(plain):
        match = TOKEN.match(plain, place)
        subscript, word, sign = match.groups()
        place = match.end()
        if match[0] in ("^(", "√("):
            end = closing(plain, place)
            inside = latex(plain[place:end])
            written.append(f"^{{{inside}}}" if match[0] == "^(" else rf"\sqrt{{{inside}}}")
            place = end + 1
        elif subscript:
            # A region's letter has an index of its own: Γ_C in place of ΓC.
            inside = subscript if len(subscript) == 1 else f"{subscript[0]}_{{{subscript[1:]}}}"
            written.append(f"_{{{inside}}}")
        elif word:
            written.append(function(word, plain[:match.start()], plain[place:]) if word in FUNCTIONS else " ".join(word))
        elif sign in SUPERSCRIPTS:
            written.append(f"^{{{SUPERSCRIPTS[sign]}}}")
        elif sign in SUBSCRIPTS:
            written.append(f"_{{{SUBSCRIPTS[sign]}}}")
        else:
            written.append(SIGNS.get(sign, sign))
    return "".join(written)


def typeset_head(text):
    """The text of a page whose formulas in Unicode, up to the first heading of the second level, are typeset."""
    head, mark, rest = text.partition("\n## ")

    def formula(match):
        block, span = match[1], match[2]
        if block is not None and FORMULA_SIGN.search(block):
            return "\n".join(f'<div class="formula">{mathml(latex(line.strip()))}</div>' for line in block.splitlines())
        if span is not None and FORMULA_SIGN.search(span):
            typeset = mathml(latex(span), False)
            return typeset if len(span) <= LONGEST else f'<span class="formula">{typeset}</span>'
        return match[0]

    return SPAN.sub(formula, head) + mark + rest
