"""docs/speed.md agrees with the measurements next to it: means, rows of tables, ratios.

    python3 -m unittest discover -s tests/prose
"""

import csv
import math
import re
import unittest
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def rows(name):
    with open(DOCS / name, newline="") as file:
        return list(csv.DictReader(file))


def geometric_mean(kernels, instructions):
    ratios = [float(row[f"{instructions} FFCx (ns)"]) / float(row[f"{instructions} here (ns)"]) for row in kernels]
    return math.exp(sum(map(math.log, ratios)) / len(ratios))


class Speed(unittest.TestCase):
    def setUp(self):
        self.page = (DOCS / "speed.md").read_text()
        self.kernels = rows("speed_kernels.csv")

    def test_each_form_counts_once(self):
        forms = [row["form"] for row in self.kernels]
        self.assertEqual(len(set(forms)), len(forms))
        self.assertIn(f"all {len(forms)} forms", self.page)
        self.assertFalse([form for form in forms if "sum" in form])

    def test_geometric_means(self):
        avx512, avx2 = (geometric_mean(self.kernels, name) for name in ("AVX-512", "AVX2"))
        self.assertIn(f"ratios is {avx512:.2f} with AVX-512", self.page)
        self.assertIn(f"and {avx2:.2f} with AVX2", self.page)
        self.assertIn(f"geometric mean over {len(self.kernels)} forms | {avx512:.1f} times", self.page)

    def test_rows_of_kernels(self):
        recorded = {row["form"]: [row[f"{name} {column}"] for name in ("AVX-512", "AVX2") for column in ("here (ns)", "FFCx (ns)", "ratio")]
                    for row in self.kernels}
        table = self.page.split("## Element kernels")[1].split("## Assembly")[0]
        shown = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines() if line.startswith("| ")][1:]
        shown = [row for row in shown if not row[0].startswith("-")]
        self.assertEqual(len(shown), 4)
        for form, *numbers in shown:
            self.assertEqual(numbers, recorded[form], form)

    def test_rows_of_assembly(self):
        names = {"DOLFINx, its default matrix": "DOLFINx", "DOLFINx, block matrix": "DOLFINx with a block matrix",
                 "GetFEM": "GetFEM", "FreeFEM": "FreeFEM", "scikit-fem": "scikit-fem"}
        recorded = {(row["mesh"], row["program"]): row for row in rows("speed_assembly.csv")}
        for shown, program in names.items():
            cells = next(line for line in self.page.splitlines() if line.startswith(f"| {shown} |")).split("|")[2:8]
            for place, cell in enumerate(cells):
                mesh = ("triangles", "tetrahedra", "annulus")[place // 2]
                column = ("assembly (s)", "first assembly (s)")[place % 2]
                if not cell.strip():
                    continue
                seconds, ratio = map(float, re.fullmatch(r" ([\d.]+) \(([\d.]+)\) ", cell).groups())
                own = float(recorded[mesh, "this library"][column])
                self.assertEqual(seconds, float(recorded[mesh, program][column]), (shown, mesh))
                # Times have three digits and ratios are rounded to one or no decimal.
                self.assertLess(abs(seconds / own - ratio), 0.5 + 0.005 * ratio if ratio >= 10 else 0.1, (shown, mesh))


if __name__ == "__main__":
    unittest.main()
