//! Descent of a wheel: with the smooth perimeter, and with the length of Γ from there.

use std::path::Path;

use forms_fem::output::StandardOutput;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use forms_fem::shape_optimisation::level_set::{LevelSetDescent, LevelSetOptions, LevelSetRow};
use serde_json::{Value, json};

use super::Wheel;
use crate::level_set::descend;

/// Start and options of both descents.
pub struct WheelDescent<'a> {
    /// φ to begin with.
    pub initial: &'a Field<2>,
    /// Steps with the smooth perimeter, and with the length of Γ, at most.
    pub steps: [usize; 2],
    /// Waves of φ, and of holes, that are shorter than this move less \[cm\].
    pub smoothing: f64,
    /// An object with what the problem depends on, for checkpoints.
    pub settings: Value,
    /// Whether to begin again in place of going on from a checkpoint.
    pub anew: bool,
    /// Directory of the checkpoints and histories.
    pub directory: &'a Path,
}

/// A wheel at the end of both descents.
pub struct Descended {
    /// The problem with the price of the length of Γ.
    pub wheel: Wheel,
    /// φ.
    pub phi: Field<2>,
    /// Both courses, one after the other.
    pub course: Vec<LevelSetRow>,
    /// The last row of the first one.
    pub at_switch: usize,
}

impl WheelDescent<'_> {
    /// Both descents.
    ///
    /// # Errors
    /// Those of a descent, of checkpoints with other settings and of files.
    pub fn run(&self, wheel: Wheel, out: &mut StandardOutput) -> Result<Descended, Failure> {
        let run = |wheel: &Wheel, initial: &Field<2>, place: usize, out: &mut StandardOutput| {
            let options = LevelSetOptions {
                iterations: self.steps[place],
                smoothing: self.smoothing,
                interface_smoothing: self.smoothing,
                constraint_tolerance: 1e-4,
                ..LevelSetOptions::new(wheel.size())
            };
            let name = ["smooth", "length"][place];
            let mut settings = self.settings.clone();
            settings["perimeter"] = json!(name);
            settings["smoothing"] = json!(self.smoothing);
            settings["steps before"] = json!(self.steps[..place].iter().sum::<usize>());
            let descent = LevelSetDescent { problem: wheel, initial: initial.clone(), options };
            descend(&descent, &settings, self.anew, &self.directory.join(name), out)
        };
        let smooth = run(&wheel, self.initial, 0, out)?;
        let wheel = wheel.with_length();
        let best = run(&wheel, &smooth.phi, 1, out)?;
        let mut course = smooth.state.history;
        let at_switch = course.len() - 1;
        course.extend(best.state.history);
        Ok(Descended { wheel, phi: best.phi, course, at_switch })
    }
}
