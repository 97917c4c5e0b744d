//! The command line.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use forms_fem::shape_optimisation::{DescentOptions, InnerProduct};
use serde_json::{Value, json};

/// Shape optimisation under contact: free boundaries move until a criterion is smallest at constant volume.
///
/// Lengths are in cm, stresses in MPa. A run that was stopped goes on from its last step.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "shape_optimisation")]
pub struct Options {
    /// The problem to optimise
    #[arg(value_enum, default_value_t = Case::Figure6)]
    pub case: Case,
    /// Holes around the ring
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub holes: usize,
    /// Rows of holes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub rows: usize,
    /// Radius of a hole (cm)
    #[arg(long, value_name = "R", default_value_t = 2.0)]
    pub hole_radius: f64,
    /// Cells along a side of a sector of the ring, a quarter of a hole; a tenth of the cantilever's length [default: 4, 8 for
    /// even-pressure]
    #[arg(long, value_name = "N")]
    cells_per_side: Option<usize>,
    /// Cells between a hole and the sides of its sector [default: 4]
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub layers: usize,
    /// Penalty of the initial perimeter of the moving boundary, in units of the criterion; it keeps the boundary
    /// smooth [default: 0.8 for figure-6, 0.3 for even-pressure, 0.1 for cantilever]
    #[arg(long, value_name = "P")]
    perimeter_penalty: Option<f64>,
    /// Waves of the moving boundary that are shorter than this move less (cm)
    #[arg(long, value_name = "L", default_value_t = 2.0)]
    pub smoothing: f64,
    /// Thickness that stays between holes, and between them and the ring's circles; height that stays of the cantilever
    /// (cm) [default: 0.2, 4 for cantilever]
    #[arg(long, value_name = "W")]
    wall: Option<f64>,
    /// The least scaled Jacobian below which the mesh is made again; 0: never [default: 0.4, 0.25 for cantilever]
    #[arg(long, value_name = "Q")]
    remesh_below: Option<f64>,
    /// Steps, at most
    #[arg(long, value_name = "N", default_value_t = 100)]
    pub steps: usize,
    /// The longest way of a node in a step (cm)
    #[arg(long, value_name = "L", default_value_t = 0.2)]
    pub longest_move: f64,
    /// The derivative, relative to the first, at which a shape is called optimal
    #[arg(long, value_name = "T", default_value_t = 1e-3)]
    pub gradient_tolerance: f64,
    /// Number of steps between written shapes
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub every: usize,
    /// Begins again where a run was stopped, or had ended
    #[arg(long)]
    pub anew: bool,
    /// Runs even if the estimated memory exceeds what is available
    #[arg(long)]
    pub any_memory: bool,
    /// Directory of all results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/shape_optimisation")]
    pub out: PathBuf,
}

/// The problem to optimise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Case {
    /// The paper's Figure 6: a pressed ring with holes, ∫ F·u with F = (0, −1 N), once with the adjoint (22) in the
    /// boundary form and once with (21) in the volume form
    #[value(name = "figure-6")]
    Figure6,
    /// The same ring: how uneven the contact pressure p is, L ∫p²/(∫p)², with (21)
    EvenPressure,
    /// A cantilever that rests on a support: the work of its load, with (21)
    Cantilever,
}

impl Case {
    /// The name of files.
    pub fn name(self) -> &'static str {
        match self {
            Case::Figure6 => "figure_6",
            Case::EvenPressure => "even_pressure",
            Case::Cantilever => "cantilever",
        }
    }

    /// The criterion as the label of an axis.
    pub fn label(self) -> &'static str {
        match self {
            Case::Figure6 => "∫ F·u + perimeter penalty [N cm^{3}]",
            Case::EvenPressure => "L ∫p^{2}/(∫p)^{2} + perimeter penalty",
            Case::Cantilever => "work of the load + perimeter penalty [MPa cm^{2}]",
        }
    }
}

impl Options {
    /// Penalty of the initial perimeter of the moving boundary, in units of the criterion.
    pub fn perimeter_penalty(&self) -> f64 {
        self.perimeter_penalty.unwrap_or(match self.case {
            Case::Figure6 => 0.8,
            Case::EvenPressure => 0.3,
            Case::Cantilever => 0.1,
        })
    }

    /// The wall that stays \[cm\].
    pub fn wall(&self) -> f64 {
        self.wall.unwrap_or(if self.case == Case::Cantilever { 4.0 } else { 0.2 })
    }

    /// The least scaled Jacobian below which the mesh is made again.
    pub fn remesh_below(&self) -> f64 {
        self.remesh_below.unwrap_or(if self.case == Case::Cantilever { 0.25 } else { 0.4 })
    }

    /// Cells along a side of a sector of the ring, or of a tenth of the cantilever's length. A pressure that is to become even
    /// needs a contact zone of many cells.
    pub fn cells_per_side(&self) -> usize {
        self.cells_per_side.unwrap_or(match self.case {
            Case::EvenPressure => 8,
            _ => 4,
        })
    }

    /// Number of unknowns of the displacement on biquadratic cells, without those on the boundary, computed without a mesh.
    pub fn unknowns(&self) -> f64 {
        let [side, layers] = [self.cells_per_side(), self.layers].map(|count| count as f64);
        let cells = match self.case {
            Case::Cantilever => 30.0 * side * side,
            _ => 4.0 * self.rows as f64 * self.holes as f64 * side * layers,
        };
        8.0 * cells
    }

    /// Options of the descent.
    pub fn descent(&self) -> DescentOptions {
        let inner_product = InnerProduct { tangential: self.smoothing, ..InnerProduct::elasticity(0.0) };
        DescentOptions {
            iterations: self.steps,
            inner_product,
            gradient_tolerance: self.gradient_tolerance,
            ..DescentOptions::new(self.longest_move)
        }
    }

    /// Settings that a run which goes on may change.
    pub fn changeable(&self) -> Value {
        json!({ "steps": self.steps, "every": self.every })
    }

    /// All that a result depends on. The number of steps does not change the steps.
    pub fn settings(&self, run: &str) -> Result<Value, serde_json::Error> {
        let mut settings = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "case": self.case.name(),
            "run": run,
            "holes": self.holes,
            "rows": self.rows,
            "hole_radius": self.hole_radius,
            "cells_per_side": self.cells_per_side(),
            "layers": self.layers,
            "perimeter_penalty": self.perimeter_penalty(),
            "wall": self.wall(),
            "remesh_below": self.remesh_below(),
        });
        if let (Some(all), Value::Object(descent)) =
            (settings.as_object_mut(), serde_json::to_value(self.descent())?)
        {
            all.extend(descent.into_iter().filter(|(name, _)| name != "iterations"));
        }
        Ok(settings)
    }
}
