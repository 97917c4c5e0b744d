//! Equations with one parameter, as continuation sees them: residual, tangent and rate, on vectors.

use std::error::Error;

use super::inertia::Inertia;
use crate::assemble::AssemblyError;
use crate::solve::NonlinearProblem;

/// An error of whoever looks at points.
pub(super) type Refusal = Box<dyn Error + Send + Sync>;

/// Equations R(u, λ) = 0.
pub(super) trait Family {
    /// Takes a value of the parameter.
    ///
    /// # Errors
    /// [`AssemblyError`]: equations that do not exist there.
    fn set_parameter(&mut self, parameter: f64) -> Result<(), AssemblyError>;

    /// R(·, λ) at the parameter that was taken.
    fn equations(&mut self) -> &mut dyn NonlinearProblem;

    /// ∂R/∂λ at u, one entry per unknown.
    ///
    /// # Errors
    /// [`AssemblyError`]: if assembly fails.
    fn rate(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError>;

    /// Takes note of a point of the branch, and says whether to go on.
    ///
    /// # Errors
    /// Whatever the caller's measurement returns.
    fn reached(&mut self, point: &Reached) -> Result<Next, Refusal>;
}

/// Whether a branch is followed further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    GoOn,
    Stop,
}

/// A direction in (u, λ).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Direction {
    pub u: Vec<f64>,
    pub parameter: f64,
}

/// A place in (u, λ).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    pub u: Vec<f64>,
    pub parameter: f64,
}

impl Place {
    /// This place moved by a length along a direction.
    pub fn moved(&self, direction: &Direction, length: f64) -> Self {
        let u = self.u.iter().zip(&direction.u).map(|(u, d)| u + length * d).collect();
        Place { u, parameter: self.parameter + length * direction.parameter }
    }

    /// The way from another place to this one.
    pub fn since(&self, other: &Place) -> Direction {
        let u = self.u.iter().zip(&other.u).map(|(u, v)| u - v).collect();
        Direction { u, parameter: self.parameter - other.parameter }
    }
}

/// A solution, with what its tangent says.
#[derive(Clone, Debug)]
pub(super) struct Reached {
    pub at: Place,
    /// R(u, λ) on all unknowns: reactions where values are prescribed.
    pub residual: Vec<f64>,
    /// The branch's direction, of length one, forwards.
    pub direction: Direction,
    pub inertia: Inertia,
    /// Length of the branch up to here.
    pub arc_length: f64,
    /// Newton steps that led here.
    pub iterations: usize,
}

impl Reached {
    /// The sign of det K × dλ/ds, which stays along a smooth branch, and changes where an odd number of eigenvalues vanishes at a bifurcation.
    pub fn orientation(&self) -> Option<f64> {
        Some(self.inertia.determinant_sign()? * self.direction.parameter.signum())
    }
}
