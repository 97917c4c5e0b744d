//! Large-displacement impact with friction: a ring of rubber falls on a flat, touches, and is spun by friction. Contact by
//! Nitsche's method in mid-point schemes that know the energy ([`forms_contact::finite_impact`]).
//!
//! Checks; each ends the program if it fails: energy and work of friction stay together what they were (`conserving`) or never grow
//! (`hybrid`), and momentum changes by the impulses of weight and flat. The program also prints the closed form of a rigid ring: friction on the
//! flat has no moment about it, so that from the speed v it comes to roll with v/(1 + (a² + b²)/2b²), radii a and b.
//!
//! Run it with `cargo run --release --bin rolling_ring -- [CELLS AROUND] [STEPS PER UNIT OF TIME] [UNITS OF TIME] [hybrid] [whole]`; with
//! `whole` Newton's steps are not shortened: it tells the iterates of each step in time that fails so, and takes shorter ones. It writes
//! `out/rolling_ring.csv`, frames for ParaView in `out/rolling_ring.pvd`, and pictures.

mod account;
mod ring;

use std::error::Error;
use std::process::ExitCode;

use forms_fem::output::{StandardOutput, VtuFile, VtuSeries, program, tell};
use forms_fem::prelude::*;
use forms_fem::time::{AdaptiveSteps, GeneralisedAlpha, State, Step, StepError, StepFailure, TimeLoop};

use account::{draw, draw_frames, series, table};
use ring::{GRAVITY, Pressure, Record, SPEED, Thrown, model};

/// Pictures per unit of time.
const FRAMES: f64 = 4.0;

/// Steps of a run, the frames' states among them.
fn follow(
    thrown: &Thrown,
    (pressure, line_search): (Pressure, LineSearch),
    size: f64,
    end: f64,
    mut frame: impl FnMut(&State<2>) -> Result<(), Box<dyn Error>>,
) -> Result<Vec<Record>, Box<dyn Error>> {
    let start = thrown.start()?;
    let mut records = vec![thrown.measured(None, &start)?];
    let mid_point = GeneralisedAlpha::mid_point();
    let base = |step: &Step<2>| model(Some(step), [0.0; 2], [0.0; 2]);
    let conserving = move |step: &Step<2>| base(step).conserving(&step.before.value);
    let hybrid = move |step: &Step<2>| base(step).hybrid(&step.before.value);
    let options = NewtonOptions { absolute_tolerance: 1e-13, line_search, ..NewtonOptions::default() };
    let motion = match pressure {
        Pressure::Conserving => TimeLoop::new(conserving, mid_point, start),
        Pressure::Hybrid => TimeLoop::new(hybrid, mid_point, start),
    };
    let mut motion = motion.assembler(&thrown.assembler).options(options);
    frame(motion.state())?;
    // The mid-point rule estimates no error: steps are halved where Newton's method fails.
    let mut steps = AdaptiveSteps::new(size, f64::MAX)?;
    // What is left by rounding is no step.
    while motion.state().time < end - 1e-6 * size {
        let before = motion.state().clone();
        let taken = match line_search {
            LineSearch::Off => match motion.take(size.min(end - before.time)) {
                Ok(taken) => taken,
                Err(failed) => {
                    tell_iterates(&failed);
                    steps.take(&mut motion, end)?
                }
            },
            _ => steps.take(&mut motion, end)?,
        };
        let (after, earlier) = (motion.state(), records[records.len() - 1]);
        let mut record = thrown.measured(Some((&before, &earlier, pressure)), after)?;
        record.iterations = taken.history.len() - 1;
        record.shortened =
            taken.history.iter().filter(|step| step.damping.is_some_and(|part| part < 1.0)).count();
        check(&earlier, &record, pressure, thrown.mass)?;
        records.push(record);
        if (after.time * FRAMES + 1e-9).floor() > (before.time * FRAMES + 1e-9).floor() {
            frame(after)?;
        }
    }
    Ok(records)
}

/// The iterates of a step that failed.
fn tell_iterates(error: &StepError) {
    tell(error);
    if let StepFailure::Solve(why) = &error.why {
        for step in &why.history {
            let active = step.active_points.unwrap_or(0);
            tell(format!("{:3} |R| = {:.3e}, {active} active points", step.iteration, step.residual));
        }
    }
}

/// Balances of a step: energy relative to the kinetic energy of the throw, momentum relative to its own.
fn check(before: &Record, after: &Record, pressure: Pressure, mass: f64) -> Result<(), Box<dyn Error>> {
    let scale = mass * SPEED * SPEED / 2.0;
    let gain = (after.energy + after.lost - before.energy - before.lost) / scale;
    let wrong = match pressure {
        Pressure::Conserving => gain.abs() > 1e-9,
        Pressure::Hybrid => gain > 1e-9,
    };
    if wrong || after.lost < before.lost {
        return Err(format!("at {} the energy has changed by {gain:.1e}", after.time).into());
    }
    let size = after.time - before.time;
    for (axis, weight) in [0.0, -mass * GRAVITY].into_iter().enumerate() {
        let impulse = size * (after.force[axis] + weight);
        let off = (after.momentum[axis] - before.momentum[axis] - impulse) / (mass * SPEED);
        if off.abs() > 1e-9 {
            return Err(format!("at {} the momentum is off by {off:.1e}", after.time).into());
        }
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let (words, numbers): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument.starts_with(char::is_alphabetic));
    let given =
        |place: usize, otherwise: usize| numbers.get(place).map_or(Ok(otherwise), |text| text.parse());
    let (around, per_unit, end) = (given(0, 24)?, given(1, 40)?, given(2, 40)?);
    let (mut pressure, mut line_search) = (Pressure::Conserving, LineSearch::OnResidual);
    for word in &words {
        match word.as_str() {
            "hybrid" => pressure = Pressure::Hybrid,
            "whole" => line_search = LineSearch::Off,
            other => return Err(format!("`{other}` is no choice: it takes `hybrid`, `whole`").into()),
        }
    }
    let thrown = Thrown::new(around.max(3))?;
    out.line(format!("{} unknowns", thrown.space.unknowns()));
    let mut film = VtuSeries::new("out/rolling_ring.pvd")?;
    let mut shown: Vec<State<2>> = vec![];
    let frame = |state: &State<2>| -> Result<(), Box<dyn Error>> {
        let file = VtuFile::new(thrown.space.mesh()).point_data("displacement", &state.value)?;
        film.write(state.time, &file.point_data("velocity", &state.rate)?)?;
        shown.push(state.clone());
        Ok(())
    };
    let size = 1.0 / per_unit.max(1) as f64;
    let records = follow(&thrown, (pressure, line_search), size, end as f64, frame)?;
    let series = series(&records)?;
    table(&thrown, &records, &series, out)?;
    series.write("out/rolling_ring.csv")?;
    draw(&records)?;
    draw_frames(&thrown, &shown)
}

fn main() -> ExitCode {
    program(run)
}
