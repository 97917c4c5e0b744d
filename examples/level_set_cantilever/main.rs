//! A cantilever from a full plate: holes that the topological derivative makes, compared with a start that has holes.
//! README.md has the problem and its results.
//!
//! `cargo run --release --bin level_set_cantilever -- [--cells N] [--steps N] [--out DIRECTORY] [--anew]`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use forms_examples::command_line::program_with_options;
use forms_examples::level_set::problem::{LoadedBody, SIZE, Solved};
use forms_examples::level_set::{descend, eighteen_holes, voids};
use forms_fem::cut::Cut;
use forms_fem::output::StandardOutput;
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use forms_fem::shape_optimisation::level_set::{
    HoleOptions, LevelSetDescent, LevelSetOptimised, LevelSetOptions, LevelSetProblem,
};
use serde_json::json;

/// A cantilever of least work of its load, with a price of its area
#[derive(Parser)]
#[command(version, name = "level_set_cantilever")]
struct Options {
    /// Cells along the plate, a multiple of sixteen
    #[arg(long, value_name = "N", default_value_t = 64)]
    cells: usize,
    /// Steps, at most
    #[arg(long, value_name = "N", default_value_t = 80)]
    steps: usize,
    /// Begins again where a run was stopped, or had ended
    #[arg(long)]
    anew: bool,
    /// Directory of all results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/level_set_cantilever")]
    out: PathBuf,
}

fn main() -> ExitCode {
    program_with_options(run)
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Failure> {
    if options.cells == 0 || !options.cells.is_multiple_of(16) {
        return Err(format!("--cells {}: it must be a multiple of sixteen", options.cells).into());
    }
    let cantilever = LoadedBody::cantilever(options.cells)?;
    let size = SIZE[0] / options.cells as f64;
    let settings = json!({ "cells": options.cells });
    let own = LevelSetOptions {
        iterations: options.steps,
        smoothing: 3.0 * size,
        // A narrow band.
        largest_change: 0.25 * size,
        ..LevelSetOptions::new(size)
    };
    let full = LevelSetDescent {
        problem: &cantilever,
        // Anywhere inside is deep enough for a hole.
        initial: Field::interpolate(&cantilever.scalars, |_| -1.0)?,
        options: LevelSetOptions {
            holes: Some(HoleOptions { distance: 4.0 * size, ..HoleOptions::new(size) }),
            ..own.clone()
        },
    };
    let given = LevelSetDescent {
        problem: &cantilever,
        initial: Field::interpolate(&cantilever.scalars, eighteen_holes)?,
        options: own,
    };
    let mut rows = vec![];
    let [full, given] = [("full plate", "full", &full), ("given holes", "given", &given)].map(
        |(title, directory, descent)| -> Result<_, Failure> {
            out.line(format!("{title}:"));
            let directory = options.out.join(directory);
            let best = descend(descent, &settings, options.anew, &directory, out)?;
            let made: usize =
                best.state.history.iter().filter_map(|row| row.holes.as_ref()).map(|row| row.count).sum();
            let [first, last] = [&descent.initial, &best.phi].map(|phi| -> Result<(f64, usize), Failure> {
                Ok((cantilever.solve(&Cut::by(phi)?)?.criterion, voids(phi)?))
            });
            let ((first, given), (last, voids)) = (first?, last?);
            rows.push(format!("| {title} | {given} | {made} | {first:.5} | {last:.5} | {voids} |"));
            Ok(best)
        },
    );
    let (full, given) = (full?, given?);
    out.line("| start | given holes | new holes | J at first | J at last | voids at last |\n| --- | --: | --: | --: | --: | --: |");
    rows.iter().for_each(|row| out.line(row));
    picture(&cantilever, [("full plate, at last", &full), ("given holes, at last", &given)])?
        .write_png(options.out.join("level_set_cantilever.png"))?;
    out.line(format!("histories and picture: {}", options.out.display()));
    Ok(())
}

/// The last shapes over von Mises' stress, and J over the steps with the steps that made holes.
fn picture(
    cantilever: &LoadedBody,
    runs: [(&str, &LevelSetOptimised<Solved, 2>); 2],
) -> Result<impl Picture, Failure> {
    let mut panel = Panel::new(3);
    let mut plot =
        LinePlot::new().x_axis("step", Scale::Linear).y_axis("J", Scale::Linear).size(150.0, 150.0).grid();
    let mut most = 0.0_f64;
    for (title, run) in runs {
        let stress = cantilever.mises(&run.values.state)?;
        if most == 0.0 {
            most = stress.values().iter().copied().fold(0.0, f64::max);
        }
        let pieces = Cut::by(&run.phi)?.body()?;
        let shown = pieces.field(&stress)?;
        let map = FieldMap::of(&shown, Shown::Component(0), "von Mises stress")
            .range(0.0, most)
            .without_lines()
            .levels(5)
            .window([0.0, SIZE[0]], [0.0, SIZE[1]])
            .size(140.0, 77.0)
            .title(title);
        panel = panel.picture(&map)?;
        let (steps, values): (Vec<f64>, Vec<f64>) =
            run.state.history.iter().enumerate().map(|(step, row)| (step as f64, row.criterion)).unzip();
        let name = title.split(',').next().unwrap_or_default();
        plot = plot.curve(Curve::new(name, &steps, &values).without_markers());
    }
    Ok(panel.picture(&plot)?.draw()?)
}
