//! A branch of solutions that was followed: its points, its events, and why it ended.

use std::error::Error;
use std::fmt;

use super::events::EventKind;
use super::family::Direction;
use super::inertia::Inertia;
use crate::assemble::AssemblyError;
use crate::field::Field;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::{NewtonError, NewtonFailure};

/// A point of a branch, with what the caller measured there.
#[derive(Clone, Debug)]
pub struct BranchPoint<M> {
    /// λ.
    pub parameter: f64,
    /// Length of the branch up to here. It is dimensionless: in the first step each field and λ add one.
    pub arc_length: f64,
    /// dλ/ds relative to the first step's change of λ: its sign changes at limit points.
    pub slope: f64,
    /// Signs of the tangent's eigenvalues.
    pub inertia: Inertia,
    /// Newton steps that led here.
    pub iterations: usize,
    /// The measurement.
    pub measured: M,
}

/// A limit point or a bifurcation, located.
#[derive(Clone, Debug)]
pub struct BranchEvent<const D: usize, const N: usize = 1> {
    /// Its kind.
    pub kind: EventKind,
    /// λ there.
    pub parameter: f64,
    /// The uncertainty of λ, from the points next to it \[λ\].
    pub uncertainty: f64,
    /// Length of the branch up to here.
    pub arc_length: f64,
    /// The number of the point before it.
    pub after: usize,
    /// The unknowns there.
    pub fields: [Field<D>; N],
    /// Null vectors of the tangent at a bifurcation, each with its largest entry one: directions of the other branches. Of a limit point none.
    pub modes: Vec<[Field<D>; N]>,
    pub(super) direction: Direction,
}

impl<const D: usize> BranchEvent<D, 1> {
    /// The one unknown there.
    pub fn field(&self) -> &Field<D> {
        &self.fields[0]
    }
}

/// A reason for which a branch was not followed further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BranchEnd {
    /// The number of points was reached.
    Points,
    /// The parameter came to the end of its range, where the last point is.
    Range,
    /// The caller's condition held.
    Stopped,
}

/// A branch that was followed.
#[derive(Clone, Debug)]
pub struct Branch<M, const D: usize, const N: usize = 1> {
    /// The first point and each further one.
    pub points: Vec<BranchPoint<M>>,
    /// Limit points and bifurcations, in their order.
    pub events: Vec<BranchEvent<D, N>>,
    /// The unknowns at the last point.
    pub fields: Option<[Field<D>; N]>,
    /// The reason of its end; `None` if it failed.
    pub end: Option<BranchEnd>,
}

impl<M, const D: usize, const N: usize> Branch<M, D, N> {
    /// The limit points.
    pub fn limit_points(&self) -> impl Iterator<Item = &BranchEvent<D, N>> {
        self.events.iter().filter(|event| event.kind == EventKind::LimitPoint)
    }

    /// The bifurcations.
    pub fn bifurcations(&self) -> impl Iterator<Item = &BranchEvent<D, N>> {
        self.events.iter().filter(|event| event.kind != EventKind::LimitPoint)
    }
}

/// A reason why a branch could not be followed.
#[derive(Debug, thiserror::Error)]
pub enum ContinuationFailure {
    /// No solution at the first parameter, or none on the other branch.
    #[error("no first point was found: {0}")]
    Start(#[source] Box<NewtonError>),
    /// The smallest step failed.
    #[error(
        "the branch could not be followed from the parameter {parameter}, also with the smallest step: {why}"
    )]
    Step {
        /// λ of the last point.
        parameter: f64,
        /// The failure of the smallest step.
        #[source]
        why: Box<NewtonError>,
    },
    /// The branch turns by more than 60° in the smallest step, and not at one kink.
    #[error(
        "the branch turns at the parameter {parameter} by more than can be followed, also with the smallest step"
    )]
    Kink {
        /// λ of the last point.
        parameter: f64,
    },
    /// The tangent is singular in a whole step, so that its eigenvalues have no signs: something is not held.
    #[error(
        "the tangent is singular next to the parameter {parameter}, also with the smallest step, so that stability and bifurcations \
         cannot be judged: perhaps a body is not held"
    )]
    Singular {
        /// λ of the last point.
        parameter: f64,
    },
    /// A first point that is not next to the bifurcation in the direction of the null vector.
    #[error(
        "the amplitude {amplitude} leads to a point far from the bifurcation, perhaps on the branch itself: take another one"
    )]
    FarFromBifurcation {
        /// The amplitude that was asked for.
        amplitude: f64,
    },
    /// An event without the null vector that was asked for.
    #[error("the event has {known} null vectors, and number {number} was asked for (numbered from 0)")]
    NoMode {
        /// The number of the mode.
        number: usize,
        /// Modes of the event.
        known: usize,
    },
    /// A first step that is zero or not finite.
    #[error("the first step is a change of the parameter, but {step} is none")]
    FirstStep {
        /// The step that was given.
        step: f64,
    },
    /// A second form that is not the derivative of the first.
    #[error(
        "the second form is not the derivative of `{form}` with respect to the parameter: differences of residuals are off by {off:.1e} \
         of it; write `derivative({form}(u, v), parameter, 1)`"
    )]
    NotTheRate {
        /// The form.
        form: &'static str,
        /// The difference as a part of the derivative.
        off: f64,
    },
    /// Histories, whose values belong to a path and not to a state.
    #[error("`{form}` reads a history: its values would depend on the steps of the continuation")]
    History {
        /// The form.
        form: &'static str,
    },
    /// Forms, spaces or constraints that do not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The caller's measurement failed.
    #[error("the measurement failed: {0}")]
    Measurement(#[source] Box<dyn Error + Send + Sync>),
}

impl From<NewtonFailure> for ContinuationFailure {
    fn from(why: NewtonFailure) -> Self {
        ContinuationFailure::Start(Box::new(why.into()))
    }
}

impl From<NewtonError> for ContinuationFailure {
    fn from(why: NewtonError) -> Self {
        ContinuationFailure::Start(Box::new(why))
    }
}

impl From<LinearAlgebraError> for ContinuationFailure {
    fn from(why: LinearAlgebraError) -> Self {
        NewtonFailure::Mismatch(why).into()
    }
}

/// A continuation that stopped, with the branch up to there.
pub struct ContinuationError<M, const D: usize, const N: usize = 1> {
    /// The reason.
    pub why: ContinuationFailure,
    /// The branch so far.
    pub branch: Branch<M, D, N>,
}

impl<M, const D: usize, const N: usize> fmt::Display for ContinuationError<M, D, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.branch.points.len();
        write!(
            f,
            "the continuation stopped after {count} point{}: {}",
            if count == 1 { "" } else { "s" },
            self.why
        )
    }
}

// It is what `main` prints of an error that it returns: without fields.
impl<M, const D: usize, const N: usize> fmt::Debug for ContinuationError<M, D, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{self}")?;
        write!(f, "{:?}", self.why)
    }
}

impl<M, const D: usize, const N: usize> Error for ContinuationError<M, D, N> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        Some(&self.why)
    }
}
