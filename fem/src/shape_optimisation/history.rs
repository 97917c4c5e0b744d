//! State and history of a descent: all that a run needs to resume.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::stored_mesh::StoredMesh;

/// A shape on the way, the next step's length, and the way so far. A descent that goes on from it is the one that would
/// have gone on, to the last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DescentState {
    /// Coordinates of the mesh's nodes, node after node \[length\].
    pub nodes: Vec<f64>,
    /// The mesh whose nodes they are, once it is not that of the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<StoredMesh>,
    /// The factor of the next step that is tried; none before the first.
    pub step: Option<f64>,
    /// The start and each step.
    pub history: Vec<Row>,
    /// The reason why it stopped, once it has.
    pub finish: Option<StopReason>,
}

/// A shape on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The criterion.
    pub criterion: f64,
    /// The constraint, where there is one.
    pub constraint: Option<f64>,
    /// The least scaled Jacobian of all cells.
    pub quality: f64,
    /// Whether the mesh was smoothed.
    pub smoothed: bool,
    /// The values before the mesh was made again, where it was; those above are the new mesh's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remeshed: Option<Remeshed>,
    /// The step that led here; none at the start.
    pub step: Option<Step>,
}

/// The values before the mesh was made again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remeshed {
    /// The criterion on the old mesh.
    pub criterion: f64,
    /// The constraint there.
    pub constraint: Option<f64>,
    /// The least scaled Jacobian there.
    pub quality: f64,
    /// Cells of the new mesh.
    pub cells: usize,
}

/// A step that was taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Its factor.
    pub factor: f64,
    /// Lengths that were tried.
    pub trials: usize,
    /// The longest way of a node \[length\].
    pub longest_move: f64,
    /// λ of the augmented Lagrangian, at the shape before.
    pub multiplier: f64,
    /// The norm of the derivative along the constraint, in the inner product, at the shape before.
    pub gradient_norm: f64,
}

/// Reasons why a descent stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StopReason {
    /// The derivative along the constraint is as small as was asked.
    Converged,
    /// Several steps together brought less than was asked.
    Stalled,
    /// As many steps as were allowed.
    Iterations,
    /// No step along the direction brought a decrease; why the last trial failed.
    NoStep(String),
    /// Every step would have spoilt the cells.
    MeshQuality,
    /// Every step would have spoilt the cells, and no new mesh was made; why.
    NoNewMesh(String),
}

impl DescentState {
    /// Steps taken.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }

    /// The history as comma-separated values, one line per shape, with a header. Numbers are written such that they read
    /// back as what they were; what does not exist is empty.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "iteration,criterion,constraint,quality,smoothed,step,trials,longest move,multiplier,gradient norm,\
             criterion before remeshing,cells\n",
        );
        for (iteration, row) in self.history.iter().enumerate() {
            let constraint = row.constraint.map_or_else(String::new, |value| value.to_string());
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "{iteration},{},{constraint},{},{}",
                row.criterion,
                row.quality,
                u8::from(row.smoothed)
            );
            let _ = match &row.step {
                None => write!(text, ",,,,,"),
                Some(Step { factor, trials, longest_move, multiplier, gradient_norm }) => {
                    write!(text, ",{factor},{trials},{longest_move},{multiplier},{gradient_norm}")
                }
            };
            let _ = match &row.remeshed {
                None => writeln!(text, ",,"),
                Some(Remeshed { criterion, cells, .. }) => writeln!(text, ",{criterion},{cells}"),
            };
        }
        text
    }
}
