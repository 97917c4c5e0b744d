//! A load step of a problem: Newton's method from a predicted state, then from the last one, and the motion between followed.

use super::Problem;
use super::SolveError;
use super::solution::Found;
use crate::constraints::Constraints;
use crate::solve::{Elimination, LinearSolver, NewtonFailure, Processes};

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// The solution from the start, or, in a load step whose start is a prediction that leads nowhere, from the state before.
    pub(super) fn iterate_from_starts(
        &mut self,
        elimination: Elimination,
        constraints: [&Constraints<D>; N],
        solver: &mut dyn LinearSolver,
    ) -> Result<Found, SolveError> {
        let (start, before) = (self.start, self.last_state);
        let is_predicted = start.zip(before).is_some_and(|(start, before)| {
            start.iter().zip(before).any(|(start, before)| !std::ptr::eq(*start, before))
        });
        if is_predicted {
            let again = elimination.again();
            let found = self.iterate(elimination, constraints, start, solver);
            if let Ok(found) = found.and_then(|found| self.followed(found)) {
                return Ok(found);
            }
            // Nothing of the failure is kept but the solver's memory.
            let found = self.iterate(again, constraints, before, solver)?;
            return self.followed(found);
        }
        let found = self.iterate(elimination, constraints, start, solver)?;
        self.followed(found)
    }

    /// A solution to which no sliding pairs passed through each other on the way from the state before.
    fn followed(&self, found: Found) -> Result<Found, SolveError> {
        if let Some(before) = self.last_state {
            let before: Vec<f64> = before.iter().flat_map(|field| field.values()).copied().collect();
            // On pieces each process knows the thickness of its own cells behind a surface: the thinnest decides.
            let processes = Processes::new(self.communicator, self.divided.clone());
            let own = self.system.follow_motion(&before, &found.0);
            processes.all_succeed(self.system.form.name(), own).map_err(NewtonFailure::Refused)?;
        }
        Ok(found)
    }
}
