use forms_core::forms;

/// Each function doubles the one before: 2¹⁷ products.
#[forms(crate = forms_core)]
pub mod doubling {
    fn f1(a: Scalar) -> Scalar { a * a + a * a }
    fn f2(a: Scalar) -> Scalar { f1(a) + f1(a * a) }
    fn f3(a: Scalar) -> Scalar { f2(a) + f2(a * a) }
    fn f4(a: Scalar) -> Scalar { f3(a) + f3(a * a) }
    fn f5(a: Scalar) -> Scalar { f4(a) + f4(a * a) }
    fn f6(a: Scalar) -> Scalar { f5(a) + f5(a * a) }
    fn f7(a: Scalar) -> Scalar { f6(a) + f6(a * a) }
    fn sum(a: Scalar) -> Scalar { f7(a) + f7(2 * a) + f7(3 * a) + f7(4 * a) + f7(5 * a) + f7(6 * a) + f7(7 * a) }
    fn sums(a: Scalar) -> Scalar { sum(a) + sum(2 * a) + sum(3 * a) + sum(4 * a) + sum(5 * a) + sum(6 * a) }
    fn large(a: Scalar) -> Scalar { sums(a) + sums(2 * a) + sums(3 * a) + sums(4 * a) + sums(5 * a) + sums(6 * a) }
    fn larger(a: Scalar) -> Scalar { large(a) + large(2 * a) + large(3 * a) + large(4 * a) + large(5 * a) }
}

fn main() {}
