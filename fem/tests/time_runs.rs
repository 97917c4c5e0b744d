//! Runs of steps: factors that are shared, coefficients that change, files to go on from, steps chosen by their error.

use forms_fem::prelude::*;
use forms_fem::time::{
    AdaptiveSteps, BackwardDifferences, CentralDifferences, Checkpoint, CheckpointError, GeneralisedAlpha,
    Mass, State, Step, StepFailure, TimeLoop,
};

use super::time_schemes::{OSCILLATOR, Oscillator, Outcome, cell, same, spring};

/// Oscillators of their own on the cells.
#[forms(dimension = 2)]
mod springs {
    use forms_fem::time::operators::scalar::{second_rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub mass: Given<Scalar>,
        pub stiffness: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (mass * second_rate(u) + stiffness * value(u)) * v)
    }
}

#[test]
fn steps_of_one_size_share_a_factor() -> Outcome {
    let (space, mut solver) = (cell()?, TangentSolver::default());
    for (constant, sizes, factors) in
        [(true, vec![0.1; 100], 2), (false, vec![0.1; 100], 2), (false, vec![0.1, 0.1, 0.05, 0.1], 4)]
    {
        let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
        let start = State::at_rest(0.0, same(&space, 1.0));
        let before = solver.report().factorisations;
        let analyses = solver.report().analyses;
        {
            let motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start).solver(&mut solver);
            let mut motion = if constant { motion.constant_coefficients() } else { motion };
            for size in sizes {
                motion.take(size)?;
            }
        }
        // The mass for the first acceleration, and the matrix of each new step size.
        assert_eq!(solver.report().factorisations - before, factors);
        assert!(solver.report().analyses - analyses <= 1);
    }
    // Orders one, two and three, each with its own weights.
    let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
    let before = solver.report().factorisations;
    let start = State::at_rest(0.0, same(&space, 1.0));
    let mut motion = TimeLoop::new(form, BackwardDifferences::new(3)?, start).solver(&mut solver);
    for _ in 0..100 {
        motion.take(0.1)?;
    }
    drop(motion);
    assert_eq!(solver.report().factorisations - before, 3);
    Ok(())
}

#[test]
fn coefficients_that_change_do_not_go_unnoticed() -> Outcome {
    let space = cell()?;
    // From the fortieth step on the spring is stiffer.
    let form = |step: &Step<2>| {
        let stiffness = if step.time > 3.95 { 9.0 } else { 7.0 };
        Oscillator { stiffness, ..OSCILLATOR }.form(0.0)(step).motion()
    };
    let start = || State::at_rest(0.0, same(&space, 1.0));
    let mut checked = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start());
    for _ in 0..100 {
        checked.take(0.1)?;
    }
    // The same as a run with a fresh loop from there.
    let mut before = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start());
    for _ in 0..39 {
        before.take(0.1)?;
    }
    let mut after =
        TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start()).resumed(before.checkpoint());
    for _ in 39..100 {
        after.take(0.1)?;
    }
    let values = [&checked, &after].map(|run| run.state().value.values()[0]);
    assert!((values[0] - values[1]).abs() < 1e-10, "{values:?}");
    let mut promised = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start()).constant_coefficients();
    let error = (0..100).find_map(|_| promised.take(0.1).err()).ok_or("it is found out")?;
    assert!(matches!(error.why, StepFailure::CoefficientsChanged { .. }), "{error}");
    Ok(())
}

/// One next to another that is 10¹³ times as heavy and as stiff.
#[test]
fn a_soft_spring_that_changes_is_not_hidden_by_a_stiff_one() -> Outcome {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::discontinuous_scalar(&mesh, 0)?;
    let form = |step: &Step<2>| {
        let soft = if step.time > 0.95 { 9.0 } else { 7.0 };
        let of_cells = |left: f64, right: f64| {
            Given::function(move |x: &[f64; 2]| if x[0] < 1.0 { left } else { right })
        };
        let (mass, stiffness) = (of_cells(1e13, 1.0), of_cells(7e13, soft));
        springs::Model::new(springs::data_from(step).mass(mass).stiffness(stiffness)).motion()
    };
    let start = || State::at_rest(0.0, same(&space, 1.0));
    let mut checked = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start());
    let mut promised = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start()).constant_coefficients();
    for _ in 0..9 {
        checked.take(0.1)?;
    }
    let before = checked.checkpoint();
    for _ in 9..20 {
        checked.take(0.1)?;
    }
    let mut fresh = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start()).resumed(before);
    for _ in 9..20 {
        fresh.take(0.1)?;
    }
    for (found, expected) in checked.state().value.values().iter().zip(fresh.state().value.values()) {
        assert!((found - expected).abs() < 1e-10, "{found} is not {expected}");
    }
    let error = (0..40).find_map(|_| promised.take(0.1).err()).ok_or("it is found out")?;
    assert!(matches!(error.why, StepFailure::CoefficientsChanged { .. }), "{error}");
    Ok(())
}

#[test]
fn what_is_no_step_is_refused() -> Outcome {
    let space = cell()?;
    let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
    let mut motion = TimeLoop::new(form, CentralDifferences, State::at_rest(1.0, same(&space, 1.0)));
    for size in [0.0, -0.1, f64::NAN, f64::INFINITY, 1e-20] {
        assert!(matches!(motion.take(size).map_err(|e| e.why), Err(StepFailure::StepSize(_))), "{size}");
    }
    let message = GeneralisedAlpha::newmark(0.1, 0.5).map_err(|error| error.to_string());
    assert_eq!(message, Err("β = 0.1 of Newmark's method: it lies between 0.25 and 1".to_owned()));
    let start = || State::at_rest(1.0, same(&space, 1.0));
    let order = BackwardDifferences::new(2)?;
    let mut motion = TimeLoop::new(form, order, start()).with_earlier([start()]);
    assert!(matches!(motion.take(0.1).map_err(|e| e.why), Err(StepFailure::NotEarlier { .. })));
    // A support that moves, in explicit steps; vertices of quadratic triangles have no lumped mass.
    let moving = |t: f64| {
        let mut moving = Constraints::new(&space);
        moving.fix("left", |_| t)?;
        Ok(moving)
    };
    let start = State::at_rest(0.0, same(&space, 0.0));
    let mut motion = TimeLoop::new(form, CentralDifferences, start).constrained_at(moving);
    let error = motion.take(0.1).err().ok_or("the support moves")?;
    assert!(
        error.to_string().contains("from t = 0 to 0.1") && error.to_string().contains("goes from"),
        "{error}"
    );
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut motion = TimeLoop::new(form, CentralDifferences, State::at_rest(0.0, same(&space, 1.0)));
    assert!(motion.take(0.1).is_ok());
    let start = State::at_rest(0.0, same(&space, 1.0));
    let mut motion = TimeLoop::new(form, CentralDifferences, start).mass(Mass::Lumped);
    assert!(matches!(motion.take(0.1).map_err(|e| e.why), Err(StepFailure::NoMass { .. })));
    Ok(())
}

#[test]
fn a_run_goes_on_from_a_file_with_the_same_bits() -> Outcome {
    let space = cell()?;
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("states.txt");
    let linear = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
    let hardening = |step: &Step<2>| OSCILLATOR.form(4.0)(step).hardening();
    let start = || State::at_rest(0.0, same(&space, 1.0));
    let run = |begin: &dyn Fn() -> TimeLoop<'static, 2>| -> Outcome {
        let (mut whole, mut part) = (begin(), begin());
        for step in 0..50 {
            whole.take(0.1)?;
            if step < 20 {
                part.take(0.1)?;
            }
        }
        part.checkpoint().write(&path)?;
        let read = Checkpoint::read(&path, &space)?.ok_or("it is there")?;
        let mut rest = begin().resumed(read);
        for _ in 20..50 {
            rest.take(0.1)?;
        }
        assert_eq!(whole.steps(), rest.steps());
        let bits = |motion: &TimeLoop<'_, 2>| {
            let State { time, value, rate, second_rate } = motion.state();
            let fields = [value, rate, second_rate].map(|field| field.values().to_vec()).concat();
            [vec![*time], fields].concat().into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(bits(&whole), bits(&rest));
        Ok(())
    };
    run(&|| TimeLoop::new(linear, BackwardDifferences::new(3).expect("an order"), start()))?;
    run(&|| TimeLoop::new(linear, GeneralisedAlpha::trapezoidal(), start()).constant_coefficients())?;
    run(&|| TimeLoop::new(hardening, GeneralisedAlpha::mid_point(), start()))?;
    run(&|| TimeLoop::new(hardening, CentralDifferences, start()).mass(Mass::Lumped))?;

    // No file, another space, a damaged file.
    assert!(Checkpoint::read(directory.path().join("none"), &space)?.is_none());
    let mesh = rectangle([0.0; 2], [1.0, 2.0], [1, 1], CellShape::Quadrilateral, 1)?;
    let other = Checkpoint::read(&path, &Space::scalar(&mesh, 1)?);
    assert!(matches!(other, Err(CheckpointError::OtherSpace { .. })));
    let text = std::fs::read_to_string(&path)?;
    for damaged in [format!("{}7\n", text.trim_end()), text[..text.len() / 2].to_owned(), String::new()] {
        std::fs::write(&path, damaged)?;
        assert!(matches!(Checkpoint::read(&path, &space), Err(CheckpointError::Content { .. })));
    }
    Ok(())
}

#[test]
fn adaptive_steps_keep_their_tolerance() -> Outcome {
    let space = cell()?;
    // At rest until a load comes at t = 1.
    let form = |step: &Step<2>| {
        let force = if step.time > 1.0 { 40.0 } else { 0.0 };
        let data = spring::data_from(step).mass(1.0).damping(0.0).stiffness(100.0).cubic(0.0).force(force);
        spring::Model::new(data).motion()
    };
    let exact = |t: f64| 0.4 * (1.0 - (10.0 * (t - 1.0)).cos());
    let mut errors = vec![];
    for tolerance in [1e-5, 1e-7] {
        let start = State::at_rest(0.0, same(&space, 0.0));
        let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start);
        let mut steps = AdaptiveSteps::new(0.25, tolerance)?;
        while motion.state().time < 2.0 {
            let taken = steps.take(&mut motion, 2.0)?;
            assert!(taken.error.ok_or("it is estimated")? <= tolerance);
            if taken.to <= 1.0 {
                assert!((taken.to - taken.from - 0.25).abs() < 1e-12, "nothing happens before");
            }
        }
        assert_eq!(motion.state().time, 2.0);
        assert!(steps.rejected() > 2 && motion.steps() < 4000, "{} {}", steps.rejected(), motion.steps());
        errors.push((motion.state().value.values()[0] - exact(2.0)).abs());
    }
    assert!(errors[0] < 1e-2 && errors[1] < errors[0] / 5.0, "{errors:?}");
    assert!(AdaptiveSteps::new(f64::NAN, 1.0).is_err() && AdaptiveSteps::new(1.0, 0.0).is_err());
    Ok(())
}
