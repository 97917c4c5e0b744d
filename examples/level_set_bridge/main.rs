//! The topology of a bridge over a ditch, by descent on a level set function: holes merge and vanish while the bridge rests on rigid ground.
//! README.md has the problem and its results.
//!
//! `cargo run --release --bin level_set_bridge -- [--cells N] [--steps N] [--out DIRECTORY] [--anew]`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use forms_examples::command_line::program_with_options;
use forms_examples::level_set::problem::{LoadedBody, SIZE, Solved, support};
use forms_examples::level_set::{check_gradient, descend, eighteen_holes, voids, wave};
use forms_fem::cut::Cut;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, VtuFile};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use forms_fem::shape_optimisation::level_set::{
    LevelSetDescent, LevelSetOptions, LevelSetProblem, LevelSetState,
};
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
    let bridge = LoadedBody::bridge(options.cells)?;
    let initial = Field::interpolate(&bridge.scalars, eighteen_holes)?;
    check_gradient(&bridge, &initial, &wave, out)?;

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
    let settings = json!({ "cells": options.cells });
    let best = descend(&descent, &settings, options.anew, &options.out, out)?;
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

/// The first and the last bridge, deformed, over von Mises' stress, and J over the steps.
fn picture(
    bridge: &LoadedBody,
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
