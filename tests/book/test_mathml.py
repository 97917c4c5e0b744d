"""Formulas as MathML. Run by `.ci/run`: python3 -m unittest discover -s tests/book"""

import unittest
from xml.etree import ElementTree

from mathml import Reader, Unknown, mathml, typeset


def words(latex):
    """The text of a formula, without its structure."""
    return "".join(ElementTree.fromstring(mathml(latex)).itertext())


class Formulas(unittest.TestCase):
    def test_signs(self):
        self.assertEqual(words(r"\int_{\Gamma_C} \sigma_n(u) - \gamma"), "∫ΓCσn(u)−γ")
        self.assertEqual(words(r"\lvert a \rvert \le \|b\|"), "|a|≤‖b‖")
        self.assertEqual(words(r"\{x : \text{for all } v\}"), "{x:for all\xa0v}".replace("for all", "for\xa0all"))

    def test_structure(self):
        self.assertIn("<mfrac><mn>1</mn><mi>γ</mi></mfrac>", mathml(r"\frac{1}{\gamma}"))
        self.assertIn("<msub><mi>u</mi><mi>n</mi></msub>", mathml("u_n"))
        self.assertIn("<msubsup><mi>x</mi><mn>1</mn><mrow><mn>2</mn></mrow></msubsup>", mathml("x_1^2"))
        self.assertIn('<mover accent="true"><mi>p</mi>', mathml(r"\tilde p"))
        self.assertEqual(mathml(r"\begin{aligned} a &= b \\ c &= d \end{aligned}").count("<mtr>"), 2)

    def test_terms(self):
        self.assertEqual(mathml("a = -b - c").count('form="prefix"'), 1)
        self.assertEqual(mathml(r"\tfrac12 c"), mathml(r"\tfrac{1}{2} c"))

    def test_every_formula_is_well_formed(self):
        for latex in (r"M'(u) \cdot q", r"\left(I - \frac{n_x \otimes m}{m \cdot n_x}\right)", r"\tfrac12 [\![u]\!]", "a < b > c"):
            ElementTree.fromstring(mathml(latex))

    def test_unknown_commands_are_errors(self):
        for latex in (r"\foo", r"\frac{1", r"\begin{cases} a \end{cases}", "x_", r"\left( a"):
            with self.assertRaises(Unknown, msg=latex):
                Reader(latex).row(("end", ""))
        with self.assertRaises(SystemExit):
            typeset("page.md", "```math\n\\foo\n```\n")

    def test_pages(self):
        page = "costs $5 or $6\n\n```math\nu_n\n```\n\n`$x$` and $u_n$ and $u$\n\n    $ shell $x$\n\n```rust\n$x$\n```\n"
        shown = typeset("page.md", page)
        self.assertEqual(shown.count('<math display="block">'), 1)
        self.assertEqual(shown.count('<math display="inline">'), 2)
        self.assertIn("costs $5 or $6", shown)
        self.assertIn("`$x$`", shown)
        self.assertIn("    $ shell $x$", shown)
        self.assertIn("```rust\n$x$\n```", shown)


if __name__ == "__main__":
    unittest.main()
