//! Figure 6 of the paper with cut elements: the holes of a pressed wheel, by descent on a level set function with the pattern of 24 sectors,
//! once with the adjoint (21) and once with (22). README.md has the problem and its results.
//!
//! `cargo run --release --bin level_set_wheel -- [--cells N] [--steps N] [--last-steps N] [--out DIRECTORY] [--anew]`

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use forms_contact::Adjoint;
use forms_examples::command_line::program_with_options;
use forms_examples::level_set::check_gradient;
use forms_examples::level_set::wheel::{
    Descended, HOLE_RADIUS, HOLES, Pressed, Wheel, WheelDescent, least_wall, round_holes, sector_wave,
};
use forms_fem::cut::Cut;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, VtuFile};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use forms_fem::shape_optimisation::level_set::{LevelSetProblem, LevelSetRow};
use serde_json::json;

/// J of the fitted optimum with the price of its perimeter, and J alone (results.md, cells of half the size).
const FITTED: [f64; 2] = [2127.3467, 1152.689];

/// The holes of a pressed wheel, cut from a ring of triangles
#[derive(Parser)]
#[command(version, name = "level_set_wheel")]
struct Options {
    /// Pairs of triangles in the width of a sector
    #[arg(long, value_name = "N", default_value_t = 32)]
    cells: usize,
    /// Steps with the smooth perimeter, at most
    #[arg(long, value_name = "N", default_value_t = 70)]
    steps: usize,
    /// Steps with the length of Γ after them, at most
    #[arg(long, value_name = "N", default_value_t = 45)]
    last_steps: usize,
    /// Waves of φ, and of holes, that are shorter than this move less (cm)
    #[arg(long, value_name = "L", default_value_t = 2.0)]
    smoothing: f64,
    /// Begins again where a run was stopped, or had ended
    #[arg(long)]
    anew: bool,
    /// Directory of all results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/level_set_wheel")]
    out: PathBuf,
}

fn main() -> ExitCode {
    program_with_options(run)
}

/// A finished descent.
struct Run {
    number: &'static str,
    wheel: Wheel,
    /// Both descents, and the last step of the first.
    course: Vec<LevelSetRow>,
    at_switch: usize,
    /// The body without a band, and its state.
    body: Arc<Cut<2>>,
    last: Pressed,
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Failure> {
    let mut runs = vec![];
    let mut rows = vec![];
    for (number, directory, adjoint) in
        [("(21)", "adjoint_21", Adjoint::Discrete), ("(22)", "adjoint_22", Adjoint::Consistent)]
    {
        let wheel = Wheel::new(options.cells, adjoint)?;
        let initial = Field::interpolate(&wheel.scalars, round_holes)?;
        out.line(format!("with the adjoint {number}, on {} unknowns:", wheel.unknowns()));
        let with_length = Wheel::new(options.cells, adjoint)?.with_length();
        let round = Field::interpolate(&with_length.scalars, round_holes)?;
        check_gradient(&with_length, &round, &sector_wave, out)?;
        let descent = WheelDescent {
            initial: &initial,
            steps: [options.steps, options.last_steps],
            smoothing: options.smoothing,
            settings: json!({ "cells": options.cells, "adjoint": directory }),
            anew: options.anew,
            directory: &options.out.join(directory),
        };
        let Descended { wheel, phi, course, at_switch } = descent.run(wheel, out)?;
        let (start, body) = (wheel.solve(&Cut::by(&initial)?)?.state, Cut::by(&phi)?);
        let fine = wheel.refined()?;
        let halved = fine.solve(&Cut::by(&phi.onto(&fine.scalars).interpolated()?)?)?;
        let last = wheel.solve(&body)?;
        let off = last.constraint.unwrap_or(0.0);
        out.line(format!(
            "{number}: J = {:.4} at first; volume off by {off:.1e}, wall {:.3}, pattern off by {:.0e}, {} steps",
            start.unpriced,
            least_wall(&body),
            wheel.pattern_error(&phi)?,
            course.len() - 2
        ));
        for (name, state) in [("at last", &last.state), ("at last, halved cells", &halved.state)] {
            let (work, priced) = (state.unpriced, wheel.priced(state));
            let [off_work, off_priced] =
                [work / FITTED[1], priced / FITTED[0]].map(|ratio| 100.0 * (ratio - 1.0));
            rows.push(format!(
                "| {number} {name} | {work:.4} | {off_work:+.3} % | {priced:.4} | {off_priced:+.3} % |"
            ));
        }
        runs.push(Run { number, wheel, course, at_switch, body, last: last.state });
    }
    out.line("| adjoint | J | from fitted | J with the price | from fitted |");
    out.line("| --- | --: | --: | --: | --: |");
    rows.iter().for_each(|row| out.line(row));
    for run in &runs {
        let body = run.body.body()?;
        let u = body.field(&run.last.positions[0].u)?;
        let name = format!("wheel_{}.vtu", &run.number[1..3]);
        VtuFile::new(body.mesh()).point_data("displacement", &u)?.write(options.out.join(name))?;
    }
    picture(&runs)?.write_png(options.out.join("level_set_wheel.png"))?;
    out.line(format!("histories, last shapes and picture: {}", options.out.display()));
    Ok(())
}

/// The lower part of the first wheel over von Mises' stress with the holes of all, and J over the steps.
fn picture(runs: &[Run]) -> Result<impl Picture, Failure> {
    let Some(first) = runs.first() else { return Err("no run".into()) };
    let pieces = first.body.body()?;
    let stress = first.wheel.mises(&first.last, &first.last.positions[0])?;
    let shown = pieces.field(&stress)?;
    let mut map = FieldMap::of(&shown, Shown::Component(0), "stress [MPa]")
        .range(0.0, 20.0)
        .without_lines()
        .levels(8)
        .window([-12.2, 12.2], [-30.4, -18.8])
        .size(200.0, 97.0)
        .length_unit("cm");
    let mut plot = LinePlot::new()
        .x_axis("step", Scale::Linear)
        .y_axis("J + price", Scale::Linear)
        .size(150.0, 170.0)
        .grid()
        .horizontal_line(FITTED[0], "fitted");
    let colour = Colour::of_series(0);
    for hole in 0..HOLES {
        let name = if hole == 0 { "initial" } else { "" };
        map = map.line(&circle(hole), name, colour);
    }
    for (place, run) in runs.iter().enumerate() {
        for hole in 0..HOLES {
            let name = if hole == 0 { format!("optimal with {}", run.number) } else { String::new() };
            map = map.line(&outline(&run.body, hole), &name, Colour::of_series(place + 1));
        }
        // The row at the switch is there twice, with either perimeter.
        let at = |row: usize| if row > run.at_switch { row - 1 } else { row } as f64;
        let (steps, values): (Vec<f64>, Vec<f64>) =
            run.course.iter().enumerate().map(|(row, values)| (at(row), values.criterion)).unzip();
        plot = plot.curve(Curve::new(run.number, &steps, &values).without_markers());
    }
    Ok(Panel::new(2).picture(&map)?.picture(&plot)?.draw()?)
}

/// The round hole of a sector.
fn circle(hole: usize) -> Vec<[f64; 2]> {
    let (sine, cosine) = (TAU * (hole as f64 + 0.5) / HOLES as f64).sin_cos();
    let around = (0..=48).map(|part| TAU * f64::from(part) / 48.0);
    around
        .map(|angle| [25.0 * cosine + HOLE_RADIUS * angle.cos(), 25.0 * sine + HOLE_RADIUS * angle.sin()])
        .collect()
}

/// Γ in a sector as a closed curve: its points by the angle about their middle.
fn outline(body: &Cut<2>, hole: usize) -> Vec<[f64; 2]> {
    let sector = |x: &[f64; 2]| (x[1].atan2(x[0]).rem_euclid(TAU) / TAU * HOLES as f64) as usize;
    let mut points: Vec<[f64; 2]> =
        body.interface().into_iter().flatten().filter(|x| sector(x) == hole).collect();
    let count = points.len().max(1) as f64;
    let middle: [f64; 2] = std::array::from_fn(|k| points.iter().map(|x| x[k]).sum::<f64>() / count);
    let angle = |x: &[f64; 2]| (x[1] - middle[1]).atan2(x[0] - middle[0]);
    points.sort_by(|x, y| angle(x).total_cmp(&angle(y)));
    points.extend(points.first().copied());
    points
}
