//! Errors of steps in time.

use thiserror::Error;

use crate::assemble::AssemblyError;
use crate::constraints::ConstraintsError;
use crate::field::FieldError;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::{SolveError, SolverError};

/// A step that was not taken. The loop is where it was before, and may take another one.
#[derive(Debug, Error)]
#[error("the step from t = {from} to {to} was not taken: {why}")]
pub struct StepError {
    /// The time before the step.
    pub from: f64,
    /// The time at its end.
    pub to: f64,
    /// The reason.
    #[source]
    pub why: StepFailure,
}

/// A reason why a step was not taken.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum StepFailure {
    /// A step size that is no positive number, or too small to change the time.
    #[error("the step size {0} is no positive number that changes the time")]
    StepSize(f64),
    /// States that are not in the order of time.
    #[error("the states before the step, newest first, have times that do not fall: {times:?}")]
    NotEarlier { times: Vec<f64> },
    /// A scheme whose formulas read states that do not exist.
    #[error("the scheme reads {read} states, and there are {known} before the step")]
    MissingStates { read: usize, known: usize },
    /// Schemes of unknowns that do not go together.
    #[error(
        "unknown {unknown} is integrated by {scheme} and the first one by {first}: they give loads at other times of a step or solve for something else"
    )]
    Schemes {
        /// The number of the unknown.
        unknown: usize,
        scheme: String,
        first: String,
    },
    /// A scheme for an unknown that does not exist.
    #[error("a scheme was given for unknown {unknown}, counted from 0, of {count}")]
    NoUnknown { unknown: usize, count: usize },
    /// Constraints on a space on which no unknown is left without.
    #[error("constraints were given for a space on which no unknown is left without")]
    Unconstrained,
    /// The form does not fit, or could not be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The equations of an implicit step were not solved.
    #[error(transparent)]
    Solve(Box<SolveError>),
    /// The linear system of a step was not solved.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A vector or matrix is unfit.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
    /// The conditions at a time do not fit.
    #[error(transparent)]
    Constraints(#[from] ConstraintsError),
    /// A field of the step is not finite.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// An affine form whose equations the solution does not fulfil.
    #[error(
        "the form's tangent has changed with the time, which `constant_coefficients` excludes: an equation is off by {residual:e}"
    )]
    CoefficientsChanged {
        /// The residual of the first equation that does not hold \[unit of R\].
        residual: f64,
    },
    /// A solution that does not satisfy the equations of its affine form.
    #[error("an equation of the step is off by {residual:e} with what the linear solver found")]
    Inaccurate {
        /// The residual of the first equation that does not hold \[unit of R\].
        residual: f64,
    },
    /// Row sums of a mass matrix that are no masses, as at vertices of elements of degree two.
    #[error(
        "unknown {unknown} has the lumped mass {mass}: lumping takes elements of degree one with mass everywhere"
    )]
    NoMass {
        unknown: usize,
        /// Its row sum.
        mass: f64,
    },
    /// Unknowns without inertia, as those of nodes at which there is no density, with a scheme that reads accelerations of states
    /// there: the trapezoidal and the mid-point rule and backward differences read none except for inertia.
    #[error(
        "{} have no inertia, and the scheme reads accelerations there: take the trapezoidal or the mid-point rule, or backward differences",
        listed(.unknowns)
    )]
    Massless { unknowns: Vec<usize> },
    /// Lumped masses of related unknowns.
    #[error("masses are lumped where unknowns are free or prescribed; here some are given by others")]
    LumpedRelations,
    /// A prescribed value that moves in an explicit step.
    #[error(
        "an explicit step keeps prescribed values as they are, but unknown {unknown} goes from {from} to {to}"
    )]
    MovingSupport {
        unknown: usize,
        /// Its value where the scheme takes it.
        from: f64,
        /// The value prescribed.
        to: f64,
    },
    /// A step whose error is larger than asked for.
    #[error("the error of the step, {error:e}, is above the tolerance {tolerance:e}")]
    TooInexact {
        /// Its estimate, at the node where it is largest \[value\].
        error: f64,
        /// The tolerance \[value\].
        tolerance: f64,
    },
    /// A number of a state, which is watched, that does not exist.
    #[error("the number `{name}` of the state at this time: {why}")]
    Event {
        name: String,
        #[source]
        why: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A tolerance that no step could keep.
    #[error("the tolerance {0} is no positive number")]
    Tolerance(f64),
}

/// Unknowns by their number and the first of them. A process may have none of those that another has.
fn listed(unknowns: &[usize]) -> String {
    match unknowns.first() {
        Some(first) => format!("{} unknowns, unknown {first} the first,", unknowns.len()),
        None => "unknowns of another process".to_owned(),
    }
}

impl From<SolveError> for StepFailure {
    fn from(error: SolveError) -> Self {
        StepFailure::Solve(Box::new(error))
    }
}

impl StepFailure {
    /// Whether a smaller step may succeed.
    pub(super) fn is_for_smaller_steps(&self) -> bool {
        matches!(self, StepFailure::Solve(_) | StepFailure::TooInexact { .. })
    }
}
