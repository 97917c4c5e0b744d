//! Hessians of motions: Taylor tests of order three, symmetry, checkpointing, by all kinds of controls; what is missing is named.

use forms_fem::inverse::{
    ControlError, Controls, MotionHistory, Observations, ReducedProblem, SecondOrderMotion, StepContext,
    second_order_taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::{BackwardDifferences, CentralDifferences, GeneralisedAlpha, Mass, OneStepTheta};

use crate::swinging_body::{Body, STEPS, swung};

#[forms(dimension = 2)]
mod heated {
    use forms_fem::time::operators::scalar::{rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub conductivity: Param,
        pub d_conductivity: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let w = value(u);
        integral(Omega, rate(u) * v + exp(conductivity) * (1 + sqr(w)) * dot(grad(w), grad(v)) - v)
    }
    pub fn sensitivities(u: State<Scalar>, p: State<Scalar>, by_conductivity: Test<Scalar>) -> Form {
        derivative(balance(u, p), conductivity, by_conductivity)
    }
    pub fn second_sensitivities(
        u: State<Scalar>,
        p: State<Scalar>,
        dvalue: State<Scalar>,
        drate: State<Scalar>,
        dp: State<Scalar>,
        by_value: Test<Scalar>,
        by_rate: Test<Scalar>,
        by_adjoint: Test<Scalar>,
        by_conductivity: Test<Scalar>,
    ) -> Form {
        let work = balance(u, p);
        let slope = derivative(work, known_value, by_value)
            + derivative(work, known_rate, by_rate)
            + derivative(work, p, by_adjoint)
            + derivative(work, conductivity, by_conductivity);
        derivative(slope, known_value, dvalue)
            + derivative(slope, known_rate, drate)
            + derivative(slope, p, dp)
            + derivative(slope, conductivity, d_conductivity)
    }
    /// The same without the derivative by the rate.
    pub fn rateless(
        u: State<Scalar>,
        p: State<Scalar>,
        dvalue: State<Scalar>,
        dp: State<Scalar>,
        by_value: Test<Scalar>,
        by_adjoint: Test<Scalar>,
        by_conductivity: Test<Scalar>,
    ) -> Form {
        let work = balance(u, p);
        let slope = derivative(work, known_value, by_value)
            + derivative(work, p, by_adjoint)
            + derivative(work, conductivity, by_conductivity);
        derivative(slope, known_value, dvalue)
            + derivative(slope, p, dp)
            + derivative(slope, conductivity, d_conductivity)
    }
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// Unequal steps, for schemes that read several states.
const SIZES: [f64; STEPS] = [0.15, 0.1, 0.17, 0.12, 0.15, 0.09];

fn motions(body: &Body) -> [(&'static str, MotionHistory<'_, 2>); 7] {
    let damped = GeneralisedAlpha::with_spectral_radius(0.5).unwrap();
    let [second, third] = [2, 3].map(|order| BackwardDifferences::new(order).unwrap());
    [
        ("trapezoidal", body.history((STEPS, 0.15), GeneralisedAlpha::trapezoidal())),
        ("generalised-α", body.history((STEPS, 0.15), damped)),
        ("mid-point", body.history((STEPS, 0.15), GeneralisedAlpha::mid_point())),
        ("BDF 2", body.history((STEPS, 0.15), second)),
        ("BDF 3, unequal steps", body.history(&SIZES[..], third)),
        ("central differences", body.history((STEPS, 0.04), CentralDifferences)),
        ("lumped masses", body.history((STEPS, 0.04), CentralDifferences).mass(Mass::Lumped)),
    ]
}

/// Number, number per step, field, start and its rate together.
#[test]
fn the_remainder_with_the_hessian_has_order_three() {
    let body = Body::new([3, 1]);
    for (name, mut history) in motions(&body) {
        let m = history.start();
        let [gradient, hessian] =
            second_order_taylor_test(&mut history, &m, &body.direction(1.5), 0.2).unwrap();
        println!("{name}\n{gradient}{hessian}");
        assert!((gradient.second_order().unwrap() - 2.0).abs() < 0.02, "{name}: {gradient}");
        assert!((hessian.third_order().unwrap() - 3.0).abs() < 0.1, "{name}: {hessian}");
    }
}

#[test]
fn hessians_are_symmetric_with_all_states_and_with_few() {
    let body = Body::new([3, 1]);
    for (name, mut history) in motions(&body) {
        let m = history.start();
        let (one, other) = (body.direction(1.0), body.direction(2.3));
        let (first, second) = (history.hessian(&m, &one).unwrap(), history.hessian(&m, &other).unwrap());
        let (across, back) = (dot(&first.along, &other), dot(&second.along, &one));
        let scale = dot(&first.along, &one).abs().max(across.abs());
        assert!((across - back).abs() < 1e-12 * scale, "{name}: {across} {back}");
        let found = history.gradient(&m).unwrap();
        let largest = found.gradient.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
        assert!((found.value - first.value).abs() < 1e-13 * found.value);
        for (one, other) in found.gradient.iter().zip(&first.gradient) {
            assert!((one - other).abs() < 1e-12 * largest, "{name}: {one} {other}");
        }
        let few = history.stored_states(2).hessian(&m, &one).unwrap();
        let largest = first.along.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        assert!(few.work.most_stored == 2 && few.work.steps_solved > STEPS, "{:?}", few.work);
        for (few, all) in few.along.iter().zip(&first.along) {
            assert!((few - all).abs() < 1e-11 * largest, "{name}: {few} {all}");
        }
    }
}

fn heat(
    during: &StepContext<2>,
    states: Option<&SecondOrderMotion<2>>,
) -> Result<heated::Model<2>, ControlError> {
    let d_conductivity = states.map_or(Ok(0.0), |states| states.along.number("conductivity"))?;
    let conductivity = during.number("conductivity")?;
    Ok(heated::Model::new(
        heated::data_from(during).conductivity(conductivity).d_conductivity(d_conductivity),
    ))
}

/// Problems of first order have no second rates; what is missing is named.
#[test]
fn hessians_of_diffusion_and_what_is_missing() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Triangle, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| 0.1).unwrap();
    let start = Field::interpolate(&space, |x| 0.1 + x[0]).unwrap();
    let measured = Field::interpolate(&space, |x| 0.2 * x[0]).unwrap();
    let bare = || {
        let controls = Controls::new().number("conductivity", -0.5).start("start", &start);
        MotionHistory::new(&space, (5, 0.05), OneStepTheta::crank_nicolson(), controls)
            .motion(|during| Ok(heat(during, None)?.balance()))
            .sensitivities(|during, u, p| Ok(heat(during, None)?.sensitivities(u, p)))
            .observed(4, Observations::new(&space).at_nodes(&measured, 1.0).unwrap())
            .constrained(&held)
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() })
    };
    let mut history = bare().second_sensitivities(|during, states| {
        let &SecondOrderMotion { u, p, changes: [dvalue, drate, _], dp, .. } = states;
        Ok(heat(during, Some(states))?.second_sensitivities(u, p, dvalue, drate, dp))
    });
    let m = history.start();
    let d: Vec<f64> = (0..m.len()).map(|k| 0.2 * (1.0 + 1.7 * k as f64).sin()).collect();
    let [gradient, hessian] = second_order_taylor_test(&mut history, &m, &d, 0.2).unwrap();
    assert!((gradient.second_order().unwrap() - 2.0).abs() < 0.05, "{gradient}");
    assert!((hessian.third_order().unwrap() - 3.0).abs() < 0.1, "{hessian}");

    let mut rateless = bare().second_sensitivities(|during, states| {
        let &SecondOrderMotion { u, p, changes: [dvalue, ..], dp, .. } = states;
        Ok(heat(during, Some(states))?.rateless(u, p, dvalue, dp))
    });
    let told = rateless.hessian(&m, &d).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("`rateless` has no test function `by_rate`"), "{told}");
    let told = bare().hessian(&m, &d).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("the history has no second_sensitivities"), "{told}");
    let body = Body::new([3, 1]);
    let mut sprung = body
        .history((STEPS, 0.15), GeneralisedAlpha::mid_point())
        .motion(|during| Ok(swung(during, None)?.sprung()));
    let m = sprung.start();
    let told = sprung.hessian(&m, &body.direction(1.0)).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("`sprung` reads one of them itself"), "{told}");
}
