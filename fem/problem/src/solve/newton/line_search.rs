//! Steps that are shortened: along a potential, or by the residual.
//!
//! Where the residual is the gradient of a potential Π, the slope of Π along a step δ is R(u + αδ)·δ, so that the
//! potential itself need not be known. Other residuals are judged by their norm, each field's relative to what its rows are made of:
//! a residual that is rounding of its terms does not count, whatever it was before. The norm may have to rise on the way to a solution, where
//! a law switches: if no step lowers it, a short one is taken.

use super::{FreeEquations, Iterates, NewtonFailure, Residuals};
use crate::linear_algebra::BlockMatrix;
use crate::solve::elimination::Elimination;

/// Whether Newton's method shortens its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineSearch {
    /// Full steps.
    #[default]
    Off,
    /// A step is shortened where the potential rises again before its end: to a place where the slope along the step
    /// is at most a half, in amount, of that at its beginning. For residuals with a potential only: symmetric tangents.
    OnPotential,
    /// A step is halved, down to 1/64, until the residual's norm falls by at least 10⁻⁴ of the part that is taken; if it
    /// does not, an eighth of the step is taken, or another part if that led back to where it was taken. For every residual: it serves where whole steps go back and forth between
    /// the branches of a law, as they do with friction. With several fields each one's norm is divided by the norm of
    /// Σ_j |K_ij| (|u_j| + |δ_j|) over its rows i, so that neither units nor residuals that were small before matter.
    OnResidual,
    /// As [`OnResidual`](LineSearch::OnResidual), but a whole step may raise the norm, if one of the next three whole steps lowers it below the value before. If none
    /// does, the iteration goes back to that place and shortens the step from there (the watchdog technique of Chamberlain, Powell, Lemaréchal
    /// and Pedersen 1982). It takes fewer steps where flat surfaces meet at many points at once: the forces that appear there are large until the
    /// tangent knows them. Where contact grows from a point it takes more. With bounds on unknowns it is `OnResidual`.
    Watchdog,
}

/// The part of a step that is taken, and the residual there if it is known.
pub(super) struct Taken {
    pub part: f64,
    pub residuals: Option<Residuals>,
    /// The place from which it is taken, and the step, where these are not the last iterate and the last step.
    pub elsewhere: Option<(Vec<f64>, Vec<f64>)>,
}

impl Taken {
    /// All of it.
    pub fn whole() -> Self {
        Taken::some(1.0)
    }

    fn some(part: f64) -> Self {
        Taken { part, residuals: None, elsewhere: None }
    }
}

/// Along a part α of a step the residual's norm must fall by this times α.
pub(super) const FALL: f64 = 1e-4;

/// Most halvings of a step.
pub(super) const HALVINGS: i32 = 6;

/// Halvings of the step that is taken where no part lowers the residual's norm: the first, and the others in turn where
/// the one before led back to a residual as large as that from which it was taken.
pub(super) const FORCED: [i32; 5] = [3, 2, 4, 1, 5];

/// A residual's norm that is not smaller than another by this part is not smaller.
const SAME: f64 = 1e-6;

/// The slope at an accepted place is at most this part of the first, in amount.
pub(super) const FLAT: f64 = 0.5;

/// A tangent with a larger asymmetry has no potential.
pub(super) const SYMMETRIC: f64 = 1e-9;

/// Most evaluations along a step: bisection reaches 10⁻⁹ of it.
const EVALUATIONS: usize = 30;

/// A step from a place, the residual's norm there, and the scales of the norm.
pub(super) struct Way<'v> {
    pub u: &'v [f64],
    pub step: &'v [f64],
    pub before: f64,
    pub scales: &'v [f64],
}

impl Way<'_> {
    /// The largest norm that is a fall, after a part of the step.
    pub fn allowed(&self, part: f64) -> f64 {
        (1.0 - FALL * part) * self.before
    }
}

/// The last step that was taken although the residual rose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forced {
    /// The residual's norm before it.
    pub before: f64,
    /// Which of [`FORCED`] it was.
    pub choice: usize,
}

impl Iterates<'_> {
    /// The norm of residuals on free unknowns, each field's relative to its scale. A field without a scale does not count.
    pub(super) fn merit(&self, reduced: &[f64], scales: &[f64]) -> f64 {
        let residuals = self.fields.norms(reduced);
        let parts = residuals.iter().zip(scales).filter(|(_, scale)| **scale > 0.0);
        parts.map(|(residual, scale)| residual / scale).fold(0.0, f64::hypot)
    }
}

/// An error if a line search is on the potential, and the reduced tangent is not symmetric.
pub(super) fn check_potential(
    line_search: LineSearch,
    elimination: &mut Elimination,
    tangent: &BlockMatrix,
) -> Result<(), NewtonFailure> {
    if line_search != LineSearch::OnPotential {
        return Ok(());
    }
    let reduced = elimination.reduce_matrix(tangent)?;
    let asymmetry = reduced.asymmetry()?;
    // NaN is named by the solver.
    if asymmetry > SYMMETRIC { Err(NewtonFailure::NoPotential { asymmetry }) } else { Ok(()) }
}

impl FreeEquations<'_> {
    /// The part that is taken of the longest step along δ that the problem allows, and that step as a part of δ.
    pub(super) fn limited_step(&mut self, step: &[f64]) -> Result<(Taken, f64), NewtonFailure> {
        let limit = self.problem.largest_step(&self.iterates.u, step)?;
        if limit >= 1.0 {
            return Ok((self.part_of_step(step)?, 1.0));
        }
        let shortened: Vec<f64> = step.iter().map(|step| limit * step).collect();
        Ok((self.part_of_step(&shortened)?, limit))
    }

    /// The part of the Newton step δ, given on all unknowns, that is taken.
    pub(super) fn part_of_step(&mut self, step: &[f64]) -> Result<Taken, NewtonFailure> {
        match self.iterates.options.line_search {
            LineSearch::Off => Ok(Taken::whole()),
            LineSearch::OnPotential => self.along_potential(step),
            LineSearch::OnResidual => self.along_residual(step),
            LineSearch::Watchdog => self.under_watch(step),
        }
    }

    /// The scale of each field's residual along a step δ: the norm of Σ_j |K_ij| (|u_j| + |δ_j|) over its rows, with the last tangent. A single
    /// field needs none.
    pub(super) fn scales(&mut self, step: &[f64]) -> Result<Vec<f64>, NewtonFailure> {
        if self.iterates.norms.last().is_none_or(|last| last.residual.len() < 2) {
            return Ok(vec![1.0]);
        }
        let amounts: Vec<f64> =
            self.iterates.u.iter().zip(step).map(|(u, step)| u.abs() + step.abs()).collect();
        let sizes = self.products(&amounts)?.sizes;
        Ok(self.iterates.fields.norms(&self.elimination.reduce_amounts(&sizes)?))
    }

    /// Which of [`FORCED`] is next, where no part of a step lowers the residual's norm.
    pub(super) fn forced_choice(&self, before: f64) -> usize {
        match self.forced {
            Some(last) if before >= last.before * (1.0 - SAME) => (last.choice + 1) % FORCED.len(),
            _ => 0,
        }
    }

    /// The part of a step with which the residual's norm falls.
    fn along_residual(&mut self, step: &[f64]) -> Result<Taken, NewtonFailure> {
        let scales = self.scales(step)?;
        let before = self.iterates.merit(&self.residuals.reduced, &scales);
        let u = self.iterates.u.clone();
        self.falling_part(&Way { u: &u, step, before, scales: &scales }, 0)
    }

    /// The residual at a part of a way, and its norm.
    pub(super) fn at_part(&mut self, way: &Way<'_>, part: f64) -> Result<(Residuals, f64), NewtonFailure> {
        let at: Vec<f64> = way.u.iter().zip(way.step).map(|(u, step)| u + part * step).collect();
        let residuals = Residuals::at(self.problem, &self.elimination, &at)?;
        let merit = self.iterates.merit(&residuals.reduced, way.scales);
        Ok((residuals, merit))
    }

    /// The largest part 2⁻ᵏ of a way, from a number k of halvings on, with which the residual's norm falls.
    pub(super) fn falling_part(&mut self, way: &Way<'_>, halvings: i32) -> Result<Taken, NewtonFailure> {
        let choice = self.forced_choice(way.before);
        let mut otherwise = None;
        for halvings in halvings..=HALVINGS {
            let part = 0.5_f64.powi(halvings);
            let (residuals, merit) = self.at_part(way, part)?;
            let taken = Taken { part, residuals: Some(residuals), elsewhere: None };
            if merit <= way.allowed(part) {
                return Ok(taken);
            }
            // What is not finite is too far.
            if merit.is_finite() && halvings >= FORCED[choice] && otherwise.is_none() {
                otherwise = Some(taken);
            }
        }
        self.forced = Some(Forced { before: way.before, choice });
        otherwise.ok_or(NewtonFailure::NoDescent)
    }

    /// The part of a step with which the potential falls.
    pub(super) fn along_potential(&mut self, step: &[f64]) -> Result<Taken, NewtonFailure> {
        let (u, together) = (&self.iterates.u, &self.iterates.fields.together);
        let mut slope = |part: f64| -> Result<f64, NewtonFailure> {
            let at: Vec<f64> = u.iter().zip(step).map(|(u, step)| u + part * step).collect();
            // δ is zero where unknowns are prescribed: reactions do no work.
            Ok(together.dot(&self.problem.residual(&at)?, step))
        };
        let first = slope(0.0)?;
        // A direction of ascent is left to Newton's method, which may cross a saddle.
        if first >= 0.0 || !first.is_finite() {
            return Ok(Taken::whole());
        }
        let (mut low, mut low_slope) = (0.0, first);
        let (mut high, mut high_slope) = (1.0, slope(1.0)?);
        if high_slope <= FLAT * first.abs() {
            return Ok(Taken::whole());
        }
        for evaluation in 0..EVALUATIONS {
            // Regula falsi and bisection alternately; what is not finite is too far.
            let secant = low + (high - low) * low_slope / (low_slope - high_slope);
            let inside = secant > low && secant < high;
            let part = if evaluation % 2 == 0 && inside { secant } else { 0.5 * (low + high) };
            let found = slope(part)?;
            if found.abs() <= FLAT * first.abs() {
                return Ok(Taken::some(part));
            }
            if found < 0.0 {
                (low, low_slope) = (part, found);
            } else {
                (high, high_slope) = (part, found);
            }
        }
        if low > 0.0 { Ok(Taken::some(low)) } else { Err(NewtonFailure::NoDescent) }
    }
}
