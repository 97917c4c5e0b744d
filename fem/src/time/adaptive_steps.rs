//! Step sizes that follow the error of a step and the failures of Newton's method.

use super::error::{StepError, StepFailure};
use super::step::Taken;
use super::time_loop::TimeLoop;
use crate::instantiate::instantiate;

/// Steps that are halved when they fail or their error is above the tolerance, and doubled after two successes in a row whose error,
/// times eight, is below it: the error of a step goes with its third power. A halved size asks for another matrix; sizes are
/// powers of two times the largest one, so that few matrices occur.
///
/// ```no_run
/// # use forms_fem::time::{AdaptiveSteps, TimeLoop};
/// # fn with(mut motion: TimeLoop<'_, 2>) -> Result<(), Box<dyn std::error::Error>> {
/// let mut steps = AdaptiveSteps::new(0.01, 1e-6)?;
/// while motion.state().time < 1.0 {
///     let taken = steps.take(&mut motion, 1.0)?;
///     println!("{} {:?}", taken.to, taken.error);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveSteps {
    largest: f64,
    tolerance: f64,
    halvings: u32,
    successes: u32,
    rejected: usize,
}

/// Halvings after which a step fails for good: the smallest step is 2⁻²⁰ of the largest, about 10⁻⁶.
const MOST_HALVINGS: u32 = 20;

/// A part of a step that is no step of its own: a remainder this small is rounding.
const CRUMB: f64 = 1e-9;

impl AdaptiveSteps {
    /// Steps of at most `largest` \[time\] that begin with it, each with an error of at most `tolerance` \[value\] at each node, as the
    /// scheme estimates it; [`Scheme::error_factor`](super::Scheme::error_factor) says which do. Other schemes react to failed steps only. Of a coupled form the
    /// error is that of the first unknown.
    ///
    /// # Errors
    /// [`StepFailure::StepSize`], [`StepFailure::Tolerance`] for what is no positive number.
    pub fn new(largest: f64, tolerance: f64) -> Result<Self, StepFailure> {
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(StepFailure::StepSize(largest));
        }
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(StepFailure::Tolerance(tolerance));
        }
        Ok(AdaptiveSteps { largest, tolerance, halvings: 0, successes: 0, rejected: 0 })
    }

    /// The number of attempts that were given up.
    pub fn rejected(&self) -> usize {
        self.rejected
    }

    /// One step, with as many attempts as it needs, which ends at `until` at the latest.
    ///
    /// # Errors
    /// The [`StepError`] of the smallest step.
    #[inline(never)]
    pub fn take<const D: usize>(
        &mut self,
        motion: &mut TimeLoop<'_, D>,
        until: f64,
    ) -> Result<Taken<D>, StepError> {
        loop {
            let size = self.largest / 2.0_f64.powi(self.halvings as i32);
            let left = until - motion.state().time;
            let last = left <= size * (1.0 + CRUMB);
            let (size, end) = if last { (left, until) } else { (size, motion.state().time + size) };
            match motion.take_within(size, end, self.tolerance) {
                Ok(taken) => {
                    let has_room = taken.error.is_none_or(|error| 8.0 * error <= self.tolerance);
                    self.successes = if has_room { self.successes + 1 } else { 0 };
                    if self.successes >= 2 && !last {
                        (self.halvings, self.successes) = (self.halvings.saturating_sub(1), 0);
                    }
                    return Ok(taken);
                }
                Err(error) if self.halvings >= MOST_HALVINGS || !error.why.is_for_smaller_steps() => {
                    return Err(error);
                }
                Err(_) => {
                    self.rejected += 1;
                    (self.halvings, self.successes) = (self.halvings + 1, 0);
                }
            }
        }
    }
}

instantiate!(adaptive_steps: AdaptiveSteps::take::<D>);
