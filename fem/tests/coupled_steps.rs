//! Steps of several unknowns: consolidation of a porous column by its closed form, a motion as two equations of first order, unknowns with
//! schemes of their own, files to go on from, and what does not fit.

use std::f64::consts::PI;

use forms_fem::field::FieldError;
use forms_fem::prelude::*;
use forms_fem::solve::LocalUnknowns;
use forms_fem::time::{
    BackwardDifferences, Checkpoint, CheckpointError, GeneralisedAlpha, OneStepTheta, State, Step,
    StepFailure, TimeLoop,
};

use super::time_schemes::{Outcome, cell, same};

/// Biot's equations with incompressible water and grains.
#[forms(dimension = 2)]
mod porous {
    use forms_fem::time::operators::vector::{displacement, velocity};
    use forms_fem::time::operators::vector_and_scalar::value;

    #[includes(forms_fem::time::operators::vector_and_scalar::Data)]
    pub struct Data {
        pub mu: Param,
        pub permeability: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(displacement(u)), eps(v)) - value(p) * div(v))
            + integral(Omega, div(velocity(u)) * q + permeability * dot(grad(value(p)), grad(q)))
            + integral(Top, dot(n, v))
    }
}

/// Terzaghi's column of height 1 with modulus 1, permeability 1 and load 1: displacement and pressure at height z and time t.
fn terzaghi(z: f64, t: f64) -> [f64; 2] {
    let mut found = [-z, 0.0];
    for k in 0..40 {
        let odd = f64::from(2 * k + 1);
        let (sign, wave) = (if k % 2 == 0 { 1.0 } else { -1.0 }, 0.5 * odd * PI);
        let part = 4.0 / PI * sign / odd * (-wave * wave * t).exp();
        found[0] += part / wave * (wave * z).sin();
        found[1] += part * (wave * z).cos();
    }
    found
}

/// The errors of settlement and of the pressure at the bottom after the given number of steps of backward differences.
fn consolidation(steps: usize) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [0.1, 1.0], [1, 16], CellShape::Quadrilateral, 1)?;
    let (displacements, pressures) = (Space::vector(&mesh, 3)?, Space::scalar(&mesh, 2)?);
    let mut held = Constraints::new(&displacements);
    held.fix("bottom", |_| [0.0; 2])?;
    held.fix_component("left", 0, |_| 0.0)?;
    held.fix_component("right", 0, |_| 0.0)?;
    let mut drained = Constraints::new(&pressures);
    drained.fix("top", |_| 0.0)?;
    let (from, size) = (0.1, 0.1 / steps as f64);
    let state = |t: f64| -> Result<[State<2>; 2], FieldError> {
        Ok([
            State::at_rest(t, Field::interpolate(&displacements, |x| [0.0, terzaghi(x[1], t)[0]])?),
            State::at_rest(t, Field::interpolate(&pressures, |x| terzaghi(x[1], t)[1])?),
        ])
    };
    let form = |steps: &[Step<2>; 2]| {
        porous::Model::new(porous::data_from(steps).mu(0.5).permeability(1.0)).balance()
    };
    let mut squeezed = TimeLoop::coupled(form, BackwardDifferences::new(2)?, state(from)?)
        .with_earlier(state(from - size)?)
        .constrained(&held)
        .constrained(&drained)
        .constant_coefficients();
    for _ in 0..steps {
        squeezed.take(size)?;
    }
    let end = squeezed.state().time;
    let [u, p] = squeezed.states() else { return Err("two unknowns".into()) };
    let exact = [terzaghi(1.0, end)[0], terzaghi(0.0, end)[1]];
    Ok([
        (u.value.evaluate(&[0.05, 1.0])?[1] - exact[0]).abs(),
        (p.value.evaluate(&[0.05, 0.0])?[0] - exact[1]).abs(),
    ])
}

#[test]
fn a_porous_column_settles_as_terzaghi_says() -> Outcome {
    let [coarse, fine] = [consolidation(8)?, consolidation(16)?];
    println!("errors of settlement and pressure: {coarse:?} in 8 steps, {fine:?} in 16");
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        let order = (coarse / fine).log2();
        assert!((1.8..2.3).contains(&order) && fine < 2e-4, "{order}: {coarse:e} {fine:e}");
    }
    Ok(())
}

/// x' = s, s' = −7 x − c x³, with unknowns of two scalars, whose members a module has to name itself.
#[forms(dimension = 2)]
mod first_order {
    pub struct Data {
        pub value_weight: Param,
        pub rate_weight: Param,
        pub place: Given<Scalar>,
        pub place_rate: Given<Scalar>,
        pub speed: Given<Scalar>,
        pub speed_rate: Given<Scalar>,
        pub cubic: Param,
    }
    #[cells]
    pub struct Omega;

    fn force(w: Scalar) -> Scalar {
        7 * w + cubic * pow(w, 3)
    }
    pub fn motion(w: Unknown<Scalar>, s: Unknown<Scalar>, y: Test<Scalar>, r: Test<Scalar>) -> Form {
        integral(Omega, (rate_weight * w + place_rate - (value_weight * s + speed)) * y)
            + integral(Omega, (rate_weight * s + speed_rate + force(value_weight * w + place)) * r)
    }
    pub fn linear_motion(w: Unknown<Scalar>, s: Unknown<Scalar>, y: Test<Scalar>, r: Test<Scalar>) -> Form {
        integral(Omega, (rate_weight * w + place_rate - (value_weight * s + speed)) * y)
            + integral(Omega, (rate_weight * s + speed_rate + 7 * (value_weight * w + place)) * r)
    }
}

fn data([position, speed]: &[Step<2>; 2], cubic: f64) -> first_order::Data<2> {
    first_order::data()
        .value_weight(position.weights[0])
        .rate_weight(position.weights[1])
        .place(&position.known[0])
        .place_rate(&position.known[1])
        .speed(&speed.known[0])
        .speed_rate(&speed.known[1])
        .cubic(cubic)
}

/// A motion by the mid-point rule is that of its two equations of first order by the one-step θ method with θ = ½.
#[test]
fn two_equations_of_first_order_are_one_of_second() -> Outcome {
    let space = cell()?;
    for cubic in [0.0, 3.0] {
        let form = |steps: &[Step<2>; 2]| {
            let model = first_order::Model::new(data(steps, cubic));
            if cubic == 0.0 { model.linear_motion() } else { model.motion() }
        };
        let start =
            [State::new(0.0, same(&space, 1.0), same(&space, 0.5))?, State::at_rest(0.0, same(&space, 0.5))];
        let mut both = TimeLoop::coupled(form, OneStepTheta::crank_nicolson(), start);
        let oscillator =
            super::time_schemes::Oscillator { mass: 1.0, damping: 0.0, stiffness: 7.0, force: 0.0 };
        let form = |step: &Step<2>| {
            let model = oscillator.form(cubic)(step);
            if cubic == 0.0 { model.motion() } else { model.hardening() }
        };
        let start = State::new(0.0, same(&space, 1.0), same(&space, 0.5))?;
        let mut one = TimeLoop::new(form, GeneralisedAlpha::mid_point(), start);
        for _ in 0..50 {
            both.take(0.07)?;
            one.take(0.07)?;
        }
        let [x, s] = both.states() else { return Err("two unknowns".into()) };
        for (found, expected) in [(&x.value, &one.state().value), (&s.value, &one.state().rate)] {
            let off = (found.values()[0] - expected.values()[0]).abs();
            assert!(off < 1e-11, "{cubic}: {off:e}");
        }
    }
    Ok(())
}

/// A body that vibrates, and heat in it that knows nothing of that.
#[forms(dimension = 2)]
mod warm {
    use forms_fem::time::operators::vector::{acceleration, displacement};
    use forms_fem::time::operators::vector_and_scalar::{rate, value};

    #[includes(forms_fem::time::operators::vector_and_scalar::Data)]
    pub struct Data {
        pub expansion: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn both(u: Unknown<Vector>, t: Unknown<Scalar>, v: Test<Vector>, s: Test<Scalar>) -> Form {
        integral(
            Omega,
            dot(acceleration(u), v) + inner(eps(displacement(u)), eps(v)) - expansion * value(t) * div(v),
        ) + integral(Omega, rate(t) * s + dot(grad(value(t)), grad(s)))
    }
}

#[forms(dimension = 2)]
mod vibrating {
    use forms_fem::time::operators::vector::{acceleration, displacement};
    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(acceleration(u), v) + inner(eps(displacement(u)), eps(v)))
    }
}

#[forms(dimension = 2)]
mod conducting {
    use forms_fem::time::operators::scalar::{rate, value};
    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    pub fn heat(t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Omega, rate(t) * s + dot(grad(value(t)), grad(s)))
    }
}

struct Warm {
    displacements: Arc<Space<2>>,
    temperatures: Arc<Space<2>>,
    held: Constraints<2>,
}

impl Warm {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let mesh = rectangle([0.0; 2], [1.0, 1.0], [3, 3], CellShape::Quadrilateral, 1)?;
        let (displacements, temperatures) = (Space::vector(&mesh, 1)?, Space::scalar(&mesh, 2)?);
        let mut held = Constraints::new(&displacements);
        held.fix("left", |_| [0.0; 2])?;
        Ok(Warm { displacements, temperatures, held })
    }

    fn start(&self) -> Result<[State<2>; 2], FieldError> {
        Ok([
            State::at_rest(
                0.0,
                Field::interpolate(&self.displacements, |x| [0.1 * x[0], 0.02 * x[0] * x[1]])?,
            ),
            State::at_rest(0.0, Field::interpolate(&self.temperatures, |x| x[0] * x[1])?),
        ])
    }

    fn motion(&self, expansion: f64) -> Result<TimeLoop<'static, 2>, FieldError> {
        let form =
            move |steps: &[Step<2>; 2]| warm::Model::new(warm::data_from(steps).expansion(expansion)).both();
        let motion = TimeLoop::coupled(form, GeneralisedAlpha::mid_point(), self.start()?);
        Ok(motion.scheme_of(1, OneStepTheta::crank_nicolson()).constrained(&self.held))
    }
}

fn off(one: &Field<2>, other: &Field<2>) -> f64 {
    let differences = one.values().iter().zip(other.values()).map(|(one, other)| (one - other).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn unknowns_have_schemes_of_their_own() -> Outcome {
    let body = Warm::new()?;
    let mut both = body.motion(0.0)?;
    let [u, t] = body.start()?;
    let motion = |step: &Step<2>| vibrating::Model::new(vibrating::data_from(step)).motion();
    let mut motion = TimeLoop::new(motion, GeneralisedAlpha::mid_point(), u).constrained(&body.held);
    let heat = |step: &Step<2>| conducting::Model::new(conducting::data_from(step)).heat();
    let mut heat = TimeLoop::new(heat, OneStepTheta::crank_nicolson(), t);
    for _ in 0..20 {
        both.take(0.05)?;
        motion.take(0.05)?;
        heat.take(0.05)?;
    }
    let [u, t] = both.states() else { return Err("two unknowns".into()) };
    for (found, alone) in [(u, motion.state()), (t, heat.state())] {
        assert!(off(&found.value, &alone.value) < 1e-12 && off(&found.rate, &alone.rate) < 1e-11);
    }
    // Warmth moves the body.
    let mut expanding = body.motion(0.3)?;
    expanding.take(0.05)?;
    assert!(off(&expanding.states()[0].value, &body.motion(0.0)?.state().value) > 1e-5);
    Ok(())
}

/// Values that relax in each cell: unknowns of degree zero, which the solver eliminates.
#[forms(dimension = 2)]
mod relaxing {
    pub struct Data {
        pub value_weight: Param,
        pub rate_weight: Param,
        pub warmth: Given<Scalar>,
        pub warmth_rate: Given<Scalar>,
        pub stored: Given<Scalar>,
        pub stored_rate: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    pub fn heat(t: Unknown<Scalar>, z: Unknown<Scalar>, s: Test<Scalar>, y: Test<Scalar>) -> Form {
        integral(Omega, (rate_weight * t + warmth_rate + rate_weight * z + stored_rate) * s)
            + integral(Omega, dot(value_weight * grad(t) + grad(warmth), grad(s)))
            + integral(
                Omega,
                (rate_weight * z + stored_rate - (value_weight * (t - z) + warmth - stored)) * y,
            )
    }
}

#[test]
fn unknowns_of_cells_are_eliminated_in_steps() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0, 1.0], [6, 6], CellShape::Triangle, 1)?;
    let (temperatures, stores) = (Space::scalar(&mesh, 1)?, Space::discontinuous_scalar(&mesh, 0)?);
    let form = |[t, z]: &[Step<2>; 2]| {
        let data = relaxing::data()
            .value_weight(t.weights[0])
            .rate_weight(t.weights[1])
            .warmth(&t.known[0])
            .warmth_rate(&t.known[1])
            .stored(&z.known[0])
            .stored_rate(&z.known[1]);
        relaxing::Model::new(data).heat()
    };
    let start = || -> Result<[State<2>; 2], FieldError> {
        Ok([
            State::at_rest(0.0, Field::interpolate(&temperatures, |x| x[0])?),
            State::at_rest(0.0, Field::zero(&stores)),
        ])
    };
    let (mut eliminating, mut whole): (LocalUnknowns, _) = (LocalUnknowns::default(), LuSolver::default());
    let mut states = vec![];
    for solver in [&mut eliminating as &mut dyn LinearSolver, &mut whole] {
        let mut heat = TimeLoop::coupled(form, OneStepTheta::implicit_euler(), start()?).solver(solver);
        for _ in 0..5 {
            heat.take(0.1)?;
        }
        states.push(heat.states().to_vec());
    }
    let counts = eliminating.report().and_then(|report| report.local_unknowns).ok_or("a report")?;
    assert_eq!(counts.eliminated, stores.unknowns());
    for (one, other) in states[0].iter().zip(&states[1]) {
        assert!(off(&one.value, &other.value) < 1e-13);
    }
    Ok(())
}

#[test]
fn runs_of_several_unknowns_go_on_from_a_file() -> Outcome {
    let (body, directory) = (Warm::new()?, tempfile::tempdir()?);
    let path = directory.path().join("warm.txt");
    let mut whole = body.motion(0.3)?;
    for _ in 0..4 {
        whole.take(0.05)?;
    }
    whole.checkpoint().write(&path)?;
    for _ in 0..3 {
        whole.take(0.05)?;
    }
    let spaces = [&body.displacements, &body.temperatures];
    let read = Checkpoint::read(&path, spaces)?.ok_or("it is there")?;
    let mut resumed = body.motion(0.3)?.resumed(read);
    for _ in 0..3 {
        resumed.take(0.05)?;
    }
    for (one, other) in whole.states().iter().zip(resumed.states()) {
        assert_eq!(one.value.values(), other.value.values());
        assert_eq!(one.second_rate.values(), other.second_rate.values());
    }
    let exchanged = Checkpoint::read(&path, [&body.temperatures, &body.displacements]);
    assert!(matches!(exchanged, Err(CheckpointError::OtherSpace { .. })));
    Ok(())
}

#[test]
fn what_does_not_fit_is_an_error() -> Outcome {
    let body = Warm::new()?;
    let failure = |mut motion: TimeLoop<'_, 2>| motion.take(0.05).map(|_| ()).map_err(|error| error.why);
    let trapezoidal = body.motion(0.3)?.scheme_of(0, GeneralisedAlpha::trapezoidal());
    let found = failure(trapezoidal);
    assert!(matches!(&found, Err(StepFailure::Schemes { unknown: 1, .. })), "{found:?}");
    let found = failure(body.motion(0.3)?.scheme_of(2, OneStepTheta::crank_nicolson()));
    assert!(matches!(found, Err(StepFailure::NoUnknown { unknown: 2, count: 2 })), "{found:?}");
    let found = failure(body.motion(0.3)?.constrained(&body.held));
    assert!(matches!(found, Err(StepFailure::Unconstrained)), "{found:?}");
    let [u, mut t] = body.start()?;
    t.time = 1.0;
    let form = |steps: &[Step<2>; 2]| warm::Model::new(warm::data_from(steps).expansion(0.0)).both();
    let found = failure(TimeLoop::coupled(form, GeneralisedAlpha::mid_point(), [u, t]));
    assert!(matches!(found, Err(StepFailure::NotEarlier { .. })), "{found:?}");
    Ok(())
}
