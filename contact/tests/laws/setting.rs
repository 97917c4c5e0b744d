//! Materials, data and small checks that the laws' tests share.

use forms_contact::forms;
use forms_contact::laws::frictional_nitsche as law;
use forms_fem::assemble::AssemblyError;
use forms_fem::prelude::*;
use forms_fem::verification;

/// E.
pub const YOUNG: f64 = 200.0;
/// ν.
pub const POISSON: f64 = 0.3;
/// λ.
pub const LAMBDA: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
/// μ.
pub const MU: f64 = YOUNG / (2.0 * (1.0 + POISSON));
/// All variants.
pub const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

/// The law of friction.
#[derive(Clone, Copy, Debug)]
pub enum Friction {
    /// s₀.
    Tresca(f64),
    /// κ.
    Coulomb(f64),
}

/// The unit vector along an axis, times a number.
pub fn along<const D: usize>(axis: usize, size: f64) -> [f64; D] {
    std::array::from_fn(|k| if k == axis { size } else { 0.0 })
}

/// A body on the flat below it: n_y down, no gap, no load, J = ∫ F·u with an F that is nowhere constant.
pub fn data<const D: usize>(friction: Friction, theta: f64, gamma0: f64) -> law::Data<D> {
    let base = forms::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(gamma0)
        .obstacle_normal(along(D - 1, -1.0))
        .gap(0.0)
        .theta(theta)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]));
    let (slip_stress, friction) = match friction {
        Friction::Tresca(bound) => (bound, 0.0),
        Friction::Coulomb(coefficient) => (0.0, coefficient),
    };
    law::data_from(base).slip_stress(slip_stress).friction(friction).force_direction(along(0, 1.0))
}

/// A smooth field without symmetry, of about this size.
pub fn wave<const D: usize>(space: &Arc<Space<D>>, size: f64, phase: f64) -> Field<D> {
    let value = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| {
            let angle: f64 = x.iter().enumerate().map(|(axis, x)| (2.0 + 0.7 * axis as f64) * x).sum();
            size * (angle + phase + 1.9 * k as f64).sin()
        })
    };
    Field::interpolate(space, value).unwrap()
}

/// The tangent passes its Taylor test with an order of 1.95 or more (or the form is affine along the direction), and
/// another form's tangent does not.
pub fn check_tangent<const D: usize>(
    label: &str,
    assembler: &Assembler<D>,
    form: &Form<D>,
    unknowns: &[&Field<D>],
    directions: &[&Field<D>],
) {
    let report = verification::tangent(assembler, form, unknowns, directions, 0.05).unwrap();
    let order = report.second_order().unwrap_or_else(|error| panic!("{label}: {error}"));
    println!("{label}: order {order:.3}");
    assert!(order >= 1.95, "{label}: {report}");
}

/// dJ/dt by fourth-order differences with the step; `value` solves again and gives J with the active set, which must not change.
pub fn difference(
    step: f64,
    mut value: impl FnMut(f64) -> Result<(f64, Option<Vec<u32>>), AssemblyError>,
) -> f64 {
    let (_, set) = value(0.0).unwrap();
    let mut at = |t: f64| {
        let (value, moved) = value(t).unwrap();
        assert!(moved == set, "a point changes its state at {t}");
        value
    };
    (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)
}

/// Relative agreement.
pub fn close(label: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs() / expected.abs().max(1e-300);
    println!("{label}: {found} and {expected} ({error:.1e})");
    assert!(error < tolerance, "{label}: {found} is not {expected} ({error:.1e})");
}
