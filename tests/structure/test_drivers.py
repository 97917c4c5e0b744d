"""Lengths of forms and drivers, counted in a file written here and in the project."""

import unittest

import drivers

FORMULATION = """mod other;
mod law {
    pub fn pressure(u: Vector) -> Scalar {
        u
    }
}

impl Formulation for Mine {
    fn solve(
        &self,
        case: &Case,
    ) -> Result<Outcome, Refusal> {
        let data = law::data();
        case.newton(data)
    }
}
"""


class Lengths(unittest.TestCase):
    def test_braces_and_signatures_do_not_count(self):
        self.assertEqual(list(drivers.lengths(FORMULATION)), [("mod", "law", 3), ("fn", "solve", 2)])

    def test_no_formulation_of_the_comparison_is_too_long(self):
        self.assertEqual(drivers.main(["--check"]), 0)


if __name__ == "__main__":
    unittest.main()
