//! The topology of a bridge over a ditch, by descent on a level set function: holes merge and vanish while the bridge rests on rigid ground.
//! README.md has the problem and its results.
//!
//! `cargo run --release --bin level_set_bridge -- [--cells N] [--steps N] [--out DIRECTORY] [--anew]`

mod problem;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use forms_examples::command_line::program_with_options;
use forms_fem::cut::Cut;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, VtuFile, tell, write_whole};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{
    LevelSetControls, LevelSetDescent, LevelSetOptions, LevelSetProblem, LevelSetState,
};
use forms_fem::shape_optimisation::{Checkpoint, Failure, StopReason};
use problem::{Bridge, SIZE, Solved, support};
use serde_json::json;

/// A bridge of least work of its load, with a price of its area
#[derive(Parser)]
#[command(version, name = "level_set_bridge")]
struct Options {
    /// Cells along half of the bridge, a multiple of eight
    #[arg(long, value_name = "N", default_value_t = 48)]
    cells: usize,
    /// Steps, at most
    #[arg(long, value_name = "N", default_value_t = 60)]
    steps: usize,
    /// Begins again where a run was stopped, or had ended
    #[arg(long)]
    anew: bool,
    /// Directory of all results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/level_set_bridge")]
    out: PathBuf,
}

fn main() -> ExitCode {
    program_with_options(run)
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Failure> {
    if options.cells == 0 || !options.cells.is_multiple_of(8) {
        return Err(format!("--cells {}: it must be a multiple of eight", options.cells).into());
    }
    let bridge = Bridge::new(options.cells)?;
    let initial = bridge.start()?;
    check_gradient(&bridge, &initial, out)?;

    let size = SIZE[0] / options.cells as f64;
    let descent = LevelSetDescent {
        problem: &bridge,
        initial: initial.clone(),
        // Smoother changes than usual keep the boundary even.
        options: LevelSetOptions {
            iterations: options.steps,
            smoothing: 4.0 * size,
            ..LevelSetOptions::new(size)
        },
    };
    std::fs::create_dir_all(&options.out)?;
    let path = options.out.join("checkpoint.json");
    let settings = json!({ "cells": options.cells });
    let from = match Checkpoint::<LevelSetState>::read(&path)? {
        Some(read) if !options.anew => Some(read.state_for(&settings)?),
        _ => None,
    };
    if let Some(from) = &from {
        tell(format!("goes on from step {}", from.iterations()));
    }
    let best = descent.run(from, &mut |report| {
        let changeable = json!({ "steps": options.steps });
        let state = report.state.clone();
        Checkpoint::new(settings.clone(), changeable, vec![], state).write(&path)?;
        let (step, voids) = (report.state.iterations(), voids(report.phi)?);
        let row = report.state.history.last().ok_or("no history")?;
        tell(format!("step {step}: J = {:.6}, {voids} voids, {} parts", row.criterion, row.parts));
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
    write_whole(options.out.join("history.csv"), |file| {
        std::io::Write::write_all(file, best.state.csv().as_bytes())
    })?;
    let first_body = Cut::by(&initial)?;
    let first = bridge.solve(&first_body)?;
    let last_body = Cut::by(&best.phi)?;
    let last = bridge.solve(&last_body)?;
    for (name, phi, values) in [("at first", &initial, &first), ("at last", &best.phi, &last)] {
        let [force, length] = bridge.contact(&values.state)?;
        out.line(format!(
            "{name}: J = {:.6}, {} voids, contact force {force:.6} of {}, contact length {length:.4}",
            values.criterion,
            voids(phi)?,
            bridge.load()
        ));
    }
    let body = last_body.body()?;
    let u = body.field(&last.state.u)?;
    VtuFile::new(body.mesh()).point_data("displacement", &u)?.write(options.out.join("bridge.vtu"))?;
    let picture = picture(&bridge, [(&first_body, &first.state), (&last_body, &last.state)], &best.state)?;
    picture.write_png(options.out.join("level_set_bridge.png"))?;
    out.line(format!("history, last shape and picture: {}", options.out.display()));
    Ok(())
}

/// The slope along a wave by the adjoint state, and by differences.
fn check_gradient(bridge: &Bridge, phi: &Field<2>, out: &mut StandardOutput) -> Result<(), Failure> {
    let wave = |x: &[f64; 2]| 1.0 + (5.0 * x[0]).sin() * (7.0 * x[1]).cos();
    let direction: Vec<f64> = phi.space().positions().iter().map(wave).collect();
    let moved = |step: f64| -> Result<(f64, Vec<u32>), Failure> {
        let values = phi.values().iter().zip(&direction).map(|(phi, along)| phi + step * along).collect();
        let body = Cut::by(&Field::from_values(phi.space(), values)?)?;
        Ok((bridge.solve(&body)?.criterion, body.sides().collect()))
    };
    let body = Cut::by(phi)?;
    let mut values = bridge.solve(&body)?;
    let gradient = bridge.derivatives(&body, &mut values.state)?.criterion;
    let slope: f64 = gradient.iter().zip(&direction).map(|(gradient, along)| gradient * along).sum();
    let step = 1e-6;
    let [(after, sides), (before, other_sides)] = [moved(step)?, moved(-step)?];
    let difference = (after - before) / (2.0 * step);
    let kept = if sides == other_sides { "no node changes sides" } else { "a node changes sides" };
    out.line(format!("dJ along a wave {slope:.9}, by differences {difference:.9}, {kept}"));
    let mut controls = LevelSetControls { problem: bridge, start: phi.clone() };
    let report = taylor_test(&mut controls, phi.values(), &direction, 1e-4)?;
    match report.second_order() {
        Ok(order) => out.line(format!("order of the Taylor test {order:.3}")),
        Err(why) => out.line(format!("no Taylor test: {why}")),
    }
    Ok(())
}

/// The number of holes and notches: connected parts of {φ > 0}.
fn voids(phi: &Field<2>) -> Result<usize, Failure> {
    let negated = phi.values().iter().map(|value| -value).collect();
    Ok(Cut::by(&Field::from_values(phi.space(), negated)?).map_or(0, |cut| cut.parts().len()))
}

/// The first and the last bridge, deformed, over von Mises' stress, and J over the steps.
fn picture(
    bridge: &Bridge,
    shapes: [(&Arc<Cut<2>>, &Solved); 2],
    state: &LevelSetState,
) -> Result<impl Picture, Failure> {
    let profile: Vec<[f64; 2]> = (0..=100)
        .map(|k| SIZE[0] * f64::from(k) / 100.0)
        .map(|x| [x, support(x)])
        .filter(|x| x[1] > -0.3)
        .collect();
    let mut panel = Panel::new(3);
    let stresses = [bridge.mises(shapes[0].1)?, bridge.mises(shapes[1].1)?];
    let most = stresses[0].values().iter().copied().fold(0.0, f64::max);
    for (((body, solved), stress), title) in shapes.into_iter().zip(&stresses).zip(["at first", "at last"]) {
        let pieces = body.body()?;
        let (u, shown) = (pieces.field(&solved.u)?, pieces.field(stress)?);
        let map = FieldMap::of(&shown, Shown::Component(0), "von Mises stress")
            .range(0.0, most)
            .deformed(&u, 1.0)
            .without_lines()
            .levels(5)
            .window([0.0, SIZE[0]], [-0.3, SIZE[1] + 0.02])
            .size(160.0, 100.0)
            .line(&profile, "", Colour::of_series(1))
            .title(title);
        panel = panel.picture(&map)?;
    }
    let (steps, values): (Vec<f64>, Vec<f64>) =
        state.history.iter().enumerate().map(|(step, row)| (step as f64, row.criterion)).unzip();
    let plot = LinePlot::new()
        .x_axis("step", Scale::Linear)
        .y_axis("J", Scale::Linear)
        .size(180.0, 130.0)
        .grid()
        .curve(Curve::new("", &steps, &values).without_markers());
    Ok(panel.picture(&plot)?.draw()?)
}
