//! Newton's method of a problem that is kept away from known solutions.

use super::{Problem, SolveError};
use crate::solve::{Deflation, Elimination, NewtonFailure};

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// Known solutions, from which Newton's method is kept away: steps are lengthened, shortened or turned round, and the criterion of convergence stays.
    /// A start other than these solutions is needed ([`Problem::start`]). A known solution that is found all the same is refused:
    /// [`NewtonFailure::KnownSolution`].
    pub fn deflated(mut self, known: &Deflation<D, N>) -> Self {
        self.deflation = Some(known.clone());
        self
    }

    /// Looks at the known solutions from a start.
    pub(super) fn repel(&mut self, elimination: &Elimination, start: &[f64]) -> Result<(), SolveError> {
        self.repulsion = None;
        let Some(deflation) = &self.deflation else { return Ok(()) };
        for known in deflation.known() {
            self.check_spaces("known solution", known.each_ref().map(|field| field.space()))?;
        }
        let mut imposed = start.to_vec();
        elimination.impose(&mut imposed).map_err(NewtonFailure::Mismatch)?;
        let repulsion = deflation.repulsion_at(&imposed);
        if let Some(number) = repulsion.starts_at() {
            return Err(NewtonFailure::StartsAtKnownSolution { number }.into());
        }
        self.repulsion = Some(repulsion);
        Ok(())
    }

    /// Refuses a known solution.
    pub(super) fn refuse_known(&self, u: &[f64]) -> Result<(), SolveError> {
        match self.repulsion.as_ref().and_then(|repulsion| repulsion.known_at(u)) {
            Some(number) => Err(NewtonFailure::KnownSolution { number }.into()),
            None => Ok(()),
        }
    }
}
