//! The command line.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use forms_fem::shape_optimisation::DescentOptions;
use serde_json::{Value, json};

/// The paper's Figure 6: a ring with a periodic pattern of holes is pressed on the ground; the holes, free boundaries, move
/// until the criterion is least at the same volume. Once with the adjoint (22) in the boundary form, once with (21) in the
/// volume form.
///
/// Lengths are in cm, stresses in MPa. A run that was stopped goes on from its last step.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "ring_with_holes")]
pub struct Options {
    /// Holes around
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub holes: usize,
    /// Rows of holes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub rows: usize,
    /// Radius of a hole [cm]
    #[arg(long, value_name = "R", default_value_t = 2.0)]
    pub hole_radius: f64,
    /// Cells along a side of a sector, a quarter of a hole
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub cells_per_side: usize,
    /// Cells between a hole and the sides of its sector
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub layers: usize,
    /// What is to become small
    #[arg(long, value_enum, default_value_t = Goal::Paper)]
    pub criterion: Goal,
    /// Steps, at most
    #[arg(long, value_name = "N", default_value_t = 100)]
    pub steps: usize,
    /// The longest way of a node in a step [cm]
    #[arg(long, value_name = "L", default_value_t = 0.15)]
    pub longest_move: f64,
    /// The derivative, relative to the first, at which a shape is called optimal
    #[arg(long, value_name = "T", default_value_t = 1e-3)]
    pub gradient_tolerance: f64,
    /// Every so many steps the shape is written
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub every: usize,
    /// Begins anew where a run was stopped, or had ended
    #[arg(long)]
    pub anew: bool,
    /// Directory of all results; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/ring_with_holes")]
    pub out: PathBuf,
}

/// What is to become small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Goal {
    /// ∫ F·u with F = (0, −1 N), the paper's; with (22) and with (21)
    Paper,
    /// How uneven the contact pressure p is, L ∫p²/(∫p)²; with (21)
    Pressure,
}

impl Options {
    /// How the descent goes.
    pub fn descent(&self) -> DescentOptions {
        DescentOptions {
            iterations: self.steps,
            gradient_tolerance: self.gradient_tolerance,
            ..DescentOptions::new(self.longest_move)
        }
    }

    /// All that a result depends on. The number of steps does not change the steps.
    pub fn settings(&self, run: &str) -> Result<Value, serde_json::Error> {
        let mut descent = serde_json::to_value(self.descent())?;
        if let Some(descent) = descent.as_object_mut() {
            descent.remove("iterations");
        }
        Ok(json!({
            "run": run,
            "holes": self.holes,
            "rows": self.rows,
            "hole_radius": self.hole_radius,
            "cells_per_side": self.cells_per_side,
            "layers": self.layers,
            "descent": descent,
        }))
    }
}
