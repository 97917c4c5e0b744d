//! Errors of histories.

use thiserror::Error;

use super::controls::ControlError;
use crate::assemble::AssemblyError;
use crate::constraints::ConstraintsError;
use crate::field::FieldError;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::{SolveError, SolverError};
use crate::space::SpaceError;
use crate::time::StepFailure;

/// A history whose value or gradient could not be computed.
#[derive(Debug, Error)]
#[error("step {step} of the history: {why}")]
pub struct HistoryError {
    /// The number of the step, from 0.
    pub step: usize,
    /// The reason.
    #[source]
    pub why: HistoryFailure,
}

/// A reason why a history failed.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum HistoryFailure {
    /// Controls that do not fit, or that do not exist.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A history without a form of its steps, of their sensitivities, or without a criterion.
    #[error("the history has no {0}: give it with `.{0}(..)`")]
    Missing(&'static str),
    /// A history with a criterion of its own, where its states are wanted.
    #[error("the history has a criterion of its own; readings are of a history without one")]
    OwnCriterion,
    /// Rates that lack the test function of a control, or of the state before.
    #[error("`{form}` has no test function `by_{name}`: {meaning}")]
    NotTested {
        /// The form of the sensitivities.
        form: &'static str,
        name: String,
        /// Meaning of the missing test function.
        meaning: &'static str,
    },
    /// A test function of the sensitivities that belongs to no control.
    #[error(
        "the test function `{test}` of `{form}` belongs to no control: it is `by_` and a control's name, `by_before` (of several unknowns `by_before_u` and \
         so on), or of motions `by_value`, `by_rate`, `by_second_rate` (of several unknowns `by_value_u` and so on)"
    )]
    UnknownTest {
        /// The form of the sensitivities.
        form: &'static str,
        test: &'static str,
    },
    /// Rates with an unknown.
    #[error("`{unknown}` of `{form}` is an unknown; sensitivities are of known fields, `State`s")]
    RateOfUnknown {
        /// The form of the sensitivities.
        form: &'static str,
        unknown: &'static str,
    },
    /// Observations of a step that is never taken.
    #[error("something is observed at step {step}, and the last step is {}", steps.saturating_sub(1))]
    ObservedLater {
        /// The step observed, from 0.
        step: usize,
        steps: usize,
    },
    /// Observations of states on another space.
    #[error("what is observed at step {step} is a state on another space than the history's")]
    ObservedElsewhere {
        /// The step observed.
        step: usize,
    },
    /// A step in time that was not taken.
    #[error(transparent)]
    Step(Box<StepFailure>),
    /// Steps that do not go on.
    #[error("the step size {0} is no positive number")]
    StepSize(f64),
    /// Contact pairs of displaced surfaces in a motion: what displaces them is no weight times the step's unknown.
    #[error(
        "`{form}` has pairs of displaced surfaces; adjoints of such motions are not available (those of load histories are)"
    )]
    Sliding { form: &'static str },
    /// A form of motion that reads its unknown next to the operators of [`time`](crate::time), with a scheme that reads second rates.
    #[error(
        "`{form}` reads its unknown `{unknown}` itself: at the start, where this scheme finds the second rate from the form, that is no \
         value but a second rate; read `displacement({unknown})`, `velocity({unknown})`, `acceleration({unknown})` (of scalars `value`, \
         `rate`, `second_rate`), or take a scheme that reads none, as the mid-point rule"
    )]
    UnknownItself { form: &'static str, unknown: &'static str },
    /// Second derivatives of a form of motion that reads more than operators give.
    #[error(
        "second derivatives take forms of motion that read unknown and state before by the operators of time alone, and `{form}` reads \
         one of them itself"
    )]
    BesideOperators { form: &'static str },
    /// Values at quadrature points that steps would write.
    #[error(
        "`{form}` reads the history `{field}`: what a step writes at quadrature points has no adjoint here; let the past be a field"
    )]
    QuadratureValues { form: &'static str, field: &'static str },
    /// Constraints on a space on which no unknown is left without.
    #[error("constraints were given for a space on which no unknown is left without")]
    Unconstrained,
    /// A form of a step with another number of unknowns than the history has spaces.
    #[error("`{form}` has {found} unknowns, and the history has {expected} spaces")]
    Unknowns { form: &'static str, found: usize, expected: usize },
    /// A form that does not fit, or could not be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The equations of a step were not solved.
    #[error(transparent)]
    Solve(Box<SolveError>),
    /// The adjoint system of a step was not solved.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A vector or matrix is unfit.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
    /// Conditions that do not fit.
    #[error(transparent)]
    Constraints(#[from] ConstraintsError),
    /// A state that is not finite.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A state that was not written to the directory of stored states, or not read from it.
    #[error("stored states: {0}")]
    Storage(#[source] std::io::Error),
    /// No space of constants on the mesh.
    #[error(transparent)]
    Space(#[from] SpaceError),
}

impl From<StepFailure> for HistoryFailure {
    fn from(error: StepFailure) -> Self {
        HistoryFailure::Step(Box::new(error))
    }
}

impl From<SolveError> for HistoryFailure {
    fn from(error: SolveError) -> Self {
        HistoryFailure::Solve(Box::new(error))
    }
}

impl HistoryFailure {
    /// The error at a step.
    pub(super) fn at(self, step: usize) -> HistoryError {
        HistoryError { step, why: self }
    }
}
