//! Hessians of load histories: Taylor tests of order three, symmetry, differences of gradients, checkpointing; what is missing is named.

use forms_fem::inverse::{
    ControlError, ControlValues, Controls, LoadHistory, Observations, ReducedProblem, SecondOrderState,
    TwiceDifferentiable, second_order_taylor_test,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod creep {
    pub struct Data {
        pub conductivity: Param,
        pub load: Param,
        pub stiffness: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    #[controls(conductivity, load, stiffness, criterion = misfit, order = 2)]
    pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
        integral(
            Omega,
            (u - before + stiffness * pow(u, 3)) * v
                + exp(conductivity) * (1 + sqr(u) + sqr(before)) * dot(grad(u), grad(v))
                - load * (1 + x[0]) * v,
        )
    }
    /// It reads a control.
    pub fn misfit(u: Unknown<Scalar>) -> Energy {
        integral(Omega, conductivity * pow(u - x[0], 4) + sqr(u))
    }
}

fn crept(at: &ControlValues<2>, along: Option<&ControlValues<2>>) -> Result<creep::Model<2>, ControlError> {
    let data = creep::data()
        .conductivity(at.number("conductivity")?)
        .load(at.number("load")?)
        .stiffness(&at.field("stiffness")?)
        .d_conductivity(along.map_or(Ok(0.0), |along| along.number("conductivity"))?)
        .d_load(along.map_or(Ok(0.0), |along| along.number("load"))?)
        .d_stiffness(match along {
            Some(along) => Given::field(&along.field("stiffness")?),
            None => Given::constant(0.0),
        });
    Ok(creep::Model::new(data))
}

struct Parts {
    space: Arc<Space<2>>,
    held: Constraints<2>,
    controls: Controls<2>,
}

const STEPS: usize = 6;

fn parts() -> Parts {
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 3], CellShape::Triangle, 1).unwrap();
    let space = Space::scalar(&mesh, 2).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |x| 0.3 * x[1]).unwrap();
    let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let stiffness = Field::interpolate(&cells, |x| 1.0 + x[0]).unwrap();
    let start = Field::interpolate(&space, |x| 0.2 * x[0] + 0.3 * x[1]).unwrap();
    let loads: Vec<f64> = (0..STEPS).map(|step| 0.5 + 0.1 * step as f64).collect();
    let controls = Controls::new()
        .number("conductivity", -1.0)
        .per_step("load", &loads)
        .field("stiffness", &stiffness)
        .start("start", &start);
    Parts { space, held, controls }
}

fn history(parts: &Parts) -> LoadHistory<'static, 2> {
    let observed = Observations::new(&parts.space).at_point(&[0.7, 0.4], &[0.1], 2.0).unwrap();
    LoadHistory::new(&parts.space, STEPS, parts.controls.clone())
        .step(|at| Ok(crept(at, None)?.step(at.before()?)))
        .sensitivities(|at, u, p| Ok(crept(at, None)?.step_sensitivities(u, at.before()?, p)))
        .second_sensitivities(|at, states: &SecondOrderState<2>| {
            let &SecondOrderState { u, p, du, dbefore, dp, along } = states;
            Ok(crept(at, Some(&along))?.step_second_sensitivities(u, at.before()?, p, du, dbefore, dp))
        })
        .criterion(|at| Ok(crept(at, None)?.misfit()))
        .observed(2, observed)
        .with_cost_of_controls(|m| {
            (m[0].powi(4), [vec![4.0 * m[0].powi(3)], vec![0.0; m.len() - 1]].concat())
        })
        .with_curvature_of_controls(|m, d| {
            [vec![12.0 * m[0].powi(2) * d[0]], vec![0.0; m.len() - 1]].concat()
        })
        .constrained(&parts.held)
}

fn direction(count: usize, phase: f64) -> Vec<f64> {
    (0..count).map(|k| 0.3 * (phase + 1.7 * k as f64).sin()).collect()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// Number, number per step, field and start together.
#[test]
fn the_remainder_with_the_hessian_has_order_three() {
    let parts = parts();
    let mut history = history(&parts);
    let m = history.start();
    let d = direction(m.len(), 1.0);
    let [gradient, hessian] = second_order_taylor_test(&mut history, &m, &d, 0.2).unwrap();
    println!("{gradient}{hessian}");
    assert!((gradient.second_order().unwrap() - 2.0).abs() < 0.05, "{gradient}");
    assert!((hessian.third_order().unwrap() - 3.0).abs() < 0.1, "{hessian}");
}

#[test]
fn hessians_are_symmetric_and_differences_of_gradients() {
    let parts = parts();
    let mut all = history(&parts);
    let m = all.start();
    let (one, other) = (direction(m.len(), 1.0), direction(m.len(), 2.3));
    let (first, second) = (all.hessian(&m, &one).unwrap(), all.hessian(&m, &other).unwrap());
    let (across, back) = (dot(&first.along, &other), dot(&second.along, &one));
    assert!(
        (across - back).abs() < 1e-12 * dot(&first.along, &one).abs().max(across.abs()),
        "{across} {back}"
    );
    let (value, gradient) = all.value_and_gradient(&m).unwrap();
    assert!((value - first.value).abs() < 1e-13 * value.abs());
    let largest = gradient.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
    assert!(gradient.iter().zip(&first.gradient).all(|(one, other)| (one - other).abs() < 1e-12 * largest));
    let step = 1e-4;
    let mut moved = |step: f64| {
        let moved: Vec<f64> = m.iter().zip(&one).map(|(m, d)| m + step * d).collect();
        all.value_and_gradient(&moved).unwrap().1
    };
    let (above, below) = (moved(step), moved(-step));
    let largest = first.along.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    for ((above, below), exact) in above.iter().zip(&below).zip(&first.along) {
        assert!(((above - below) / (2.0 * step) - exact).abs() < 1e-6 * largest, "{exact}");
    }
    // With two stored states, and the same.
    let few = history(&parts).stored_states(2).hessian(&m, &one).unwrap();
    assert!(few.work.most_stored == 2 && few.work.steps_solved > STEPS, "{:?}", few.work);
    assert!(few.along.iter().zip(&first.along).all(|(few, all)| (few - all).abs() < 1e-11 * largest));
    assert_eq!(history(&parts).second_order(&m, &one).unwrap().along, first.along);
}

#[test]
fn what_second_derivatives_lack_is_told_by_name() {
    let parts = parts();
    let told = |history: LoadHistory<'static, 2>| {
        let (mut history, m) = (history, parts.controls.values());
        history.hessian(m, &vec![1.0; m.len()]).map(|_| ()).unwrap_err().to_string()
    };
    let bare = || {
        LoadHistory::new(&parts.space, STEPS, parts.controls.clone())
            .step(|at| Ok(crept(at, None)?.step(at.before()?)))
            .sensitivities(|at, u, p| Ok(crept(at, None)?.step_sensitivities(u, at.before()?, p)))
            .criterion(|at| Ok(crept(at, None)?.misfit()))
    };
    assert!(told(bare()).contains("the history has no second_sensitivities"), "{}", told(bare()));
    let first_again = || {
        bare().second_sensitivities(|at, states| {
            Ok(crept(at, None)?.step_sensitivities(states.u, at.before()?, states.p))
        })
    };
    assert!(
        told(first_again()).contains("`step_sensitivities` has no test function `by_state`"),
        "{}",
        told(first_again())
    );
    let m = parts.controls.values();
    let short = history(&parts).hessian(m, &m[1..]).map(|_| ()).unwrap_err().to_string();
    assert!(short.contains("were given"), "{short}");
    let uncurved = bare()
        .second_sensitivities(|at, states: &SecondOrderState<2>| {
            let &SecondOrderState { u, p, du, dbefore, dp, along } = states;
            Ok(crept(at, Some(&along))?.step_second_sensitivities(u, at.before()?, p, du, dbefore, dp))
        })
        .with_cost_of_controls(|m| (0.0, vec![0.0; m.len()]));
    assert!(told(uncurved).contains("with_curvature_of_controls"));
}

/// States in files: the same bits, and no file is left; a directory that cannot be made is named.
#[test]
fn stored_states_may_be_files() {
    let parts = parts();
    let m = history(&parts).start();
    let d = direction(m.len(), 1.0);
    let directory = std::env::temp_dir().join(format!("forms_stored_states_{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    for most in [usize::MAX, 3] {
        let mut disk = history(&parts).stored_states(most).states_on_disk(&directory);
        let mut memory = history(&parts).stored_states(most);
        assert_eq!(disk.gradient(&m).unwrap(), memory.gradient(&m).unwrap());
        assert_eq!(disk.hessian(&m, &d).unwrap(), memory.hessian(&m, &d).unwrap());
    }
    assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 0);
    std::fs::remove_dir(&directory).unwrap();
    std::fs::write(&directory, "no directory").unwrap();
    let below = directory.join("below");
    let error = history(&parts).states_on_disk(below).gradient(&m).map(|_| ()).unwrap_err().to_string();
    std::fs::remove_file(&directory).unwrap();
    assert!(error.contains("stored states") && error.contains("forms_stored_states"), "{error}");
}
