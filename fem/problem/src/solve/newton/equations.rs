//! Newton's loop: judge the last iterate, find a change of it, take the change.

use super::NewtonFailure;

/// The outcome of a judgement.
pub(in crate::solve) enum Verdict {
    /// The last iterate is the solution.
    Solution,
    /// It is to be changed by this, on all unknowns, and judged again.
    Correct(Vec<f64>),
    /// It is not the solution.
    GoOn,
}

/// A change of the unknowns of some equations.
pub(in crate::solve) struct Change {
    /// One entry per unknown of the equations.
    pub values: Vec<f64>,
    pub origin: Origin,
}

/// The origin of a change.
#[derive(Clone, Copy)]
pub(in crate::solve) enum Origin {
    /// −K⁻¹R with the tangent at the last iterate.
    Tangent { linear_iterations: usize, condensed_unknowns: Option<usize> },
    /// A correction from the judgement of the last iterate. It says nothing of the progress of Newton's method.
    Judgement,
}

/// Equations on which Newton's loop iterates: those of all free unknowns, or fewer. They keep their iterates.
pub(in crate::solve) trait Equations {
    /// Whether the last iterate is the solution, or what to do.
    ///
    /// # Errors
    /// If there is no sense in going on.
    fn judge(&mut self) -> Result<Verdict, NewtonFailure>;

    /// −K⁻¹R at the last iterate.
    ///
    /// # Errors
    /// If assembly or the linear solver fails.
    fn newton_change(&mut self) -> Result<Change, NewtonFailure>;

    /// Takes a change, or a part of it, and enters the next iterate into the history.
    ///
    /// # Errors
    /// If assembly fails, or no part of the change serves.
    fn take(&mut self, change: Change) -> Result<(), NewtonFailure>;
}

/// Newton's method: K δ = −R is solved, and the step or a part of it is taken, until an iterate is the solution.
///
/// # Errors
/// [`NewtonFailure`].
pub(in crate::solve) fn iterate(equations: &mut dyn Equations) -> Result<(), NewtonFailure> {
    loop {
        let change = match equations.judge()? {
            Verdict::Solution => return Ok(()),
            Verdict::Correct(values) => Change { values, origin: Origin::Judgement },
            Verdict::GoOn => equations.newton_change()?,
        };
        equations.take(change)?;
    }
}
