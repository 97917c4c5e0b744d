//! A line search for residuals that are the gradient of a potential Π: the slope of Π along a step δ is R(u + αδ)·δ,
//! so that the potential itself need not be known.

use super::{NewtonFailure, NonlinearProblem};
use crate::linear_algebra::BlockMatrix;
use crate::linear_algebra::vector::dot;
use crate::solve::elimination::Elimination;

/// Whether Newton's method shortens its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineSearch {
    /// Each step is taken whole.
    #[default]
    Off,
    /// A step is shortened where the potential rises again before its end: to a place where the slope along the step
    /// is at most a half, in amount, of that at its beginning. For residuals with a potential only: symmetric tangents.
    OnPotential,
}

/// The slope at an accepted place is at most this part of the first, in amount.
const FLAT: f64 = 0.5;

/// A tangent with a larger asymmetry has no potential.
const SYMMETRIC: f64 = 1e-9;

/// Most evaluations along a step: bisection alone comes down to 10⁻⁹ of it.
const EVALUATIONS: usize = 30;

/// An error if the reduced tangent is not symmetric.
pub(super) fn check_potential<E>(
    elimination: &mut Elimination,
    tangent: &BlockMatrix,
) -> Result<(), NewtonFailure<E>> {
    let reduced = elimination.reduce_matrix(tangent).map_err(NewtonFailure::Mismatch)?;
    let asymmetry = reduced.asymmetry().map_err(NewtonFailure::Mismatch)?;
    // NaN is named by the solver.
    if asymmetry > SYMMETRIC { Err(NewtonFailure::NoPotential { asymmetry }) } else { Ok(()) }
}

/// The part of the step δ, given on all unknowns, to be taken from u.
pub(super) fn line_search<P: NonlinearProblem>(
    problem: &mut P,
    u: &[f64],
    step: &[f64],
) -> Result<f64, NewtonFailure<P::Error>> {
    let mut slope = |part: f64| -> Result<f64, NewtonFailure<P::Error>> {
        let at: Vec<f64> = u.iter().zip(step).map(|(u, step)| u + part * step).collect();
        // δ is zero where unknowns are prescribed: reactions do no work.
        Ok(dot(&problem.residual(&at).map_err(NewtonFailure::Assembly)?, step))
    };
    let first = slope(0.0)?;
    // A direction of ascent is left to Newton's method, which may cross a saddle.
    if first >= 0.0 || !first.is_finite() {
        return Ok(1.0);
    }
    let (mut low, mut low_slope) = (0.0, first);
    let (mut high, mut high_slope) = (1.0, slope(1.0)?);
    if high_slope <= FLAT * first.abs() {
        return Ok(1.0);
    }
    for evaluation in 0..EVALUATIONS {
        // Regula falsi and bisection by turns; what is not finite is too far.
        let secant = low + (high - low) * low_slope / (low_slope - high_slope);
        let inside = secant > low && secant < high;
        let part = if evaluation % 2 == 0 && inside { secant } else { 0.5 * (low + high) };
        let found = slope(part)?;
        if found.abs() <= FLAT * first.abs() {
            return Ok(part);
        }
        if found < 0.0 {
            (low, low_slope) = (part, found);
        } else {
            (high, high_slope) = (part, found);
        }
    }
    if low > 0.0 { Ok(low) } else { Err(NewtonFailure::NoDescent) }
}
