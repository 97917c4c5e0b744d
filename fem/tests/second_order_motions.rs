//! Hessians of motions: Taylor tests of order three, symmetry, few stored states, by all kinds of controls; what is missing is named.
#![allow(clippy::too_many_arguments, reason = "constructors of second rates take six states")]

use forms_fem::inverse::{
    ControlError, Controls, During, MotionHistory, Observations, ReducedProblem, SecondOrderMotion,
    second_order_taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, OneStepTheta};

#[forms(dimension = 2)]
mod swinging {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};

    #[extends(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        pub density: Param,
        pub stiffness: Given<Scalar>,
        pub pull: Param,
        pub d_density: Param,
        pub d_stiffness: Given<Scalar>,
        pub d_pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = displacement(u);
        let rate = velocity(u);
        integral(Omega, density * dot(acceleration(u) + (0.3 + dot(rate, rate)) * rate, v))
            + integral(Omega, exp(stiffness) * inner(eps(w), eps(v)) + (0.5 + dot(w, w)) * dot(w, v))
            - integral(Right, pull * v[1])
    }
    /// With a spring that reads the unknown itself.
    pub fn sprung(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        motion(u, v) + integral(Right, 0.2 * dot(u, v))
    }
    pub fn misfit(u: Unknown<Vector>) -> Energy {
        integral(Omega, pow(u[1] - 0.1 * x[0], 4) + sqr(u[0]))
    }
    pub fn rates(
        u: State<Vector>,
        p: State<Vector>,
        by_density: Test<Scalar>,
        by_stiffness: Test<Scalar>,
        by_pull: Test<Scalar>,
    ) -> Form {
        let work = motion(u, p);
        derivative(work, density, by_density)
            + derivative(work, stiffness, by_stiffness)
            + derivative(work, pull, by_pull)
    }
    pub fn second_rates(
        u: State<Vector>,
        p: State<Vector>,
        dvalue: State<Vector>,
        drate: State<Vector>,
        dsecond_rate: State<Vector>,
        dp: State<Vector>,
        by_value: Test<Vector>,
        by_rate: Test<Vector>,
        by_second_rate: Test<Vector>,
        by_adjoint: Test<Vector>,
        by_density: Test<Scalar>,
        by_stiffness: Test<Scalar>,
        by_pull: Test<Scalar>,
    ) -> Form {
        let work = motion(u, p);
        let slope = derivative(work, known_value, by_value)
            + derivative(work, known_rate, by_rate)
            + derivative(work, known_second_rate, by_second_rate)
            + derivative(work, p, by_adjoint)
            + derivative(work, density, by_density)
            + derivative(work, stiffness, by_stiffness)
            + derivative(work, pull, by_pull);
        derivative(slope, known_value, dvalue)
            + derivative(slope, known_rate, drate)
            + derivative(slope, known_second_rate, dsecond_rate)
            + derivative(slope, p, dp)
            + derivative(slope, density, d_density)
            + derivative(slope, stiffness, d_stiffness)
            + derivative(slope, pull, d_pull)
    }
}

#[forms(dimension = 2)]
mod heated {
    use forms_fem::time::operators::scalar::{rate, value};

    #[extends(forms_fem::time::operators::scalar::Data)]
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
    pub fn rates(u: State<Scalar>, p: State<Scalar>, by_conductivity: Test<Scalar>) -> Form {
        derivative(balance(u, p), conductivity, by_conductivity)
    }
    pub fn second_rates(
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

fn swung(
    during: &During<2>,
    states: Option<&SecondOrderMotion<2>>,
) -> Result<swinging::Model<2>, ControlError> {
    let along = states.map(|states| states.along);
    let data = swinging::Data {
        base: during.into(),
        density: during.number("density")?,
        stiffness: Given::field(&during.field("stiffness")?),
        pull: during.number("pull")?,
        d_density: along.map_or(Ok(0.0), |along| along.number("density"))?,
        d_stiffness: match along {
            Some(along) => Given::field(&along.field("stiffness")?),
            None => Given::constant(0.0),
        },
        d_pull: along.map_or(Ok(0.0), |along| along.number("pull"))?,
    };
    Ok(swinging::Model { data, regions: swinging::Regions::default() })
}

const STEPS: usize = 6;

struct Parts {
    space: Arc<Space<2>>,
    held: Constraints<2>,
    controls: Controls<2>,
    criterion: swinging::Model<2>,
}

fn parts() -> Parts {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0, 0.3], [3, 1], CellShape::Quadrilateral, 1).unwrap());
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2]).unwrap();
    let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let stiffness = Field::interpolate(&cells, |x| 1.0 + x[0]).unwrap();
    let start = Field::interpolate(&space, |x| [0.0, 0.3 * x[0] * x[0]]).unwrap();
    let rate = Field::interpolate(&space, |x| [0.05 * x[0], 0.2 * x[0]]).unwrap();
    let pulls: Vec<f64> = (0..STEPS).map(|step| 0.4 + 0.1 * step as f64).collect();
    let controls = Controls::new()
        .number("density", 1.3)
        .field("stiffness", &stiffness)
        .per_step("pull", &pulls)
        .start("start", &start)
        .start_rate("rate", &rate);
    let nothing = || Given::constant(0.0);
    let data = swinging::Data {
        base: Default::default(),
        density: 0.0,
        stiffness: nothing(),
        pull: 0.0,
        d_density: 0.0,
        d_stiffness: nothing(),
        d_pull: 0.0,
    };
    let criterion = swinging::Model { data, regions: swinging::Regions::default() };
    Parts { space, held, controls, criterion }
}

fn motion(parts: &Parts, scheme: GeneralisedAlpha) -> MotionHistory<'_, 2> {
    let observed = Observations::new(&parts.space).at_point(&[0.7, 0.2], &[0.0, 0.1], 2.0).unwrap();
    MotionHistory::new(&parts.space, (STEPS, 0.15), scheme, parts.controls.clone())
        .motion(|during| Ok(swung(during, None)?.motion()))
        .rates(|during, u, p| Ok(swung(during, None)?.rates(u, p)))
        .second_rates(|during, states| {
            let [dvalue, drate, dsecond_rate] = states.changes;
            let (u, p, dp) = (states.u, states.p, states.dp);
            Ok(swung(during, Some(states))?.second_rates(u, p, dvalue, drate, dsecond_rate, dp))
        })
        .criterion(|_| Ok(parts.criterion.misfit()))
        .observed(2, observed)
        .with_cost_of_controls(|m| {
            (m[0].powi(4), [vec![4.0 * m[0].powi(3)], vec![0.0; m.len() - 1]].concat())
        })
        .with_curvature_of_controls(|m, d| {
            [vec![12.0 * m[0].powi(2) * d[0]], vec![0.0; m.len() - 1]].concat()
        })
        .constrained(&parts.held)
        .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() })
}

fn direction(count: usize, phase: f64) -> Vec<f64> {
    (0..count).map(|k| 0.2 * (phase + 1.7 * k as f64).sin()).collect()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn schemes() -> [(&'static str, GeneralisedAlpha); 3] {
    [
        ("trapezoidal", GeneralisedAlpha::trapezoidal()),
        ("generalised-α", GeneralisedAlpha::with_spectral_radius(0.5).unwrap()),
        ("mid-point", GeneralisedAlpha::mid_point()),
    ]
}

/// Number, number per step, field, start and its rate together.
#[test]
fn the_remainder_with_the_hessian_has_order_three() {
    let parts = parts();
    for (name, scheme) in schemes() {
        let mut history = motion(&parts, scheme);
        let m = history.start();
        let [gradient, hessian] =
            second_order_taylor_test(&mut history, &m, &direction(m.len(), 1.0), 0.2).unwrap();
        println!("{name}\n{gradient}{hessian}");
        assert!((gradient.second_order().unwrap() - 2.0).abs() < 0.05, "{name}: {gradient}");
        assert!((hessian.third_order().unwrap() - 3.0).abs() < 0.1, "{name}: {hessian}");
    }
}

#[test]
fn hessians_are_symmetric_with_all_states_and_with_few() {
    let parts = parts();
    for (name, scheme) in schemes() {
        let mut all = motion(&parts, scheme);
        let m = all.start();
        let (one, other) = (direction(m.len(), 1.0), direction(m.len(), 2.3));
        let (first, second) = (all.hessian(&m, &one).unwrap(), all.hessian(&m, &other).unwrap());
        let (across, back) = (dot(&first.along, &other), dot(&second.along, &one));
        let scale = dot(&first.along, &one).abs().max(across.abs());
        assert!((across - back).abs() < 1e-12 * scale, "{name}: {across} {back}");
        let found = all.gradient(&m).unwrap();
        let largest = found.gradient.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
        assert!((found.value - first.value).abs() < 1e-13 * found.value);
        for (one, other) in found.gradient.iter().zip(&first.gradient) {
            assert!((one - other).abs() < 1e-12 * largest, "{name}: {one} {other}");
        }
        let few = motion(&parts, scheme).stored_states(2).hessian(&m, &one).unwrap();
        let largest = first.along.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        assert!(few.work.most_stored == 2 && few.work.steps_solved > STEPS, "{:?}", few.work);
        for (few, all) in few.along.iter().zip(&first.along) {
            assert!((few - all).abs() < 1e-11 * largest, "{name}: {few} {all}");
        }
    }
}

fn heat(during: &During<2>, states: Option<&SecondOrderMotion<2>>) -> Result<heated::Model<2>, ControlError> {
    let d_conductivity = states.map_or(Ok(0.0), |states| states.along.number("conductivity"))?;
    let conductivity = during.number("conductivity")?;
    Ok(heated::Model::new(heated::Data { base: during.into(), conductivity, d_conductivity }))
}

/// Problems of first order have no second rates; what is missing is named.
#[test]
fn hessians_of_diffusion_and_what_is_missing() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Triangle, 1).unwrap());
    let space = Space::scalar(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| 0.1).unwrap();
    let start = Field::interpolate(&space, |x| 0.1 + x[0]).unwrap();
    let measured = Field::interpolate(&space, |x| 0.2 * x[0]).unwrap();
    let bare = || {
        let controls = Controls::new().number("conductivity", -0.5).start("start", &start);
        MotionHistory::new(&space, (5, 0.05), OneStepTheta::crank_nicolson(), controls)
            .motion(|during| Ok(heat(during, None)?.balance()))
            .rates(|during, u, p| Ok(heat(during, None)?.rates(u, p)))
            .observed(4, Observations::new(&space).at_nodes(&measured, 1.0).unwrap())
            .constrained(&held)
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() })
    };
    let mut history = bare().second_rates(|during, states| {
        let &SecondOrderMotion { u, p, changes: [dvalue, drate, _], dp, .. } = states;
        Ok(heat(during, Some(states))?.second_rates(u, p, dvalue, drate, dp))
    });
    let m = history.start();
    let d = direction(m.len(), 1.0);
    let [gradient, hessian] = second_order_taylor_test(&mut history, &m, &d, 0.2).unwrap();
    assert!((gradient.second_order().unwrap() - 2.0).abs() < 0.05, "{gradient}");
    assert!((hessian.third_order().unwrap() - 3.0).abs() < 0.1, "{hessian}");

    let mut rateless = bare().second_rates(|during, states| {
        let &SecondOrderMotion { u, p, changes: [dvalue, ..], dp, .. } = states;
        Ok(heat(during, Some(states))?.rateless(u, p, dvalue, dp))
    });
    let told = rateless.hessian(&m, &d).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("`rateless` has no test function `by_rate`"), "{told}");
    let told = bare().hessian(&m, &d).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("the history has no second_rates"), "{told}");
    let parts = parts();
    let mut sprung =
        motion(&parts, GeneralisedAlpha::mid_point()).motion(|during| Ok(swung(during, None)?.sprung()));
    let m = sprung.start();
    let told = sprung.hessian(&m, &direction(m.len(), 1.0)).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("`sprung` reads one of them itself"), "{told}");
}
