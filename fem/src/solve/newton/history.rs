//! What Newton's method is asked for, and what it tells: options, iterates, solution, failures.

use super::line_search::LineSearch;
#[cfg(doc)]
use super::newton;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::linear_solver::SolverError;

/// When Newton's method stops.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Converged at ‖R‖₂ ≤ `relative_tolerance` × ‖R‖₂ at the start (free unknowns, prescribed values imposed).
    pub relative_tolerance: f64,
    /// Converged also at ‖R‖₂ ≤ `absolute_tolerance` \[unit of R\].
    pub absolute_tolerance: f64,
    /// Most steps.
    pub max_iterations: usize,
    /// Whether steps are shortened where a whole one is too long; only for residuals with a potential.
    pub line_search: LineSearch,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            relative_tolerance: 1e-10,
            absolute_tolerance: 1e-300,
            max_iterations: 50,
            line_search: LineSearch::Off,
        }
    }
}

/// One iterate in Newton's history, and the step that led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonStep {
    /// 0 for the start.
    pub iteration: usize,
    /// ‖R‖₂ on free unknowns \[unit of R\].
    pub residual: f64,
    /// Residual divided by the residual at the start (0 if that is 0).
    pub relative_residual: f64,
    /// Number of active quadrature points at this iterate.
    pub active_points: Option<usize>,
    /// Whether the active set differs from that of the iterate before.
    pub active_set_changed: Option<bool>,
    /// ‖δu‖₂ of the step that led here; none at the start.
    pub step: Option<f64>,
    /// Krylov iterations of that step (0 for a direct solution).
    pub linear_iterations: Option<usize>,
    /// The part of the Newton step that was taken: 1 unless a line search shortened it.
    pub damping: Option<f64>,
    /// Unknowns of the system of that step, where it was condensed to those that the nonlinearity touches.
    pub condensed_unknowns: Option<usize>,
}

/// The solution and how it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonSolution {
    /// All unknowns, with the prescribed values.
    pub u: Vec<f64>,
    /// R(u) on all unknowns: the reactions on the prescribed ones, about zero on the others.
    pub residual: Vec<f64>,
    /// The start and each iterate.
    pub history: Vec<NewtonStep>,
}

impl NewtonSolution {
    /// Number of Newton steps.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }
}

/// Why Newton's method failed.
#[derive(Debug, thiserror::Error)]
pub enum NewtonFailure<E> {
    /// The iterations are used up.
    #[error("no convergence within {iterations} iterations")]
    NotConverged {
        /// Steps made.
        iterations: usize,
    },
    /// The active set and the residual of an earlier iterate came back.
    #[error(
        "the active set of iteration {first} came back after {period} iterations, and no residual decreased"
    )]
    Cycling {
        /// Iterate that was reached again.
        first: usize,
        /// Steps in between.
        period: usize,
    },
    /// Steps no longer change u beyond rounding, but the residual is above the tolerance. A tolerance that the
    /// residual's own rounding allows (large stiffnesses, a small load) would have been met.
    #[error("the residual stagnates at rounding level, above the tolerance")]
    Stagnated,
    /// The residual became NaN or infinite.
    #[error("the residual is not finite")]
    NotFinite,
    /// A line search was asked for, but an unsymmetric tangent has no potential.
    #[error(
        "a line search needs a potential, but the tangent is not symmetric (asymmetry {asymmetry:e}); for Nitsche's \
         method that means theta = 1"
    )]
    NoPotential {
        /// [`BlockMatrix::asymmetry`](crate::linear_algebra::BlockMatrix::asymmetry) of the tangent.
        asymmetry: f64,
    },
    /// No step along a descent direction, however short, lowers the potential.
    #[error("the line search found no step that lowers the potential")]
    NoDescent,
    /// The linear solver failed.
    #[error("the linear solver failed: {0}")]
    LinearSolver(#[source] SolverError),
    /// Sizes disagree, or prescribed values are unfit.
    #[error("the problem does not fit together: {0}")]
    Mismatch(#[source] LinearAlgebraError),
    /// Assembly of the residual, the tangent or the active set failed.
    #[error("assembly failed: {0}")]
    Assembly(#[source] E),
}

/// A failure of Newton's method with the history up to it.
#[derive(thiserror::Error)]
#[error("Newton's method failed at iteration {}: {why}", .history.len().saturating_sub(1))]
pub struct NewtonError<E: std::error::Error> {
    /// The reason.
    pub why: NewtonFailure<E>,
    /// The iterates before the failure.
    pub history: Vec<NewtonStep>,
    /// The last iterate.
    pub u: Vec<f64>,
}

// A derived one would print every unknown.
impl<E: std::error::Error> std::fmt::Debug for NewtonError<E> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NewtonError")
            .field("why", &self.why)
            .field("history", &self.history)
            .field("unknowns", &self.u.len())
            .finish()
    }
}
