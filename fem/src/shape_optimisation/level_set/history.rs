//! State and history of a descent on φ: all that a run needs to go on.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::holes::NewHoles;
use crate::shape_optimisation::{Step, StopReason};

/// A level set function on the way, the next step's factor, and the way so far. A descent that goes on from it is the one that would
/// have gone on, to the last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelSetState {
    /// φ at the nodes of its space \[length\].
    pub values: Vec<f64>,
    /// The factor of the next step that is tried; none before the first.
    pub step: Option<f64>,
    /// The start and each step.
    pub history: Vec<LevelSetRow>,
    /// The reason why it stopped, once it has.
    pub finish: Option<StopReason>,
}

/// A body on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelSetRow {
    /// The criterion.
    pub criterion: f64,
    /// The constraint, where there is one.
    pub constraint: Option<f64>,
    /// Parts of the body that no cell connects.
    pub parts: usize,
    /// The criterion before φ was made a distance, where it was.
    pub before_distance: Option<f64>,
    /// The step that led here; none at the start and with new holes. Its length is the largest change of φ.
    pub step: Option<Step>,
    /// The new holes that led here, in place of a step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holes: Option<NewHoles>,
}

impl LevelSetState {
    /// Steps taken.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }

    /// The history as comma-separated values, one line per body, with a header. What does not exist is empty.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "iteration,criterion,constraint,parts,criterion before distance,step,trials,largest change,multiplier,gradient norm,\
             new holes,criterion before holes,criterion after holes\n",
        );
        let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        for (iteration, row) in self.history.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "{iteration},{},{},{},{}",
                row.criterion,
                optional(row.constraint),
                row.parts,
                optional(row.before_distance)
            );
            let _ = match &row.step {
                None => write!(text, ",,,,,"),
                Some(Step { factor, trials, longest_move, multiplier, gradient_norm }) => {
                    write!(text, ",{factor},{trials},{longest_move},{multiplier},{gradient_norm}")
                }
            };
            let _ = match &row.holes {
                None => writeln!(text, ",,,"),
                Some(NewHoles { count, before, after, .. }) => writeln!(text, ",{count},{before},{after}"),
            };
        }
        text
    }
}
