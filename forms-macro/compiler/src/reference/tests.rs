//! The evaluator against numbers worked out by hand and against central differences.

use super::functions::{function, power};
use super::number::Number;
use super::{Budget, Evaluator, Point};
use crate::proof::source::Source;
use crate::tensor::Function;

const FUNCTIONS: &[Function] = &[
    Function::Sqrt,
    Function::Exp,
    Function::Ln,
    Function::Sin,
    Function::Cos,
    Function::Tan,
    Function::Tanh,
    Function::Asin,
    Function::Acos,
    Function::Atan,
    Function::Sinh,
    Function::Cosh,
    Function::Asinh,
    Function::Atanh,
    Function::Log10,
    Function::Erf,
    Function::Erfc,
    Function::Abs,
    Function::Sign,
    Function::Heaviside,
    Function::PositivePart,
    Function::NegativePart,
];

#[test]
fn slopes_are_difference_quotients() {
    let moved = |x: f64| Number::real(x).moved(&Number::real(1.0), 0).moved(&Number::real(1.0), 1);
    for which in FUNCTIONS {
        for x in [0.3, 0.7] {
            let at = |x: f64| function(*which, &Number::real(x)).value();
            let dual = function(*which, &moved(x));
            let first = (at(x + 1e-4) - at(x - 1e-4)) / 2e-4;
            let second = (at(x + 1e-3) - 2.0 * at(x) + at(x - 1e-3)) / 1e-6;
            // h² f‴ / 6 with |f‴| < 200 here.
            assert!((dual.slope(1).value() - first).abs() < 1e-6, "{which:?} at {x}");
            assert!((dual.slope(1).slope(0).value() - second).abs() < 5e-4, "{which:?} at {x}, twice");
        }
    }
}

#[test]
fn powers_and_quotients() {
    // d/dx xˣ = xˣ (1 + ln x); d²/dx² x⁻³ = 12 x⁻⁵.
    let x = Number::real(1.7).moved(&Number::real(1.0), 0);
    let exact = 1.7_f64.powf(1.7) * (1.0 + 1.7_f64.ln());
    assert!((power(&x, &x).slope(0).value() - exact).abs() < 1e-14);
    let x = Number::real(-1.7).moved(&Number::real(1.0), 0).moved(&Number::real(1.0), 1);
    let second = power(&x, &Number::real(-3.0)).slope(1).slope(0).value();
    assert!((second - 12.0 / (-1.7_f64).powi(5)).abs() < 1e-14);
    let quotient = Number::real(1.0).over(&x).slope(1).slope(0).value();
    assert!((quotient - 2.0 / (-1.7_f64).powi(3)).abs() < 1e-14);
}

#[test]
fn the_error_function() {
    // Abramowitz and Stegun, table 7.1.
    for (x, exact) in [(0.5, 0.5204998778130465), (1.0, 0.8427007929497149), (2.0, 0.9953222650189527)] {
        assert!((super::error_function(x) - exact).abs() < 1e-15, "{x}");
    }
}

#[test]
fn kinks_follow_the_documented_conventions() {
    let at_zero = Number::real(0.0).moved(&Number::real(1.0), 0);
    for which in &FUNCTIONS[17..] {
        let dual = function(*which, &at_zero);
        assert_eq!((dual.value(), dual.slope(0).value()), (0.0, 0.0), "{which:?}");
    }
}

/// A vector field u and a scalar field s in 2D, with derivatives up to order 2.
fn point() -> Point {
    let u =
        vec![vec![0.5, -0.25], vec![0.1, 0.2, 0.3, -0.4], vec![0.7, 0.6, 0.6, -0.5, 0.2, -0.1, -0.1, 0.9]];
    let s = vec![vec![0.8], vec![1.5, -2.0], vec![0.3, 0.4, 0.4, -0.7]];
    Point {
        fields: [vec![u.clone(), s.clone()], vec![u, s]],
        parameters: vec![vec![2.5]],
        position: vec![0.2, 0.4],
        normal: vec![0.6, 0.8],
        curvature: 0.1,
        diameter: [0.5, 0.6],
        cell_volume: [0.3, 0.7],
        facet_area: 0.4,
    }
}

/// A body of `pub fn value(u: Vector, s: Scalar) -> Scalar`, `a` a parameter.
fn source(body: &str) -> Source {
    Source::new(
        2,
        &format!(
            "mod m {{ struct Data {{ a: Param }} pub fn value(u: Vector, s: Scalar) -> Scalar {{ {body} }} }}"
        ),
    )
}

fn value(body: &str) -> f64 {
    let checked = source(body).checked().expect("no mistake");
    Evaluator::new(&checked[0], &point(), &Budget::new(u64::MAX)).components()[0]
}

#[test]
fn derivatives_in_space_and_by_variables() {
    let near = |body: &str, exact: f64| {
        let found = value(body);
        assert!((found - exact).abs() < 1e-14, "{body}: {found} is not {exact}");
    };
    // u = (0.5, −0.25), ∇u = [[0.1, 0.2], [0.3, −0.4]], s = 0.8, ∇s = (1.5, −2), a = 2.5, x = (0.2, 0.4).
    near("det(grad(u))", -0.1);
    // ∂²(s²)/∂x∂y = 2 (s_x s_y + s s_xy)
    near("hess(s * s)[0][1]", 2.0 * (1.5 * -2.0 + 0.8 * 0.4));
    near("div(s * u)", 0.8 * (0.1 - 0.4) + 1.5 * 0.5 + 2.0 * 0.25);
    near("grad(s * s * x[0])[0]", 2.0 * 0.8 * 1.5 * 0.2 + 0.64);
    near("derivative(s * s * s, s, a)", 3.0 * 0.64 * 2.5);
    near("derivative(derivative(s * s * s, s, u[0]), s, u[1])", 6.0 * 0.8 * 0.5 * -0.25);
    // The direction's gradient moves along: ∇(s u₀) = ∇s u₀ + s ∇u₀.
    near("derivative(grad(s)[1], s, s * u[0])", -2.0 * 0.5 + 0.8 * 0.2);
    near("derivative(a * a * s, a, s)", 2.0 * 2.5 * 0.64);
    // A field's gradient is held fixed by `diff`.
    near("diff(s * dot(grad(s), grad(s)), s)", 1.5 * 1.5 + 4.0);
    near("{ let w = s * s; diff(w * w * s, w) }", 2.0 * 0.64 * 0.8);
    near("{ let F = I + grad(u); inner(diff(det(F), F), cof(F)) }", 0.6 * 0.6 + 0.3 * 0.3 + 0.2 * 0.2 + 1.21);
    // At fixed reference coordinates ∇s moves by −∇uᵀ∇s, x by u, and s not at all.
    near("derivative(grad(s)[0], shape, u)", -(1.5 * 0.1 + -2.0 * 0.3));
    near("derivative(s * x[1], shape, u)", 0.8 * -0.25);
    near("derivative(h * h * s, h, a)", 2.0 * 0.5 * 2.5 * 0.8);
    near("if s > 0.5 { max(s, a) } else { sqrt(-s) }", 2.5);
}

/// Derivatives inside derivatives multiply; a walk without budget gives up, and says so.
#[test]
fn a_walk_gives_up_when_its_budget_is_exhausted() {
    let checked = source("hess(exp(s * s))[0][1]").checked().expect("no mistake");
    let with = |products: u64| {
        let (point, budget) = (point(), Budget::new(products));
        let evaluator = Evaluator::new(&checked[0], &point, &budget);
        (evaluator.components()[0], evaluator.condition().magnitude)
    };
    // ∂²/∂x∂y of exp(s²), s = 0.8, ∇s = (1.5, −2), s_xy = 0.4.
    let exact = 0.64_f64.exp() * ((2.0 + 4.0 * 0.64) * 1.5 * -2.0 + 2.0 * 0.8 * 0.4);
    let (found, magnitude) = with(100_000);
    assert!((found - exact).abs() < 1e-13 && magnitude.is_finite(), "{found}, {magnitude}");
    assert_eq!(with(1000).1, f64::INFINITY);
}
