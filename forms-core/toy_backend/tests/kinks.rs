//! Conventions at kinks, and branches that are not taken: a NaN there reaches nothing.

use forms_core::described::Described;
use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::lanes::Four;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Lanes, Nodal, expression, residual, tangent};

#[forms(crate = toy_backend)]
pub mod kinks {
    #[cells]
    pub struct Omega;

    pub fn unit(s: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, v)
    }
    /// heaviside, sign, pos_part, neg_part, abs at s.
    pub fn values(s: Scalar) -> Scalar {
        heaviside(s) + 10 * sign(s) + 100 * pos_part(s) + 1000 * neg_part(s) + 10000 * abs(s)
    }
    pub fn heaviside_slope(s: Scalar) -> Scalar {
        derivative(heaviside(s) + sign(s), s, 1)
    }
    pub fn pos_part_slope(s: Scalar) -> Scalar {
        derivative(pos_part(s), s, 1)
    }
    pub fn neg_part_slope(s: Scalar) -> Scalar {
        derivative(neg_part(s), s, 1)
    }
    pub fn abs_slope(s: Scalar) -> Scalar {
        derivative(abs(s), s, 1)
    }
    pub fn max_slope(s: Scalar) -> Scalar {
        derivative(max(2 * s, -3 * s), s, 1)
    }
    pub fn min_slope(s: Scalar) -> Scalar {
        derivative(min(2 * s, -3 * s), s, 1)
    }
    /// Values, slopes and second derivatives at s = 0 of what divides by a length there.
    pub fn lengths(s: Scalar) -> Vector<4> {
        [norm([s, 2 * s]), normalize([s, s])[0], hypot(s, s), atan2(s, s)]
    }
    pub fn length_slopes(s: Scalar) -> Vector<4> {
        derivative(lengths(s), s, 1)
    }
    pub fn length_curvatures(s: Scalar) -> Vector<4> {
        derivative(length_slopes(s), s, 1)
    }
    /// Exists at 0: 3/2 √s, p s^(p − 1), 3 s².
    pub fn power_slope(s: Scalar) -> Scalar {
        let p = 1 + exp(0);
        derivative(pow(s, 3 / 2) + pow(s, p) + pow(s, 3), s, 1)
    }
}

/// A value at s = `at`.
macro_rules! at {
    ($name:ident, $at:expr) => {{
        let mesh = Mesh::<2>::cube(&mut Random(1));
        let form = kinks::$name(Source::<2>::Constant(vec![$at]));
        expression(&mesh, &form, (Entity::Cells, "all"))[0][0]
    }};
}

/// All components at s = `at`.
macro_rules! all_at {
    ($name:ident, $at:expr) => {{
        let mesh = Mesh::<2>::cube(&mut Random(1));
        let form = kinks::$name(Source::<2>::Constant(vec![$at]));
        expression(&mesh, &form, (Entity::Cells, "all"))[0].clone()
    }};
}

#[test]
fn lengths_at_zero() {
    assert_eq!(all_at!(lengths, 0.0), [0.0; 4]);
    assert_eq!(all_at!(length_slopes, 0.0), [0.0; 4]);
    assert_eq!(all_at!(length_curvatures, 0.0), [0.0; 4]);
    // Nothing overflows on the way to zero, either.
    for tiny in [1e-60, 1e-99, 1e-101, 1e-160, 5e-324] {
        for values in [all_at!(lengths, tiny), all_at!(length_slopes, tiny), all_at!(length_curvatures, tiny)]
        {
            assert!(values.iter().all(|value| value.is_finite()), "{values:?} at {tiny}");
        }
    }
    // A NaN is no zero.
    assert!(all_at!(lengths, f64::NAN).iter().all(|value| value.is_nan()));
    // (The angle of (s, s) has the slope 0 before any number is known.)
    assert!(all_at!(length_slopes, f64::NAN)[..3].iter().all(|value| value.is_nan()));
}

#[test]
fn values_at_kinks() {
    assert_eq!(at!(values, 0.0), 0.0);
    assert_eq!(at!(values, 0.5), 1.0 + 10.0 + 50.0 + 5000.0);
    assert_eq!(at!(values, -0.5), -10.0 + 500.0 + 5000.0);
}

#[test]
fn slopes_at_kinks() {
    assert_eq!(at!(heaviside_slope, 0.0), 0.0);
    assert_eq!(
        [at!(pos_part_slope, -1.0), at!(pos_part_slope, 0.0), at!(pos_part_slope, 1.0)],
        [0.0, 0.0, 1.0]
    );
    assert_eq!(
        [at!(neg_part_slope, -1.0), at!(neg_part_slope, 0.0), at!(neg_part_slope, 1.0)],
        [-1.0, 0.0, 0.0]
    );
    assert_eq!([at!(abs_slope, -1.0), at!(abs_slope, 0.0), at!(abs_slope, 1.0)], [-1.0, 0.0, 1.0]);
    // At equal arguments: the second for max, the first for min.
    assert_eq!([at!(max_slope, -1.0), at!(max_slope, 0.0), at!(max_slope, 1.0)], [-3.0, -3.0, 2.0]);
    assert_eq!([at!(min_slope, -1.0), at!(min_slope, 0.0), at!(min_slope, 1.0)], [2.0, 2.0, -3.0]);
    assert_eq!(at!(power_slope, 0.0), 0.0);
}

#[forms(crate = toy_backend)]
pub mod branches {
    pub struct Data {
        p: Param,
    }
    #[cells]
    pub struct Omega;

    /// Each is safe where its branch is taken, and not a number, infinite, or both elsewhere.
    fn safe(s: Scalar, u: Vector) -> Scalar {
        let root = if s > 0 { sqrt(s) } else { s * s };
        let logarithm = if s > 0 { ln(s) * s } else { s };
        let quotient = if s == 0 {
            s
        } else if s > 0 {
            1 / s
        } else {
            3 * s
        };
        let power = if s > 0 { pow(s, 1.5) + pow(s, p) + pow(p, 1 / s) } else { 2 * s };
        let length = dot(u, u);
        let norm = if length > 0 { sqrt(length) } else { 0 };
        let direction = if length > 0 { u / sqrt(length) } else { 0 * u };
        let inverse = if det(grad(u)) > 0 { inv(grad(u)) } else { grad(u) };
        root + logarithm + quotient + power + norm + dot(direction, direction) + tr(inverse)
    }
    /// The same as `safe` where s ≤ 0 and u = 0, with nothing to go wrong.
    fn plain(s: Scalar, u: Vector) -> Scalar {
        s * s + s + (if s == 0 { s } else { 3 * s }) + 2 * s + tr(grad(u))
    }
    pub fn value(s: Scalar, u: Vector) -> Scalar {
        safe(s, u)
    }
    pub fn form(s: Unknown<Scalar>, u: Unknown<Vector>, v: Test<Scalar>, w: Test<Vector>) -> Form {
        integral(Omega, safe(s, u) * v + safe(s, u) * div(w))
    }
    pub fn reference(s: Unknown<Scalar>, u: Unknown<Vector>, v: Test<Scalar>, w: Test<Vector>) -> Form {
        integral(Omega, plain(s, u) * v + plain(s, u) * div(w))
    }
    /// The second derivative, too.
    pub fn energy(s: Unknown<Scalar>, u: Unknown<Vector>) -> Energy {
        integral(Omega, safe(s, u))
    }
}

/// s ≤ 0 and u = 0 everywhere: every dangerous branch is left out.
fn nothing_poisons<L: Lanes, const D: usize>(s: f64)
where
    Dim: Dimension<D>,
{
    let mesh = Mesh::<D>::cube(&mut Random(2));
    let nodes = mesh.nodes.len();
    let unknowns = [
        Nodal { components: 1, values: vec![s; nodes] },
        Nodal { components: D, values: vec![0.0; nodes * D] },
    ];
    let (data, omega) = (branches::data::<D>().p(1.3), branches::Omega::on("all"));
    let (form, reference) = (branches::form(&data, &omega), branches::reference(&data, &omega));
    let found = residual::<L, D>(&mesh, &form, &unknowns);
    let expected = residual::<f64, D>(&mesh, &reference, &unknowns);
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() <= 1e-14, "{found} is not {expected}");
    }
    let found = tangent::<L, D>(&mesh, &form, &unknowns);
    let expected = tangent::<f64, D>(&mesh, &reference, &unknowns);
    assert!(expected.iter().flatten().any(|entry| *entry != 0.0));
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() <= 1e-14, "{found} is not {expected}");
    }
    let energy = branches::energy(&data, &omega);
    assert!(residual::<L, D>(&mesh, &energy, &unknowns).iter().all(|entry| entry.is_finite()));
    let hessian = tangent::<L, D>(&mesh, &energy, &unknowns);
    assert!(hessian.iter().flatten().all(|entry| entry.is_finite()));
}

#[test]
fn branches_not_taken_poison_nothing() {
    for s in [-0.5, 0.0] {
        nothing_poisons::<f64, 2>(s);
        nothing_poisons::<f64, 3>(s);
        nothing_poisons::<Four, 2>(s);
    }
}

#[test]
fn the_dangerous_branch_is_dangerous() {
    // So that the test above shows something: where the branch is taken, 1 / s is seen.
    let mesh = Mesh::<2>::cube(&mut Random(3));
    let data = branches::data().p(1.3);
    let value = branches::value(
        &data,
        Source::Constant(vec![f64::MIN_POSITIVE / 4.0]),
        Source::Constant(vec![0.0; 2]),
    );
    assert!(expression(&mesh, &value, (Entity::Cells, "all"))[0][0].is_infinite());
}

#[test]
fn a_comparison_is_one_switch() {
    let data = branches::data::<2>().p(1.3);
    let omega = branches::Omega::on("all");
    let form = branches::reference(&data, &omega);
    let switches =
        <branches::reference::Kernels as Integrals<2>>::switches::<Described>(form.inputs().constants());
    assert_eq!(switches.iter().map(|term| term.kernel.shape[0]).sum::<usize>(), 1);
    assert_eq!(form.switches().len(), switches.len());
}

#[forms(crate = toy_backend)]
pub mod singular {
    #[cells]
    pub struct Omega;

    pub fn zero_times(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, 0 * (1 / u) * v)
    }
    pub fn zero_over(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, 0 / u * v)
    }
    pub fn quotient(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u / u * v)
    }
    pub fn quotient_of_square(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * u / u * v)
    }
    pub fn difference(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 / u - 1 / u) * v)
    }
    pub fn logarithms(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (ln(u) - ln(u) + 0 * pow(u, -0.5)) * v)
    }
    /// Nothing is singular here: it is zero, and has no integral.
    pub fn nothing(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (0 * exp(u) + u - u + pow(u, 0) - 1) * v)
    }
    /// The identity's zeros are nothing, whatever is next to them.
    pub fn off_diagonal(u: State<Scalar>) -> Scalar {
        (ln(u) * I)[0][1]
    }
}

/// Quotients whose divisor is zero are NaN in the residual and in the tangent, and have their value elsewhere.
#[test]
fn singular_expressions_are_not_simplified_away() {
    let mesh = Mesh::<2>::cube(&mut Random(1));
    let omega = singular::Omega::on("all");
    let constant = |value: f64| Nodal { values: vec![value; mesh.nodes.len()], components: 1 };
    // Per unit of ∫ v, at u = 2.
    macro_rules! check {
        ($($name:ident $value:expr;)*) => { $({
            let form = singular::$name::<2>(&omega);
            let sum = |u: f64| residual::<f64, 2>(&mesh, &form, &[constant(u)]).iter().sum::<f64>();
            assert!((sum(2.0) - $value * mesh_volume(&mesh)).abs() < 1e-12, "{}: {}", stringify!($name), sum(2.0));
            assert!(sum(0.0).is_nan(), "{} at 0: {}", stringify!($name), sum(0.0));
            let entries = tangent::<f64, 2>(&mesh, &form, &[constant(0.0)]);
            assert!(entries.iter().flatten().any(|entry| entry.is_nan()), "the tangent of {}", stringify!($name));
            let lanes = residual::<Four, 2>(&mesh, &form, &[constant(0.0)]);
            assert!(lanes.iter().all(|entry| entry.is_nan()), "{} on four lanes", stringify!($name));
        })* };
    }
    check! { zero_times 0.0; zero_over 0.0; quotient 1.0; quotient_of_square 2.0; difference 0.0; logarithms 0.0; }
    let nothing = singular::nothing::<2>(&singular::Omega::on("all"));
    assert!(residual::<f64, 2>(&mesh, &nothing, &[constant(0.0)]).iter().all(|entry| *entry == 0.0));
    let off_diagonal = singular::off_diagonal::<2>(Source::Constant(vec![-1.0]));
    assert_eq!(expression(&mesh, &off_diagonal, (Entity::Cells, "all"))[0], [0.0]);
}

/// The residual of ∫ v summed over all test functions.
fn mesh_volume(mesh: &Mesh<2>) -> f64 {
    let form = kinks::unit::<2>(&kinks::Omega::on("all"));
    let zero = Nodal { values: vec![0.0; mesh.nodes.len()], components: 1 };
    residual::<f64, 2>(mesh, &form, &[zero]).iter().sum()
}
