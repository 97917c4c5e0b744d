//! Events: numbers of a state that pass zero in a step, compared with a fall and an oscillation with closed forms; the work of linear steps.

use forms_fem::output::TimeSeries;
use forms_fem::prelude::*;
use forms_fem::time::{
    AdaptiveSteps, BackwardDifferences, CentralDifferences, Events, GeneralisedAlpha, Scheme, State, Step,
    StepFailure, TimeLoop,
};

use super::time_schemes::{OSCILLATOR, Oscillator, Outcome, cell, same, spring};

const GRAVITY: f64 = 3.0;
const HEIGHT: f64 = 2.0;

/// Free fall from a height, at rest.
fn falling(space: &Arc<Space<2>>, scheme: impl Scheme + 'static) -> TimeLoop<'static, 2> {
    let form = |step: &Step<2>| {
        let (mass, force) = (2.0, -2.0 * GRAVITY);
        spring::Model::new(
            spring::data_from(step).mass(mass).damping(0.0).stiffness(0.0).cubic(0.0).force(force),
        )
        .motion()
    };
    TimeLoop::new(form, scheme, State::at_rest(1.0, same(space, HEIGHT)))
}

fn height(state: &State<2>) -> f64 {
    state.value.values()[2]
}

/// t = √(2h/g), the speed √(2gh), and half the height at t/√2, in steps of any scheme that a parabola suits.
#[test]
fn a_fall_ends_at_the_ground() -> Outcome {
    let space = cell()?;
    let lands = 1.0 + (2.0 * HEIGHT / GRAVITY).sqrt();
    let schemes: [Box<dyn Scheme>; 3] = [
        Box::new(GeneralisedAlpha::trapezoidal()),
        Box::new(GeneralisedAlpha::mid_point()),
        Box::new(GeneralisedAlpha::with_spectral_radius(0.5)?),
    ];
    for scheme in schemes {
        let name = format!("{scheme:?}");
        let mut motion = falling(&space, Boxed(scheme));
        let mut events = Events::new()
            .of("ground", |state| Ok(height(state)))
            .of("half way", |state| Ok(height(state) - HEIGHT / 2.0))
            .located(1e-11)?;
        let mut met = vec![];
        while motion.state().time < 2.5 {
            let from = motion.state().time;
            let step = events.take(&mut motion, 0.3)?;
            assert_eq!(motion.state().time, step.taken.to);
            assert!(step.tries < 20 && step.events.len() < 2, "{step:?}");
            for event in step.events {
                assert!(event.passage.time > from && event.passage.time <= step.taken.to);
                assert!(step.taken.to - event.passage.time <= 1e-11 && !event.passage.rises);
                met.push((event.name, step.taken.to, motion.state().rate.values()[0]));
            }
        }
        let [(half, at_half, _), (ground, at_ground, speed)] = &met[..] else { panic!("{name}: {met:?}") };
        assert_eq!((half.as_str(), ground.as_str()), ("half way", "ground"));
        let expected = 1.0 + (lands - 1.0) / 2.0_f64.sqrt();
        assert!((at_half - expected).abs() < 2e-11 && (at_ground - lands).abs() < 2e-11, "{name}: {met:?}");
        assert!((speed + (2.0 * GRAVITY * HEIGHT).sqrt()).abs() < 1e-9, "{name}: {speed}");
    }
    Ok(())
}

/// A scheme chosen when the program runs.
#[derive(Debug)]
struct Boxed(Box<dyn Scheme>);

impl Scheme for Boxed {
    fn states(&self) -> usize {
        self.0.states()
    }
    fn reads_second_rates(&self) -> bool {
        self.0.reads_second_rates()
    }
    fn formulas(&self, steps: &[f64]) -> forms_fem::time::Formulas {
        self.0.formulas(steps)
    }
}

/// Zeros of cos(ωt) by schemes of order two; one reads two states and so steps of two sizes; nonlinear forms and adaptive
/// steps come to events, too.
#[test]
fn zeros_of_an_oscillation_have_the_scheme_s_order() -> Outcome {
    let space = cell()?;
    let free = Oscillator { damping: 0.0, force: 0.0, ..OSCILLATOR };
    let omega = (free.stiffness / free.mass).sqrt();
    let exact: Vec<f64> = (0..3).map(|k| (f64::from(k) + 0.5) * std::f64::consts::PI / omega).collect();
    let zeros = |scheme: Boxed, size: f64, cubic: f64| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let nonlinear = move |step: &Step<2>| free.form(cubic)(step).hardening();
        let linear = move |step: &Step<2>| free.form(0.0)(step).motion();
        let start = State::at_rest(0.0, same(&space, 1.0));
        let mut motion = match cubic {
            0.0 => TimeLoop::new(linear, scheme, start),
            _ => TimeLoop::new(nonlinear, scheme, start),
        };
        let mut events = Events::new().of("u", |state| Ok(height(state))).located(1e-9)?;
        let mut found = vec![];
        while found.len() < 3 {
            let step = events.take(&mut motion, size)?;
            found.extend(step.events.iter().map(|event| event.passage.time));
            let rises = step.events.first().map(|event| event.passage.rises);
            assert!(rises.is_none_or(|rises| rises == (found.len() == 2)));
        }
        Ok(found)
    };
    let schemes: [fn() -> Boxed; 2] = [
        || Boxed(Box::new(GeneralisedAlpha::trapezoidal())),
        || Boxed(Box::new(BackwardDifferences::new(2).expect("an order"))),
    ];
    for scheme in schemes {
        let errors = [0.01, 0.005].map(|size| {
            let found = zeros(scheme(), size, 0.0).expect("zeros");
            found.iter().zip(&exact).map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max)
        });
        let order = (errors[0] / errors[1]).log2();
        assert!((order - 2.0).abs() < 0.15 && errors[1] < 1e-3, "{:?}: {errors:?}", scheme());
    }
    // A stiffer spring comes through earlier; its own times by smaller and smaller steps.
    let trapezoidal = || Boxed(Box::new(GeneralisedAlpha::trapezoidal()));
    let found = [0.04, 0.02, 0.01].map(|size| zeros(trapezoidal(), size, 4.0).expect("zeros")[2]);
    let ratio = (found[0] - found[1]) / (found[1] - found[2]);
    assert!(found[2] < exact[2] && (ratio - 4.0).abs() < 0.3, "{found:?}");
    let form = move |step: &Step<2>| free.form(0.0)(step).motion();
    let mut motion =
        TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), State::at_rest(0.0, same(&space, 1.0)));
    let mut steps = AdaptiveSteps::new(0.05, 1e-7)?;
    let mut events = Events::new().of("u", |state| Ok(height(state))).located(1e-9)?;
    let mut found = vec![];
    while motion.state().time < 2.0 {
        let step = events.take_adaptive(&mut motion, &mut steps, 2.0)?;
        found.extend(step.events);
    }
    assert!(motion.state().time == 2.0 && found.len() == 1 && !found[0].passage.rises);
    assert!((found[0].passage.time - exact[0]).abs() < 1e-4, "{found:?}");
    Ok(())
}

#[test]
fn steps_stay_whole_where_events_are_not_located() -> Outcome {
    let space = cell()?;
    let (mut watched, mut alone) = (falling(&space, CentralDifferences), falling(&space, CentralDifferences));
    let mut events = Events::new().of("ground", |state| Ok(height(state)));
    let (mut series, mut met) = (TimeSeries::new(["height"]), vec![]);
    series.push(1.0, &[HEIGHT])?;
    for _ in 0..5 {
        let step = events.take(&mut watched, 0.3)?;
        alone.take(0.3)?;
        assert_eq!((step.tries, watched.state().time), (0, alone.state().time));
        assert_eq!(watched.state().value.values(), alone.state().value.values());
        series.push(alone.state().time, &[height(alone.state())])?;
        met.extend(step.events);
    }
    let expected = series.passages("height", 0.0)?;
    assert_eq!(met.iter().map(|event| event.passage).collect::<Vec<_>>(), expected);
    assert_eq!(expected.len(), 1);
    Ok(())
}

#[test]
fn a_number_that_does_not_exist_is_named_and_leaves_the_motion_where_it_was() -> Outcome {
    let space = cell()?;
    let mut motion = falling(&space, GeneralisedAlpha::trapezoidal());
    let mut events = Events::new().of("root", |state| Ok((height(state) - 1.0).sqrt()));
    let mut taken = 0;
    let error = loop {
        let before = motion.checkpoint();
        match events.take(&mut motion, 0.3) {
            Ok(_) => taken += 1,
            Err(error) => {
                assert_eq!((motion.steps(), motion.state().time), (taken, before.states[0][0].time));
                break error;
            }
        }
    };
    assert!(matches!(error.why, StepFailure::Event { .. }));
    assert!(error.to_string().contains("`root` of the state at this time: it is NaN"), "{error}");
    let mut refused = Events::new().of("probe", |state: &State<2>| Ok(state.value.evaluate(&[5.0, 0.0])?[0]));
    let error = refused.take(&mut motion, 0.3).err().ok_or("the point lies outside")?;
    assert!(error.to_string().contains("`probe`"), "{error}");
    for within in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Events::<2>::new().located(within), Err(StepFailure::Tolerance(_))));
    }
    Ok(())
}

/// A tolerance below what numbers can tell ends at neighbouring ones.
#[test]
fn events_are_located_to_neighbouring_numbers_at_most() -> Outcome {
    let space = cell()?;
    let mut motion = falling(&space, GeneralisedAlpha::trapezoidal());
    let mut events = Events::new().of("ground", |state| Ok(height(state))).located(1e-300)?;
    let lands = 1.0 + (2.0 * HEIGHT / GRAVITY).sqrt();
    loop {
        let step = events.take(&mut motion, 0.4)?;
        if !step.events.is_empty() {
            assert!((step.taken.to - lands).abs() < 1e-14 && step.tries < 200, "{step:?}");
            return Ok(());
        }
    }
}

/// One residual and one solve in a step whose coefficients are promised to be constant, one residual more where it is looked into.
#[test]
fn a_linear_step_is_one_residual_and_one_solve() -> Outcome {
    let space = cell()?;
    let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| 1.0)?;
    for constant in [true, false] {
        let mut solver = TangentSolver::default();
        let start = State::at_rest(0.0, same(&space, 1.0));
        let motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start).constrained(&held);
        let mut motion = if constant { motion.constant_coefficients() } else { motion }.solver(&mut solver);
        for number in 0..40 {
            let taken = motion.take(0.1)?;
            let cost = taken.cost.ok_or("it is affine")?;
            let looked = !constant || number % 32 == 0;
            let counts = [cost.residuals, cost.matrices, cost.solves];
            assert_eq!(counts, [1 + usize::from(looked), usize::from(number == 0), 1], "step {number}");
            let parts = cost.residual_seconds + cost.matrix_seconds + cost.solve_seconds;
            assert!(cost.residual_seconds > 0.0 && cost.solve_seconds > 0.0 && parts <= cost.seconds);
            // Forces where the value is held, also where the residual was not assembled at the end.
            let form = OSCILLATOR.form(0.0);
            let step = Step {
                before: motion.state().clone(),
                end: taken.to,
                time: taken.to,
                weights: [0.0; 3],
                known: [&motion.state().value, &motion.state().rate, &motion.state().second_rate]
                    .map(Field::clone),
            };
            let whole = Assembler::new(space.mesh()).residual(
                &form(&step).motion(),
                &[&motion.state().value],
                &[&space],
            )?;
            for (found, expected) in taken.residual.iter().zip(&whole) {
                assert!((found - expected).abs() < 1e-12, "step {number}: {found} is not {expected}");
            }
        }
        drop(motion);
        // With the start's second rate.
        assert_eq!((solver.report().solves, solver.report().factorisations), (41, 2));
    }
    Ok(())
}
