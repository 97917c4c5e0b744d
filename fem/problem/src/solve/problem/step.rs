//! A load step of a problem: the state from which Newton's method starts again, and the motion from it followed.

use super::Problem;
use super::SolveError;
use crate::field::Field;
use crate::solve::{NewtonFailure, Processes};

impl<'a, const D: usize, const N: usize> Problem<'a, D, N> {
    /// The last state, if the start is a prediction from it; where the prediction leads nowhere, Newton's method starts there.
    pub(super) fn state_before_prediction(&self) -> Option<[&'a Field<D>; N]> {
        let (start, before) = (self.start?, self.last_state?);
        let is_predicted = start.iter().zip(before).any(|(start, before)| !std::ptr::eq(*start, before));
        is_predicted.then_some(before)
    }

    /// An error if sliding pairs passed through each other on the way from the last state.
    pub(super) fn follow_from_last_state(&self, u: &[f64]) -> Result<(), SolveError> {
        let Some(before) = self.last_state else { return Ok(()) };
        let before: Vec<f64> = before.iter().flat_map(|field| field.values()).copied().collect();
        // On pieces each process knows the thickness of its own cells behind a surface: the thinnest decides.
        let processes = Processes::new(self.communicator, self.divided.clone());
        let own = self.system.follow_motion(&before, u);
        Ok(processes.all_succeed(self.system.form.name(), own).map_err(NewtonFailure::Refused)?)
    }
}
