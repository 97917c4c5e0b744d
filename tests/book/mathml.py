"""Formulas as MathML, which a browser shows without a script: blocks ```math of a page and formulas in text, $u_n$.

Pages hold LaTeX, as GitHub shows it. The part of LaTeX that is known is in the tables below; anything else is an error with the
page's name, so that no formula is shown wrongly.
"""

import html
import re
import sys

IDENTIFIERS = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "varepsilon": "ε", "eta": "η", "theta": "θ", "kappa": "κ", "lambda": "λ",
    "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ", "tau": "τ", "varphi": "φ", "omega": "ω", "Gamma": "Γ", "Theta": "Θ",
    "Pi": "Π", "Phi": "Φ", "Omega": "Ω", "ell": "ℓ",
}
OPERATORS = {
    "int": "∫", "partial": "∂", "nabla": "∇", "cdot": "·", "otimes": "⊗", "le": "≤", "ge": "≥", "approx": "≈", "in": "∈",
    "pm": "±", "to": "→", "|": "‖", "{": "{", "}": "}",
}
BARS = ("lvert", "rvert")
# As a number: the sign itself would end the cell of a table.
BAR = '<mo stretchy="false" lspace="0" rspace="0">&#124;</mo>'
SPACES = {"quad": 1.0, "qquad": 2.0, ",": 0.17, ";": 0.28, " ": 0.25, "!": -0.17}
ACCENTS = {"tilde": "~", "hat": "^", "bar": "¯", "dot": "˙"}
TOKEN = re.compile(r"\s+|\\([A-Za-z]+|.)|([0-9]+(?:\.[0-9]+)?)|(.)", re.DOTALL)
BLOCK = re.compile(r"^```math\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# Code of any kind, which has no formulas, or a formula in text.
INLINE = re.compile(r"^ *```.*?^ *```$|^    .*?$|(`+).*?\1|(?<![\\$\w])\$(?![\s$])([^$\n]+?)(?<!\s)\$(?![\w$])", re.DOTALL | re.MULTILINE)


class Unknown(Exception):
    """A formula that is not of the part of LaTeX that is known."""


class Reader:
    """Reads a formula from the left to the right."""

    def __init__(self, latex):
        self.tokens = []
        for match in TOKEN.finditer(latex):
            command, number, sign = match.groups()
            if command is not None:
                self.tokens.append(("command", command))
            elif number is not None:
                self.tokens.append(("number", number))
            elif sign is not None:
                self.tokens.append(("sign", sign))
        self.latex, self.place = latex, 0

    def peek(self):
        return self.tokens[self.place] if self.place < len(self.tokens) else ("end", "")

    def next(self):
        token = self.peek()
        self.place += 1
        return token

    def expect(self, sign):
        if self.next() != ("sign", sign):
            raise Unknown(f"{sign} is missing")

    def row(self, *ends):
        """The formula up to one of some tokens, which is not read."""
        parts = []
        while self.peek() not in ends:
            if self.peek()[0] == "end":
                if ends and ("end", "") not in ends:
                    raise Unknown(f"{ends[0][1]} is missing")
                break
            parts.append(self.with_scripts())
        return parts[0] if len(parts) == 1 else f"<mrow>{''.join(parts)}</mrow>"

    def group(self):
        """What is in braces, or the next sign."""
        if self.peek() == ("sign", "{"):
            self.next()
            inside = self.row(("sign", "}"))
            self.expect("}")
            return inside
        kind, value = self.peek()
        if kind == "number" and len(value) > 1:
            # Without braces it is one digit: \\tfrac12 is a half.
            self.tokens[self.place:self.place + 1] = [("number", value[0]), ("number", value[1:])]
        return self.atom()

    def words(self):
        """The text in braces, spaces included."""
        self.expect("{")
        words = []
        while (token := self.next()) != ("sign", "}"):
            if token[0] == "end" or token[0] == "command":
                raise Unknown(f"words end with }}, not with {token[1]}")
            words.append(token[1])
        return "".join(words)

    def with_scripts(self):
        base, below, above = self.atom(), None, ""
        while True:
            if self.peek() == ("sign", "_"):
                self.next()
                below = self.group()
            elif self.peek() == ("sign", "^"):
                self.next()
                above += self.group()
            elif self.peek() == ("sign", "'"):
                # Next to its letter: as a superscript it is too small and too high in most fonts.
                self.next()
                base = f'<mrow>{base}<mo lspace="0" rspace="0">′</mo></mrow>'
            else:
                break
        if below and above:
            return f"<msubsup>{base}{below}<mrow>{above}</mrow></msubsup>"
        if below:
            return f"<msub>{base}{below}</msub>"
        return f"<msup>{base}<mrow>{above}</mrow></msup>" if above else base

    def atom(self):
        kind, value = self.next()
        if kind == "number":
            return f"<mn>{value}</mn>"
        if kind == "sign":
            return self.sign(value)
        if kind == "command":
            return self.command(value)
        raise Unknown("the formula ends too early")

    def sign(self, value):
        if value == "{":
            self.place -= 1
            return self.group()
        if value.isalpha():
            return f"<mi>{value}</mi>"
        if value in "+-=:,;()[]|/<>.⟦⟧":
            if value in "+-" and self.begins_term():
                return f'<mo form="prefix">{"−" if value == "-" else value}</mo>'
            # Brackets have the size of the text.
            rigid = ' stretchy="false"' if value in "()[]⟦⟧" else ""
            return f"<mo{rigid}>{html.escape('−' if value == '-' else value)}</mo>" if value != "|" else BAR
        raise Unknown(f"what is {value}?")

    def begins_term(self):
        """Whether the sign that has just been read has nothing on its left to be added to."""
        kind, before = self.tokens[self.place - 2] if self.place > 1 else ("sign", "(")
        return before in "=([,<>:&{/" if kind == "sign" else kind == "command" and before in ("le", "ge", "approx", "\\")

    def command(self, name):
        if name in IDENTIFIERS:
            return f"<mi>{IDENTIFIERS[name]}</mi>"
        if name in OPERATORS:
            return f'<mo stretchy="false">{OPERATORS[name]}</mo>'
        if name in BARS:
            return BAR
        if name in SPACES:
            return f'<mspace width="{SPACES[name]}em"/>'
        if name in ("frac", "tfrac"):
            above, below = self.group(), self.group()
            fraction = f"<mfrac>{above}{below}</mfrac>"
            return fraction if name == "frac" else f'<mstyle displaystyle="false">{fraction}</mstyle>'
        if name == "sqrt":
            return f"<msqrt>{self.group()}</msqrt>"
        if name in ACCENTS:
            return f'<mover accent="true">{self.group()}<mo stretchy="false">{ACCENTS[name]}</mo></mover>'
        if name in ("mathrm", "operatorname"):
            return f"<mi>{self.words()}</mi>"
        if name == "text":
            return f"<mtext>{self.text()}</mtext>"
        if name == "left":
            opening = self.next()[1]
            inside = self.row(("command", "right"))
            self.next()
            closing = self.next()[1]
            return f"<mrow><mo>{opening}</mo>{inside}<mo>{closing}</mo></mrow>"
        if name == "begin":
            return self.table()
        raise Unknown(f"what is \\{name}?")

    def text(self):
        """The words of \\text, whose spaces the tokens do not have."""
        found = re.match(r"\\text\{([^{}\\]*)\}", self.latex[self.position_of_text():])
        self.words()
        return html.escape(found.group(1)).replace(" ", "&#160;")

    def position_of_text(self):
        """The place of the \\text that has just been read: the number of those before it says which one it is."""
        before = sum(token == ("command", "text") for token in self.tokens[:self.place])
        return [match.start() for match in re.finditer(r"\\text\b", self.latex)][before - 1]

    def table(self):
        """The rows of an environment `aligned`: columns in pairs, the first on the right and the second on the left."""
        if self.words() != "aligned":
            raise Unknown("the only environment is aligned")
        ends = ("sign", "&"), ("command", "\\"), ("command", "end")
        rows = [[]]
        while True:
            rows[-1].append(self.row(*ends))
            end = self.next()
            if end == ("command", "\\"):
                rows.append([])
            elif end == ("command", "end"):
                break
        if self.words() != "aligned":
            raise Unknown("aligned does not end")
        # Chromium and Firefox align the block in a cell by the value with a prefix, others by the one without.
        cell = '<mtd style="text-align: {0}; text-align: -webkit-{0}; padding: 0.3em 0.1em">{1}</mtd>'
        cells = ("".join(cell.format(("right", "left")[at % 2], one) for at, one in enumerate(row)) for row in rows)
        return f"<mtable displaystyle=\"true\">{''.join(f'<mtr>{row}</mtr>' for row in cells)}</mtable>"


def mathml(latex, display=True):
    """A formula: displayed by itself, or in text."""
    kind = "block" if display else "inline"
    return f'<math display="{kind}">{Reader(latex).row(("end", ""))}</math>'


def typeset(page, text):
    """A page with its formulas as MathML. A div lets wide ones scroll in narrow windows."""
    def formula(latex, display):
        try:
            return mathml(latex, display)
        except Unknown as error:
            sys.exit(f"{page}: {error} In the formula\n{latex}")
    text = BLOCK.sub(lambda match: f'<div class="formula">\n{formula(match[1], True)}\n</div>', text)
    return INLINE.sub(lambda match: formula(match[2], False) if match[2] else match[0], text)
