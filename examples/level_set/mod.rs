//! The frame of programs that optimise a level set function: a descent with its checkpoint, its history as a table, gradients checked by
//! differences; and their problems.

pub mod problem;
pub mod wheel;

use std::path::Path;

use forms_fem::cut::Cut;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::output::{StandardOutput, tell, write_whole};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{
    LevelSetControls, LevelSetDescent, LevelSetOptimised, LevelSetProblem, LevelSetState,
};
use forms_fem::shape_optimisation::{Checkpoint, Failure, StopReason};
use serde_json::{Value, json};

/// A descent whose checkpoint is in a directory, from there on if there is one; its history is a table and `history.csv`.
///
/// # Errors
/// Those of the descent, a checkpoint of other settings, and files that cannot be written.
pub fn descend<P: LevelSetProblem<2>>(
    descent: &LevelSetDescent<P, 2>,
    settings: &Value,
    anew: bool,
    directory: &Path,
    out: &mut StandardOutput,
) -> Result<LevelSetOptimised<P::State, 2>, Failure> {
    std::fs::create_dir_all(directory)?;
    let path = directory.join("checkpoint.json");
    let from = match Checkpoint::<LevelSetState>::read(&path)? {
        Some(read) if !anew => Some(read.state_for(settings)?),
        _ => None,
    };
    if let Some(from) = &from {
        tell(format!("goes on from step {}", from.iterations()));
    }
    let best = descent.run(from, &mut |report| {
        let changeable = json!({ "steps": descent.options.iterations });
        let state = report.state.clone();
        Checkpoint::new(settings.clone(), changeable, vec![], state).write(&path)?;
        let (step, voids) = (report.state.iterations(), voids(report.phi)?);
        let row = report.state.history.last().ok_or("no history")?;
        let new = row.holes.as_ref().map_or_else(String::new, |holes| format!(", {} new holes", holes.count));
        tell(format!("step {step}: J = {:.6}, {voids} voids, {} parts{new}", row.criterion, row.parts));
        Ok(())
    })?;
    out.line("| step | J | parts of the body |\n| --: | --: | --: |");
    let rows = &best.state.history;
    for (step, row) in rows.iter().enumerate().filter(|(step, _)| step % 25 == 0 || step + 1 == rows.len()) {
        out.line(format!("| {step} | {:.6} | {} |", row.criterion, row.parts));
    }
    match &best.state.finish {
        Some(StopReason::NoStep(why)) => out.line(format!("stopped, as no step brings less: {why}")),
        Some(StopReason::Converged) => out.line("converged"),
        _ => out.line("stopped after the number of steps"),
    }
    write_whole(directory.join("history.csv"), |file| {
        std::io::Write::write_all(file, best.state.csv().as_bytes())
    })?;
    Ok(best)
}

/// A wave along which gradients are checked.
pub fn wave(x: &[f64; 2]) -> f64 {
    1.0 + (5.0 * x[0]).sin() * (7.0 * x[1]).cos()
}

/// The slope along a wave by the derivative, and by differences.
///
/// # Errors
/// A body without a solution.
pub fn check_gradient<P: LevelSetProblem<2>>(
    problem: &P,
    phi: &Field<2>,
    wave: &dyn Fn(&[f64; 2]) -> f64,
    out: &mut StandardOutput,
) -> Result<(), Failure> {
    let direction: Vec<f64> = phi.space().positions().iter().map(wave).collect();
    let moved = |step: f64| -> Result<(f64, Vec<u32>), Failure> {
        let values = phi.values().iter().zip(&direction).map(|(phi, along)| phi + step * along).collect();
        let body = Cut::by(&Field::from_values(phi.space(), values)?)?;
        Ok((problem.solve(&body)?.criterion, body.sides().collect()))
    };
    let body = Cut::by(phi)?;
    let mut values = problem.solve(&body)?;
    let gradient = problem.derivatives(&body, &mut values.state)?.criterion;
    let slope: f64 = gradient.iter().zip(&direction).map(|(gradient, along)| gradient * along).sum();
    let step = 1e-6;
    let [(after, sides), (before, other_sides)] = [moved(step)?, moved(-step)?];
    let difference = (after - before) / (2.0 * step);
    let kept = if sides == other_sides { "no node changes sides" } else { "a node changes sides" };
    out.line(format!("dJ along a wave {slope:.9}, by differences {difference:.9}, {kept}"));
    let mut controls = LevelSetControls { problem, start: phi.clone() };
    let report = taylor_test(&mut controls, phi.values(), &direction, 1e-4)?;
    match report.second_order() {
        Ok(order) => out.line(format!("order of the Taylor test {order:.3}")),
        Err(why) => out.line(format!("no Taylor test: {why}")),
    }
    Ok(())
}

/// The number of holes and notches: connected parts of {φ > 0}.
///
/// # Errors
/// A φ that no body has.
pub fn voids(phi: &Field<2>) -> Result<usize, Failure> {
    let negated = phi.values().iter().map(|value| -value).collect();
    Ok(Cut::by(&Field::from_values(phi.space(), negated)?).map_or(0, |cut| cut.parts().len()))
}

/// A rectangle of length 2 and height 1 with 18 round holes.
pub fn eighteen_holes(x: &[f64; 2]) -> f64 {
    let holes =
        (0..18).map(|hole| [1.0 / 6.0 + f64::from(hole % 6) / 3.0 + 0.003, 0.19 + f64::from(hole / 6) * 0.3]);
    holes.map(|hole| 0.09 - (x[0] - hole[0]).hypot(x[1] - hole[1])).fold(f64::MIN, f64::max)
}
