//! Gradients of motions with impact: the hybrid and the conserving scheme read the displacements at both ends of a step next to the
//! mid-point rule's operators. By material, and by the velocity at the start, of a bar that hits and leaves.

use forms_contact::impact::impact;
use forms_fem::inverse::{
    ControlError, Controls, HistoryError, MotionHistory, Observations, ReducedProblem, StepContext,
    taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::GeneralisedAlpha;

#[forms]
mod thrown {
    pub use forms_contact::impact::impact::{Data, GammaC, Omega, conserving, hybrid};

    pub fn conserving_rates(
        u: State<Vector>,
        p: State<Vector>,
        before: State<Vector>,
        by_before: Test<Vector>,
        by_density: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
    ) -> Form {
        let work = conserving(u, p, before);
        derivative(work, before, by_before)
            + derivative(work, rho, by_density)
            + derivative(work, mu, by_shear_modulus)
    }

    pub fn hybrid_rates(
        u: State<Vector>,
        p: State<Vector>,
        before: State<Vector>,
        by_before: Test<Vector>,
        by_density: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
    ) -> Form {
        let work = hybrid(u, p, before);
        derivative(work, before, by_before)
            + derivative(work, rho, by_density)
            + derivative(work, mu, by_shear_modulus)
    }

    /// Without the derivative by the displacement before.
    pub fn forgetful_rates(
        u: State<Vector>,
        p: State<Vector>,
        before: State<Vector>,
        by_density: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
    ) -> Form {
        let work = hybrid(u, p, before);
        derivative(work, rho, by_density) + derivative(work, mu, by_shear_modulus)
    }
}

/// A bar of length 1 with E about 1, which hits at about t = 0.1 and leaves after about 2.
const CELLS: usize = 10;
const STEPS: usize = 60;
const SIZE: f64 = 0.05;
const GAP: f64 = 0.02;

fn model(during: &StepContext<2>) -> Result<thrown::Model<2>, ControlError> {
    let data = impact::data_from(during)
        .lambda(0.0)
        .mu(during.number("shear_modulus")?)
        .gamma0(4.0)
        .obstacle_normal([-1.0, 0.0])
        .gap(GAP)
        .theta(1.0)
        .rho(during.number("density")?);
    Ok(thrown::Model { data, regions: thrown::Regions::default().gamma_c("left") })
}

struct Bar {
    space: Arc<Space<2>>,
    along: Constraints<2>,
    controls: Controls<2>,
}

impl Bar {
    fn new() -> Self {
        let size = 1.0 / CELLS as f64;
        let mesh = rectangle([0.0; 2], [1.0, size], [CELLS, 1], CellShape::Quadrilateral, 1).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let mut along = Constraints::new(&space);
        along.fix_component("all", 1, |_| 0.0).unwrap();
        let rate = Field::interpolate(&space, |x| [-0.2 - 0.03 * x[0], 0.0]).unwrap();
        let controls =
            Controls::new().number("density", 1.1).number("shear_modulus", 0.53).start_rate("rate", &rate);
        Bar { space, along, controls }
    }

    /// The ends of the bar on its way back, and on the obstacle.
    fn history(&self) -> MotionHistory<'_, 2> {
        let at = |x: f64, weight: f64| {
            Observations::new(&self.space).at_point(&[x, 0.0], &[0.05, 0.0], weight).unwrap()
        };
        let scheme = GeneralisedAlpha::mid_point();
        MotionHistory::new(&self.space, (STEPS, SIZE), scheme, self.controls.clone())
            .observed(STEPS / 2, at(0.0, 2.0))
            .observed(STEPS - 1, at(0.0, 1.0))
            .observed(STEPS - 1, at(1.0, 3.0))
            .constrained(&self.along)
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() })
    }
}

fn check(label: &str, mut history: MotionHistory<'_, 2>) {
    let m = history.start();
    let direction: Vec<f64> =
        (0..m.len()).map(|k| if k < 2 { 0.05 } else { 0.02 * (1.0 + 1.7 * k as f64).sin() }).collect();
    let report = taylor_test(&mut history, &m, &direction, 0.1).unwrap();
    println!("{label}\n{report}");
    let order = report.second_order().unwrap_or_else(|error| panic!("{label}: {error}"));
    assert!((order - 2.0).abs() < 0.05, "{label}: {report}");
    let all = history.gradient(&m).unwrap();
    let few = history.stored_states(5).gradient(&m).unwrap();
    let largest = all.gradient.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
    for (few, all) in few.gradient.iter().zip(&all.gradient) {
        assert!((few - all).abs() < 1e-9 * largest, "{label}: {few} is not {all}");
    }
}

#[test]
fn gradients_go_through_an_impact() {
    let bar = Bar::new();
    let conserving = bar
        .history()
        .motion(|during| Ok(model(during)?.conserving(during.before())))
        .sensitivities(|during, u, p| Ok(model(during)?.conserving_rates(u, p, during.before())));
    check("conserving", conserving);
    let hybrid = bar
        .history()
        .motion(|during| Ok(model(during)?.hybrid(during.before())))
        .sensitivities(|during, u, p| Ok(model(during)?.hybrid_rates(u, p, during.before())));
    check("hybrid", hybrid);
}

#[test]
fn a_derivative_by_the_value_before_is_asked_for() {
    let bar = Bar::new();
    let mut history = bar
        .history()
        .motion(|during| Ok(model(during)?.hybrid(during.before())))
        .sensitivities(|during, u, p| Ok(model(during)?.forgetful_rates(u, p, during.before())));
    let m = history.start();
    let error: HistoryError = history.gradient(&m).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("no test function `by_before`"), "{error}");
    // The trapezoidal rule reads accelerations; the first is an unknown, too.
    let scheme = GeneralisedAlpha::trapezoidal();
    let mut history = MotionHistory::new(&bar.space, (STEPS, SIZE), scheme, bar.controls.clone())
        .motion(|during| Ok(model(during)?.hybrid(during.before())))
        .sensitivities(|during, u, p| Ok(model(during)?.hybrid_rates(u, p, during.before())))
        .observed(STEPS - 1, Observations::new(&bar.space).at_point(&[0.0; 2], &[0.0; 2], 1.0).unwrap())
        .constrained(&bar.along);
    let error = history.gradient(&m).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("reads its unknown `u` itself"), "{error}");
}
