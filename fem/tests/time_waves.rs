//! A wave in a bar with a support that moves, compared with d'Alembert's solution: order in time, reactions, and a film on disk.

use forms_fem::output::{VtuFile, VtuSeries};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, GeneralisedAlpha, Scheme, State, Step, TimeLoop,
};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

#[forms(dimension = 2)]
mod bar {
    use forms_fem::time::operators::vector::{acceleration, displacement};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        pub rho: Param,
        pub youngs_modulus: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let stress = youngs_modulus * eps(displacement(u));
        integral(Omega, rho * dot(acceleration(u), v) + inner(stress, eps(v)))
    }
    pub fn energy(u: State<Vector>, velocity: State<Vector>) -> Functional {
        integral(Omega, rho * dot(velocity, velocity) / 2 + youngs_modulus * inner(eps(u), eps(u)) / 2)
    }
}

const DENSITY: f64 = 2.0;
const YOUNGS_MODULUS: f64 = 8.0;
/// u = sin(κ x) sin(c κ t), c² = E/ρ.
const WAVE_NUMBER: f64 = 2.2;

fn frequency() -> f64 {
    (YOUNGS_MODULUS / DENSITY).sqrt() * WAVE_NUMBER
}

fn form(step: &Step<2>) -> Form<2> {
    model(step.into()).motion()
}

fn model(step: forms_fem::time::operators::vector::Data<2>) -> bar::Model<2> {
    bar::Model::new(bar::data_from(step).rho(DENSITY).youngs_modulus(YOUNGS_MODULUS))
}

/// A bar on 0..1 with elements of degree three, whose error is far below that of the steps.
fn space() -> Outcome<Arc<Space<2>>> {
    let mesh = rectangle([0.0; 2], [1.0, 0.1], [10, 1], CellShape::Quadrilateral, 1)?;
    Ok(Space::vector(&mesh, 3)?)
}

fn exact(space: &Arc<Space<2>>, time: f64) -> Outcome<State<2>> {
    let (phase, omega) = (frequency() * time, frequency());
    let value = Field::interpolate(space, |x| [(WAVE_NUMBER * x[0]).sin() * phase.sin(), 0.0])?;
    let rate = Field::interpolate(space, |x| [omega * (WAVE_NUMBER * x[0]).sin() * phase.cos(), 0.0])?;
    Ok(State::new(time, value, rate)?)
}

/// Follows the wave for half a unit of time: the largest error of a displacement, and of the reaction at x = 0 per height.
fn follow(scheme: impl Scheme, steps: usize) -> Outcome<[f64; 2]> {
    let (space, size) = (space()?, 0.5 / steps as f64);
    let constraints = |time: f64| {
        let mut constraints = Constraints::new(&space);
        constraints.fix_component("all", 1, |_| 0.0)?;
        constraints.fix_component("left", 0, |_| 0.0)?;
        constraints.fix_component("right", 0, |_| WAVE_NUMBER.sin() * (frequency() * time).sin())?;
        Ok(constraints)
    };
    let earlier: Vec<_> =
        (1..scheme.states()).map(|k| exact(&space, -(k as f64) * size)).collect::<Result<_, _>>()?;
    let mut motion =
        TimeLoop::new(form, scheme, exact(&space, 0.0)?).with_earlier(earlier).constrained_at(constraints);
    let mut reaction = 0.0;
    for _ in 0..steps {
        let taken = motion.take(size)?;
        assert!(taken.history.is_empty(), "the form is affine");
        reaction = taken.reaction("left")?[0] / 0.1;
    }
    let off = motion.state().value.minus(&exact(&space, 0.5)?.value)?;
    let largest = off.values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let pull = YOUNGS_MODULUS * WAVE_NUMBER * (0.5 * frequency()).sin();
    Ok([largest, (reaction + pull).abs() / pull.abs()])
}

#[test]
fn a_wave_runs_beside_a_moving_support() -> Outcome {
    let order = |coarse: [f64; 2], fine: [f64; 2]| (coarse[0] / fine[0]).log2();
    let implicit = GeneralisedAlpha::trapezoidal();
    let [coarse, fine] = [follow(implicit, 40)?, follow(implicit, 80)?];
    assert!((order(coarse, fine) - 2.0).abs() < 0.15 && fine[0] < 2e-3, "{coarse:?} {fine:?}");
    // Reactions of the trapezoidal rule carry what the support's jerk excites, of first order at most.
    assert!(fine[1] < 0.05, "{fine:?}");
    let damped = GeneralisedAlpha::with_spectral_radius(0.5)?;
    let [coarse, fine] = [follow(damped, 40)?, follow(damped, 80)?];
    assert!((order(coarse, fine) - 2.0).abs() < 0.3, "{coarse:?} {fine:?}");
    let backward = BackwardDifferences::new(2)?;
    let [coarse, fine] = [follow(backward, 80)?, follow(backward, 160)?];
    assert!((order(coarse, fine) - 2.0).abs() < 0.3 && fine[1] < 0.02, "{coarse:?} {fine:?}");
    Ok(())
}

#[test]
fn energy_stays_what_it_was() -> Outcome {
    let space = space()?;
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2])?;
    let start = || exact(&space, 0.3);
    let (assembler, plain) = (Assembler::new(space.mesh()), model(Default::default()));
    let energy = |state: &State<2>| assembler.functional(&plain.energy(&state.value, &state.rate));
    for scheme in [GeneralisedAlpha::trapezoidal(), GeneralisedAlpha::mid_point()] {
        let mut motion = TimeLoop::new(form, scheme, start()?).constrained(&held).constant_coefficients();
        let first = energy(motion.state())?;
        for _ in 0..200 {
            motion.take(0.02)?;
        }
        let drift = energy(motion.state())? / first - 1.0;
        assert!(drift.abs() < 1e-12, "{scheme:?} {drift:e}");
    }
    // Explicit steps below the stability limit keep it up to a bounded oscillation, and above it explode.
    let explicit = |size: f64, steps: usize| -> Outcome<f64> {
        let mut motion = TimeLoop::new(form, CentralDifferences, start()?).constrained(&held);
        let first = energy(motion.state())?;
        for _ in 0..steps {
            motion.take(size)?;
        }
        Ok(energy(motion.state())? / first)
    };
    let (stable, unstable) = (explicit(5e-4, 2000)?, explicit(2e-2, 50)?);
    assert!((stable - 1.0).abs() < 0.01 && unstable > 1e6, "{stable} {unstable:e}");
    Ok(())
}

#[test]
fn a_film_has_a_file_per_step() -> Outcome {
    let (space, directory) = (space()?, tempfile::tempdir()?);
    let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), exact(&space, 0.0)?);
    let mut film = VtuSeries::new(directory.path().join("wave.pvd"))?;
    for _ in 0..3 {
        motion.take(0.25)?;
        let State { time, value, rate, .. } = motion.state();
        let file = VtuFile::new(space.mesh()).point_data("displacement", value)?;
        film.write(*time, &file.point_data("velocity", rate)?)?;
    }
    let listed = std::fs::read_to_string(directory.path().join("wave.pvd"))?;
    assert!(listed.contains("timestep=\"0.75\" file=\"wave_0002.vtu\""), "{listed}");
    assert!(directory.path().join("wave_0002.vtu").exists());
    Ok(())
}
