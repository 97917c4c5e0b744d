//! The forms of the paper, unchanged from the repository.

use super::comparison::compare;
use super::emitted::read;
use super::source::Source;
use crate::reuse::flatten;

/// Found by random forms: the derivative of a jump is zero, yet a term with a jump is no load.
#[test]
fn what_jumps_is_neither_constant_nor_linear() {
    let form = |density: &str| {
        let text = format!(
            "mod m {{ #[cells] struct Omega; fn f(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {{
                integral(Omega, ({density}) * v) }} }}"
        );
        read(Source::new(2, &text).emitted()).remove("f").expect("a form").residual
    };
    for density in
        ["heaviside(u)", "sign(u) * h", "u + heaviside(u)", "if u > 1 { u } else { 2 + u }", "atan2(0, u)"]
    {
        let dependence: Vec<_> = form(density).iter().map(|one| one.dependence.clone()).collect();
        assert!(dependence.iter().any(|one| one == "Nonlinear"), "{density}: {dependence:?}");
    }
    assert_eq!(form("2 * u")[0].dependence, "Linear");
    assert_eq!(form("heaviside(h - 1)")[0].dependence, "Constant");
}

/// Found by random forms: log₁₀ brings the factor 1/ln 10, and a sum divided by its first coefficient had 0.999… there; it did
/// not cancel against itself, and the kernel divided by a derivative that is zero.
#[test]
fn what_is_taken_out_cancels() {
    let text = "mod m { #[interior_facets] struct Skeleton;
        fn e(u: Unknown<Vector>) -> Energy {
            let a = log10(2.5 + cos(other(diff(sin(inner(u, u)) * dot(u, x), u)[0])));
            integral(Skeleton, div(grad(ln(2.5 + cos(neg_part(a))))))
        } }";
    let compared =
        compare(&Source::new(3, text), 1).unwrap_or_else(|difference| panic!("{difference}")).compared;
    assert!(compared > 20, "{compared} numbers compared");
}

/// Found by random forms: an integral may vanish from the residual and leave something in another list. Its region is asked
/// for all the same.
#[test]
fn a_region_stays_whose_integral_is_zero() {
    let text = "mod m { #[cells] struct Omega; #[facets] struct Gamma;
        fn f(u: Unknown<Scalar>, q: State<Scalar>, v: Test<Scalar>) -> Form {
            integral(Omega, 0 * u * v) + integral(Gamma, derivative(q * q, q, q) * v - 2 * q * q * v)
        }
        fn s(u: Unknown<Scalar>, q: State<Scalar>, v: Test<Scalar>) -> Form {
            derivative(integral(Omega, u * v) + integral(Gamma, u * q * v), q, q)
        } }";
    let functions = read(Source::new(2, text).emitted());
    for name in ["f", "s"] {
        assert_eq!(functions[name].argument_types, ["Omega", "Gamma"], "{name}");
    }
}

/// A derivative may be a node that is used elsewhere as well: only what bears the name is varied.
#[test]
fn a_name_for_a_derivative_varies_alone() {
    let text = "mod m { #[cells] struct Omega; struct Data { k: Param }
        pub fn e(u: State<Scalar>, q: State<Scalar>) -> Scalar {
            let w = derivative(u, u, q);
            diff(w * u * k + q * u, w)
        }
        pub fn t(u: State<Vector>, q: State<Vector>) -> Tensor {
            let w = derivative(u, u, q);
            diff(dot(w, q) * w, w) + outer(u, u)
        }
        fn f(u: Unknown<Scalar>, q: State<Scalar>, v: Test<Scalar>) -> Form {
            integral(Omega, { let w = derivative(u * u, u, q) / u; diff(w * w + q * w, w) } * v)
        } }";
    let source = Source::new(2, text);
    let compared = compare(&source, 1).unwrap_or_else(|difference| panic!("{difference}")).compared;
    assert!(compared > 10, "{compared} numbers compared");
}

#[test]
fn the_forms_of_the_paper() {
    let text = flatten::nitsche();
    for dimension in [2, 3] {
        let source = Source::new(dimension, &text);
        let mut compared = 0;
        for seed in 0..4 {
            compared += compare(&source, seed).unwrap_or_else(|difference| panic!("{difference}")).compared;
        }
        assert!(compared > 500, "{compared} numbers compared");
    }
}
