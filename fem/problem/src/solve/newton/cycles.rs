//! Iterations that repeat themselves, and those that are lost in rounding.

use super::Iterates;
use super::convergence::SMALL_STEP;
use super::report::NewtonFailure;
use crate::linear_algebra::vector::norm;

/// Residuals whose norms agree to this part are the same.
const SAME: f64 = 1e-10;

/// Steps that become shorter by less than this factor in one iteration do not lead anywhere.
const SHRINKING: f64 = 0.9;

/// The same of residuals with the same active set.
const SAME_WITH_ITS_SET: f64 = 1e-6;

/// Iterates are at the same place if they differ by less than this part of their size.
const SAME_PLACE: f64 = 1e-8;

/// Number of iterations in a row that must leave the residual as it is, if iterates are new ones.
const STAYS: usize = 4;

/// The longest cycle that is looked for.
const LONGEST: usize = 16;

/// Iterates that come back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cycle {
    /// The iterate that was reached again.
    pub first: usize,
    /// Steps in between.
    pub period: usize,
}

impl Iterates<'_> {
    /// An error if there is no sense in going on from the last iterate.
    ///
    /// # Errors
    /// [`NewtonFailure::Cycling`], [`NewtonFailure::Stagnated`] or [`NewtonFailure::NotConverged`].
    pub fn check_progress(&self) -> Result<(), NewtonFailure> {
        if let Some(Cycle { first, period }) = self.cycle_of_active_sets() {
            return Err(NewtonFailure::Cycling { first, period });
        }
        if self.stagnates() {
            return Err(NewtonFailure::Stagnated);
        }
        if let Some(Cycle { first, period }) = self.cycle_of_residuals() {
            return Err(match self.last_step_is_small() {
                true => NewtonFailure::Stagnated,
                false => NewtonFailure::Cycling { first, period },
            });
        }
        self.check_iterations()
    }

    /// An error if the iterations are used up.
    ///
    /// # Errors
    /// [`NewtonFailure::NotConverged`].
    pub fn check_iterations(&self) -> Result<(), NewtonFailure> {
        let iterations = self.history.len() - 1;
        if iterations >= self.options.max_iterations {
            return Err(NewtonFailure::NotConverged { iterations });
        }
        Ok(())
    }

    /// Whether the last step was lost in rounding and the residual did not fall.
    fn stagnates(&self) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let Some(step) = &last.step else { return false };
        step.iter().zip(&last.u).all(|(step, u)| *step <= 4.0 * f64::EPSILON * u)
            && last.residual.iter().zip(&before.residual).any(|(now, before)| *now > 0.5 * before)
    }

    fn last_step_is_small(&self) -> bool {
        let Some(last) = self.norms.last() else { return false };
        let Some(step) = &last.step else { return false };
        step.iter().zip(&last.u).all(|(step, u)| *step <= SMALL_STEP * u)
    }

    /// The earlier iterate that has the active set and the residual of the last one, with other sets in between. For a
    /// piecewise linear problem the iterates then repeat for ever, if steps are whole. The set alone would not tell: a curved
    /// law may come by again on its way.
    fn cycle_of_active_sets(&self) -> Option<Cycle> {
        let last = self.history.len() - 1;
        let active = self.active[last]?;
        let first = (0..last).rev().find(|&k| {
            self.active[k] == Some(active)
                && self.active[k..last].iter().any(|&between| between != Some(active))
        })?;
        let whole = self.history[first + 1..].iter().all(|step| step.damping == Some(1.0));
        let [now, then] = [last, first].map(|k| self.history[k].residual);
        (whole && (now - then).abs() <= SAME_WITH_ITS_SET * then)
            .then_some(Cycle { first, period: last - first })
    }

    /// A run of at least two iterates that are those of the run before, in their residuals and in u; or a residual that
    /// stays with steps that do not become shorter.
    fn cycle_of_residuals(&self) -> Option<Cycle> {
        let last = self.norms.len() - 1;
        let length = |k: usize| self.history[k].step.unwrap_or(0.0);
        let same_residual = |a: usize, b: usize| {
            let pairs = self.norms[a].residual.iter().zip(&self.norms[b].residual);
            pairs.into_iter().all(|(a, b)| (a - b).abs() <= SAME * a.max(*b))
        };
        let same_place = |a: usize, b: usize| {
            let distance = (self.norms[a].mark - self.norms[b].mark).abs();
            distance <= SAME_PLACE * (length(a) + norm(&self.norms[a].u))
        };
        let repeats = |period: usize, run: usize| {
            last >= period + run - 1 && (0..run).all(|k| same_residual(last - k, last - k - period))
        };
        let returns = |period: &usize| {
            let run = (*period).max(2);
            repeats(*period, run) && (0..run).all(|k| same_place(last - k, last - k - period))
        };
        let period = (2..=LONGEST).find(returns).or_else(|| repeats(1, STAYS).then_some(1))?;
        let lasting = length(last) > SHRINKING * length(last - period);
        lasting.then_some(Cycle { first: last - period, period })
    }
}
