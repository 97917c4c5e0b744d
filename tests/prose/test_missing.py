"""What the pages call missing is missing.

Three checks, as far as text allows. A name of another language that a page calls missing is no name of ours. A claim of
`CLAIMS` is still on its page, and no source refutes it. Every list of what is missing has a claim here or is in `WITHOUT_CHECK`.

    python3 -m unittest discover -s tests/prose
"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILTINS = "forms-macro/compiler/src/check/builtins.rs"

# page, words on it, source files, a pattern there: the claim is wrong if the pattern is found (or, with "needs", not found).
CLAIMS = [
    ("docs/operators.md", "degrees above 4", "fem/mesh/src/element/lagrange.rs", r"the degrees are 1 to 4", "needs"),
    ("docs/operators.md", "prisms and pyramids", "fem/mesh/src/element/shape.rs", r"\b(?:Prism|Pyramid|Wedge)\b", "refutes"),
    ("docs/operators.md", "H(div) and H(curl) elements", "fem/mesh/src/element/families.rs", r"(?i)thomas|n[eé]d[eé]lec|h_?div|h_?curl|piola", "refutes"),
    ("docs/operators.md", "complex numbers", "forms-macro/compiler/src/check/*.rs", r"\bComplex\b", "refutes"),
    ("docs/operators.md", "Bessel functions", BUILTINS, r"(?i)bessel", "refutes"),
    ("docs/operators.md", "`Assembler::action`", "fem/problem/src/assemble/action.rs", r"pub fn action", "needs"),
    ("docs/capabilities.md", "no prisms or pyramids", "fem/mesh/src/element/shape.rs", r"\b(?:Prism|Pyramid|Wedge)\b", "refutes"),
    ("docs/capabilities.md", "Remeshing during shape optimisation is 2D only", "fem/mesh/src/mesh/remeshing/*.rs", r"Mesh<3>|Mesh<D>", "refutes"),
    ("docs/capabilities.md", "at most 4096 unknowns", "fem/problem/src/constraints/mean_value.rs", r"const MOST: usize = 4096;", "needs"),
    ("docs/capabilities.md", "In 3D all cells of a mesh have one shape", "fem/mesh/src/mesh/mod.rs", r"All cells have one shape, or, in the", "needs"),
    ("docs/capabilities.md", "Histories at quadrature points", "fem/src/inverse/error.rs", r"what a step writes at quadrature points has no adjoint here", "needs"),
    ("docs/capabilities.md", "pairs that slide in time", "fem/src/inverse/error.rs", r"adjoints of such motions are not available", "needs"),
    ("docs/capabilities.md", "LU with pivoting, run on one thread with their solves", "fem/linear_algebra/src/lu.rs", r"rayon|Par::[Rr]ayon", "refutes"),
    ("docs/capabilities.md", "Pictures are two-dimensional", "fem/problem/src/output/picture/*.rs", r"(?:Field|Mesh)<3>", "refutes"),
    ("docs/inverse_problems.md", "`MotionHistory` refuses them by name", "fem/src/inverse/motion_history.rs", r"is_on_displaced_surfaces", "needs"),
    ("docs/capabilities.md", "Lagrange of degree 1 to 4", "fem/mesh/src/element/lagrange.rs", r"the degrees are 1 to 4", "needs"),
    ("docs/eigenproblems.md", "Complex eigenvalues", "fem/linear_algebra/src/eigenpairs.rs", r"\b(?:Complex|c64)\b", "refutes"),
    ("docs/continuation.md", "Histories, several processes, other linear solvers", "fem/problem/src/solve/continuation.rs", r"pub fn (?:on|solver)\(", "refutes"),
    ("docs/shape_optimisation.md", "Remeshing is 2D only", "fem/mesh/src/mesh/remeshing/*.rs", r"Mesh<3>|Mesh<D>", "refutes"),
]
# Pages with a list of what is missing that no source text can decide.
WITHOUT_CHECK = {"docs/python.md", "docs/time.md"}


def text(path):
    return (ROOT / path).read_text()


def section(page, heading):
    """The lines below a heading, up to the next one."""
    found = re.search(rf"^## {heading}$(.*?)(?=^## |\Z)", text(page), re.MULTILINE | re.DOTALL)
    return found.group(1) if found else ""


def built_in_names():
    return set(re.findall(r'^\s*\("(\w+)",.*(?:Builtin|Constant)::', text(BUILTINS), re.MULTILINE))


def names_of_code(words):
    """The names in the code of a text, without arguments."""
    return {name for code in re.findall(r"`([^`]+)`", words) for name in re.findall(r"^([A-Za-z_]\w*)(?:\(|$)", code)}


class Missing(unittest.TestCase):
    def test_names_that_are_missing_are_not_built_in(self):
        names = names_of_code(section("docs/operators.md", "Missing here")) - {"derivative"}
        # Rows whose first column says that there is no such operator here.
        for row in re.findall(r"^\| — \|(.*)\|$", text("docs/operators.md"), re.MULTILINE):
            names |= names_of_code(row)
        self.assertIn("elem_mult", names)
        self.assertIn("facet_avg", names)
        ours = built_in_names()
        self.assertIn("dot", ours)
        self.assertIn("facet_area", ours)
        self.assertEqual(names & ours, set())

    def test_names_that_are_missing_are_no_functions_of_the_assembler(self):
        names = names_of_code(section("docs/operators.md", "Missing here")) - {"derivative"}
        ours = {name for source in (ROOT / "fem/problem/src/assemble").rglob("*.rs")
                for name in re.findall(r"pub fn (\w+)", source.read_text())}
        self.assertIn("functional", ours)
        self.assertEqual(names & ours, set())

    def test_claims(self):
        for page, words, pattern, sign, kind in CLAIMS:
            with self.subTest(page=page, words=words):
                self.assertTrue(words in " ".join(text(page).split()), "the page has changed: change the claim, too")
                sources = sorted(ROOT.glob(pattern))
                self.assertTrue(sources, pattern)
                found = any(re.search(sign, source.read_text()) for source in sources)
                self.assertEqual(found, kind == "needs", f"{pattern}: {sign}")

    def test_each_line_of_the_main_list_has_a_claim(self):
        lines = [line for line in section("docs/capabilities.md", "What is missing").splitlines() if line.startswith("- ")]
        claims = [words for page, words, *_ in CLAIMS if page == "docs/capabilities.md"]
        self.assertGreaterEqual(len(lines), 5)
        self.assertEqual([line for line in lines if not any(words in line for words in claims)], [])

    def test_each_list_has_a_claim(self):
        heading = re.compile(r"^## (?:What is missing|Missing here)$", re.MULTILINE)
        lists = {f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md") if heading.search(page.read_text())}
        checked = {page for page, *_ in CLAIMS}
        self.assertEqual(lists - checked, WITHOUT_CHECK, "write a claim, or name the page in WITHOUT_CHECK")


if __name__ == "__main__":
    unittest.main()
