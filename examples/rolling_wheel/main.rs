//! The holes of a wheel that rolls: a criterion over several positions of the ground, with one factor for all of them, and a descent on φ.
//! README.md has the problem and its results.
//!
//! `cargo run --release --bin rolling_wheel -- [--cells N] [--positions M] [--unevenness A] [--variance B] [--out DIRECTORY] [--anew]`

mod account;
mod pictures;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use forms_contact::hollow_cylinder::OUTER_RADIUS;
use forms_contact::rolling::RollingCriterion;
use forms_examples::command_line::program_with_options;
use forms_examples::level_set::check_gradient;
use forms_examples::level_set::wheel::{
    Descended, HOLES, Rolling, Wheel, WheelDescent, least_wall, round_holes, sector_wave,
};
use forms_fem::cut::Cut;
use forms_fem::output::StandardOutput;
use forms_fem::output::picture::Picture;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use serde_json::json;

use account::{Rolled, cost, table, turned_by_a_sector, write_csv};
use pictures::{picture, write_animation};

/// The holes of a wheel that rolls, by a criterion over several positions
#[derive(Parser)]
#[command(version, name = "rolling_wheel")]
struct Options {
    /// Pairs of triangles in the width of a sector
    #[arg(long, value_name = "N", default_value_t = 12)]
    cells: usize,
    /// Positions between two sectors
    #[arg(long, value_name = "M", default_value_t = 6)]
    positions: usize,
    /// Positions at which the wheels are compared
    #[arg(long, value_name = "N", default_value_t = 12)]
    compared: usize,
    /// q of the mean of works
    #[arg(long, value_name = "Q", default_value_t = 1.0)]
    exponent: f64,
    /// a of the uneven pressure (N cm²)
    #[arg(long, value_name = "A", default_value_t = 20.0)]
    unevenness: f64,
    /// b of the variance of the reaction (cm²/N)
    #[arg(long, value_name = "B", default_value_t = 1000.0)]
    variance: f64,
    /// Steps with the smooth perimeter, at most
    #[arg(long, value_name = "N", default_value_t = 40)]
    steps: usize,
    /// Steps with the length of Γ after them, at most
    #[arg(long, value_name = "N", default_value_t = 15)]
    last_steps: usize,
    /// Begins again where a run was stopped, or had ended
    #[arg(long)]
    anew: bool,
    /// Directory of all results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/rolling_wheel")]
    out: PathBuf,
}

fn main() -> ExitCode {
    program_with_options(run)
}

impl Options {
    /// J over a number of positions.
    fn rolling(&self, count: usize) -> Rolling {
        let criterion = RollingCriterion {
            exponent: self.exponent,
            unevenness: self.unevenness,
            length: std::f64::consts::TAU * OUTER_RADIUS / HOLES as f64,
            variance: self.variance,
        };
        Rolling { criterion, ..Rolling::over_sector(count) }
    }

    /// The optimum of a criterion over some positions, from nodal values of φ.
    fn optimum(
        &self,
        name: &str,
        rolling: &Rolling,
        initial: &Field<2>,
        out: &mut StandardOutput,
    ) -> Result<Descended, Failure> {
        let wheel = Wheel::rolling(self.cells, rolling)?;
        let initial = Field::from_values(&wheel.scalars, initial.values().to_vec())?;
        let RollingCriterion { exponent, unevenness, variance, .. } = rolling.criterion;
        out.line(format!("{name}:"));
        let descent = WheelDescent {
            initial: &initial,
            steps: [self.steps, self.last_steps],
            smoothing: 2.0,
            settings: json!({
                "cells": self.cells,
                "positions": rolling.positions.len(),
                "exponent": exponent,
                "unevenness": unevenness,
                "variance": variance,
            }),
            anew: self.anew,
            directory: &self.out.join(name.replace(' ', "_")),
        };
        descent.run(wheel, out)
    }
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Failure> {
    let rolling = options.rolling(options.positions);
    let wheel = Wheel::rolling(options.cells, &rolling)?.with_length();
    let round = Field::interpolate(&wheel.scalars, round_holes)?;
    out.line(format!("{} positions on {} unknowns:", options.positions, wheel.unknowns()));
    check_gradient(&wheel, &round, &sector_wave, out)?;
    turned_by_a_sector(options.cells, &rolling, out)?;
    cost(options.cells, &rolling, out)?;

    let single = Rolling::over_sector(1);
    let one = options.optimum("one position", &single, &round, out)?;
    // From there what several positions ask for is a small change.
    let all = options.optimum("rolling", &rolling, &one.phi, out)?;
    let runs = [("one position", one), ("rolling", all)];
    // All wheels in the same positions.
    let compared = options.rolling(options.compared);
    let judge = Wheel::rolling(options.cells, &compared)?.with_length();
    let mut rolled = vec![Rolled::new("round holes", &judge, &compared, &round)?];
    for (name, Descended { phi, wheel, .. }) in &runs {
        rolled.push(Rolled::new(name, &judge, &compared, phi)?);
        let body = Cut::by(phi)?;
        out.line(format!(
            "{name}: wall {:.3}, pattern off by {:.0e}",
            least_wall(&body),
            wheel.pattern_error(phi)?
        ));
    }
    table(&rolled, out);
    write_csv(&rolled, &options.out.join("positions.csv"))?;
    picture(&judge, &rolled)?.write_png_at(options.out.join("rolling_wheel.png"), 150.0)?;
    write_animation(&judge, &rolled[2], &options.out.join("rolling_wheel_animation.png"))?;
    out.line(format!("histories, curves and pictures: {}", options.out.display()));
    Ok(())
}
