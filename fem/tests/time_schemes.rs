//! Schemes of time integration: their orders on an oscillator and on decay with closed forms, and their counts of factorisations.

use forms_fem::prelude::*;
use forms_fem::time::{
    AdaptiveSteps, BackwardDifferences, CentralDifferences, Checkpoint, CheckpointError, GeneralisedAlpha,
    Mass, OneStepTheta, Scheme, State, Step, StepFailure, TimeLoop,
};

type Outcome = Result<(), Box<dyn std::error::Error>>;

#[forms(dimension = 2)]
mod spring {
    use forms_fem::time::operators::scalar::{rate, second_rate, value};

    #[extends(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub mass: Param,
        pub damping: Param,
        pub stiffness: Param,
        pub cubic: Param,
        pub force: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let linear = mass * second_rate(u) + damping * rate(u) + stiffness * value(u);
        integral(Omega, (linear - force) * v)
    }
    pub fn hardening(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let linear = mass * second_rate(u) + damping * rate(u) + stiffness * value(u);
        integral(Omega, (linear + cubic * pow(value(u), 3) - force) * v)
    }
}

/// Oscillators of their own on the cells.
#[forms(dimension = 2)]
mod springs {
    use forms_fem::time::operators::scalar::{second_rate, value};

    #[extends(forms_fem::time::operators::scalar::Data)]
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

/// m ü + c u̇ + k u = F cos(Ω t) on one cell, with all nodes alike.
#[derive(Clone, Copy)]
struct Oscillator {
    mass: f64,
    damping: f64,
    stiffness: f64,
    force: f64,
}

const DRIVEN: f64 = 1.7;

impl Oscillator {
    fn form(self, cubic: f64) -> impl Fn(&Step<2>) -> spring::Model<2> {
        move |step| {
            let Oscillator { mass, damping, stiffness, force } = self;
            let force = force * (DRIVEN * step.time).cos();
            spring::Model::new(spring::Data { base: step.into(), mass, damping, stiffness, cubic, force })
        }
    }

    /// The solution that begins at 1 with the rate ½: free vibration beside the driven one.
    fn exact(&self, t: f64) -> f64 {
        let Oscillator { mass, damping, stiffness, force } = *self;
        let (a, b) = (stiffness - mass * DRIVEN * DRIVEN, damping * DRIVEN);
        let (cosine, sine) = (force * a / (a * a + b * b), force * b / (a * a + b * b));
        let decay = damping / (2.0 * mass);
        let omega = (stiffness / mass - decay * decay).sqrt();
        let (start, slope) = (1.0 - cosine, 0.5 - DRIVEN * sine);
        let free = (-decay * t).exp()
            * (start * (omega * t).cos() + (slope + decay * start) / omega * (omega * t).sin());
        free + cosine * (DRIVEN * t).cos() + sine * (DRIVEN * t).sin()
    }

    fn exact_rate(&self, t: f64) -> f64 {
        (self.exact(t + 1e-5) - self.exact(t - 1e-5)) / 2e-5
    }
}

fn cell() -> Result<Arc<Space<2>>, Box<dyn std::error::Error>> {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?);
    Ok(Space::scalar(&mesh, 1)?)
}

fn same(space: &Arc<Space<2>>, value: f64) -> Field<2> {
    Field::interpolate(space, |_| value).expect("a finite value")
}

const OSCILLATOR: Oscillator = Oscillator { mass: 2.0, damping: 0.6, stiffness: 7.0, force: 1.5 };

/// The error at t = 2 after so many steps of an oscillator, in value and rate.
fn error(scheme: impl Scheme, steps: usize, mass: Mass) -> Result<f64, Box<dyn std::error::Error>> {
    let (space, size) = (cell()?, 2.0 / steps as f64);
    let state = |t: f64| {
        let (value, rate) = (OSCILLATOR.exact(t), OSCILLATOR.exact_rate(t));
        State::new(t, same(&space, value), same(&space, rate))
    };
    let earlier: Vec<_> =
        (1..scheme.states()).map(|k| state(-(k as f64) * size)).collect::<Result<_, _>>()?;
    let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
    let mut motion = TimeLoop::new(form, scheme, state(0.0)?).with_earlier(earlier).mass(mass);
    for _ in 0..steps {
        motion.take(size)?;
    }
    let end = motion.state();
    assert!((end.time - 2.0).abs() < 1e-12);
    let off = (end.value.values()[0] - OSCILLATOR.exact(2.0)).abs();
    Ok(off + (end.rate.values()[3] - OSCILLATOR.exact_rate(2.0)).abs())
}

fn order(scheme: impl Scheme + Clone, mass: Mass) -> Result<f64, Box<dyn std::error::Error>> {
    let errors = [error(scheme.clone(), 40, mass)?, error(scheme, 80, mass)?];
    assert!(errors[0] < 0.5, "{errors:?}");
    Ok((errors[0] / errors[1]).log2())
}

#[test]
fn schemes_for_second_order_have_their_orders() -> Outcome {
    let of_second_order = [
        GeneralisedAlpha::trapezoidal(),
        GeneralisedAlpha::mid_point(),
        GeneralisedAlpha::hilber_hughes_taylor(0.2)?,
        GeneralisedAlpha::wood_bossak_zienkiewicz(0.6)?,
        GeneralisedAlpha::with_spectral_radius(0.5)?,
        GeneralisedAlpha::with_spectral_radius(0.0)?,
    ];
    for scheme in of_second_order {
        let order = order(scheme, Mass::Consistent)?;
        assert!((order - 2.0).abs() < 0.15, "{scheme:?} {order}");
    }
    let order_of_one = order(GeneralisedAlpha::newmark(0.36, 0.7)?, Mass::Consistent)?;
    assert!((order_of_one - 1.0).abs() < 0.15, "{order_of_one}");
    for mass in [Mass::Consistent, Mass::Lumped] {
        let order = order(CentralDifferences, mass)?;
        assert!((order - 2.0).abs() < 0.15, "{order}");
    }
    for k in 1..=4 {
        let order = order(BackwardDifferences::new(k)?, Mass::Consistent)?;
        assert!((order - k as f64).abs() < 0.3, "{k} {order}");
    }
    Ok(())
}

/// The order in which the errors at t = 1 of c u̇ + k u = F cos Ωt fall, from ten steps to twenty.
fn order_of_decay(scheme: impl Scheme + Copy) -> Result<f64, Box<dyn std::error::Error>> {
    let decay = Oscillator { mass: 0.0, damping: 1.3, stiffness: 2.0, force: 1.5 };
    let (a, b) = (decay.stiffness, decay.damping * DRIVEN);
    let (cosine, sine) = (decay.force * a / (a * a + b * b), decay.force * b / (a * a + b * b));
    let exact = |t: f64| {
        (1.0 - cosine) * (-decay.stiffness / decay.damping * t).exp()
            + cosine * (DRIVEN * t).cos()
            + sine * (DRIVEN * t).sin()
    };
    let space = cell()?;
    let error = |steps: usize| -> Result<f64, Box<dyn std::error::Error>> {
        let size = 1.0 / steps as f64;
        let state = |t: f64| State::at_rest(t, same(&space, exact(t)));
        let earlier: Vec<_> = (1..scheme.states()).map(|k| state(-(k as f64) * size)).collect();
        let form = |step: &Step<2>| decay.form(0.0)(step).motion();
        let mut cooling = TimeLoop::new(form, scheme, state(0.0)).with_earlier(earlier);
        for _ in 0..steps {
            cooling.take(size)?;
        }
        Ok((cooling.state().value.values()[0] - exact(1.0)).abs())
    };
    Ok((error(10)? / error(20)?).log2())
}

#[test]
fn schemes_for_first_order_have_their_orders() -> Outcome {
    let euler = order_of_decay(OneStepTheta::implicit_euler())?;
    assert!((euler - 1.0).abs() < 0.35, "{euler}");
    let crank_nicolson = order_of_decay(OneStepTheta::crank_nicolson())?;
    assert!((crank_nicolson - 2.0).abs() < 0.35, "{crank_nicolson}");
    for k in [2, 3, 5] {
        let order = order_of_decay(BackwardDifferences::new(k)?)?;
        assert!((order - k as f64).abs() < 0.35, "{k} {order}");
    }
    Ok(())
}

#[test]
fn a_hardening_spring_keeps_its_order() -> Outcome {
    // u = cn(ωt | k²)-like motion has no elementary form: Richardson's quotient of three runs shows the order.
    let space = cell()?;
    let end = |steps: usize| -> Result<f64, Box<dyn std::error::Error>> {
        let form = |step: &Step<2>| OSCILLATOR.form(4.0)(step).hardening();
        let start = State::at_rest(0.0, same(&space, 1.0));
        let mut motion = TimeLoop::new(form, GeneralisedAlpha::with_spectral_radius(0.8)?, start);
        for _ in 0..steps {
            let taken = motion.take(1.0 / steps as f64)?;
            assert!(taken.history.len() > 1, "Newton's method solves it");
        }
        Ok(motion.state().value.values()[2])
    };
    let [coarse, middle, fine] = [end(20)?, end(40)?, end(80)?];
    let order = ((coarse - middle) / (middle - fine)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
    Ok(())
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

/// One beside another that is 10¹³ times as heavy and as stiff.
#[test]
fn a_soft_spring_that_changes_is_not_hidden_by_a_stiff_one() -> Outcome {
    let mesh = Arc::new(rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1)?);
    let space = Space::discontinuous_scalar(&mesh, 0)?;
    let form = |step: &Step<2>| {
        let soft = if step.time > 0.95 { 9.0 } else { 7.0 };
        let of_cells = |left: f64, right: f64| {
            Given::function(move |x: &[f64; 2]| if x[0] < 1.0 { left } else { right })
        };
        let (mass, stiffness) = (of_cells(1e13, 1.0), of_cells(7e13, soft));
        springs::Model::new(springs::Data { base: step.into(), mass, stiffness }).motion()
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
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?);
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
    let mesh = Arc::new(rectangle([0.0; 2], [1.0, 2.0], [1, 1], CellShape::Quadrilateral, 1)?);
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
        let base = step.into();
        let data = spring::Data { base, mass: 1.0, damping: 0.0, stiffness: 100.0, cubic: 0.0, force };
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
