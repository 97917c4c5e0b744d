"""Formulas of head comments: python3 -m unittest discover -s tests/book"""

import unittest

from mathml import Unknown
from plain_formulas import latex, typeset_head


class PlainFormulas(unittest.TestCase):
    def test_latex(self):
        self.assertEqual(latex("∫_ΓC σ_n"), r"\int _{Γ_{C}} σ_{n}")
        self.assertEqual(latex("e^((x−1)/ε)"), "e^{(x-1)/ε}")
        self.assertEqual(latex("√(F/(π R))"), r"\sqrt{F/(π R)}")
        self.assertEqual(latex("ln(t²)"), r"\operatorname{ln}(t^{2})")
        self.assertEqual(latex("r ln r"), r"r \,\operatorname{ln}\, r")
        with self.assertRaises(Unknown):
            latex("e^(x")

    def test_only_formulas_of_the_head(self):
        page = "Run `cargo run`, −Δu: `−Δu = 1`.\n\n## The program\n`−Δu`"
        text = typeset_head(page)
        self.assertIn("`cargo run`", text)
        self.assertIn('<math display="inline">', text)
        self.assertTrue(text.endswith("`−Δu`"))

    def test_blocks(self):
        self.assertIn('<math display="block">', typeset_head("a\n\n```text\nu² = 1\n```\n"))
        self.assertIn("```rust", typeset_head("```rust\nlet u² = 1;\n```"))


if __name__ == "__main__":
    unittest.main()
