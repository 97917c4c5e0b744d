//! Newton's criterion of convergence: every equation next to the terms that it is made of, and the correction that is still to
//! be expected next to the solution.
//!
//! 1. *Rows.* |R_i| ≤ τ S_i + floor_i in every free row i. S_i is the sum of the amounts that cells and facets contribute to the
//!    row, each integral by itself. floor_i is what rounding may leave: 10³ε (|K| |u|)_i (Arioli, Demmel and Duff 1989), and the same
//!    small multiple of what was computed inside of cells.
//! 2. *Correction.* The simplified Newton correction δ = −K⁻¹R, with the last tangent (after a switch, with the iterate's own), is at most 100 τ of the variation of each
//!    component of u. It is an error in the unit of u (Deuflhard 2011), so that a row whose large terms cancel, or a direction in which
//!    the body is soft, cannot hide one.
//!
//! Neither depends on the start, nor on how far the residual has dropped. An iterate that meets the first and not the second is
//! corrected by δ. Where corrections stay, they are what rounding makes of the solution, which is then the best that can be
//! computed: it is accepted up to 10⁻⁶ of u, and refused beyond. Points that switched with the last step may switch back with such a
//! correction, which is made first then.

mod correction;
mod refinement;
mod rounding;
mod rows;
mod vanishing;

use super::{FreeEquations, NewtonFailure, Origin, Verdict};
use crate::linear_algebra::vector::largest;
use refinement::Reason;
pub(super) use refinement::{LastChange, Refinement};
use rows::{Follows, Rows};

/// Rounding of a row, as a part of (|K| |u|)_i: the constant of Arioli, Demmel and Duff.
const ROW_ROUNDING: f64 = 1e3 * f64::EPSILON;

/// A correction below this part of the unknowns themselves is as good as their rounding.
const UNKNOWN_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Largest effect of rounding on a component of the solution, as a part of its largest value.
const LARGEST_ROUNDING: f64 = 1e-6;

/// A norm below this may be zero although no entry is, or the other way round: squares of smaller numbers underflow.
const UNDERFLOW: f64 = 1e-150;

/// A component that varies by less than this part of itself is uniform.
const UNIFORM: f64 = 1e-9;

/// A component of this part of its field may be zero: corrections of this size that do not become shorter are rounding of the others.
const ZERO_COMPONENT: f64 = 1e-12;

/// A component below this part of its field counts as zero.
const ZERO_PART: f64 = 1e-10;

/// Corrections that stay this often are rounding: once with the last tangent, and once with a new one.
const TRIES: usize = 2;

impl FreeEquations<'_> {
    /// Whether the last iterate is the solution, or what to do.
    ///
    /// # Errors
    /// If there is no sense in going on.
    pub(super) fn judge_last(&mut self) -> Result<Verdict, NewtonFailure> {
        let total = self.iterates.history.last().map_or(f64::NAN, |last| last.residual);
        if !total.is_finite() {
            return Err(NewtonFailure::NotFinite);
        }
        if total <= self.iterates.options.absolute_tolerance
            || total < UNDERFLOW
                && self.iterates.fields.together.largest(largest(&self.residuals.reduced)) == 0.0
            || self.iterates.all_fields_vanished()
        {
            return Ok(Verdict::Solution);
        }
        let progress = match self.last_change {
            Some(LastChange { origin: Origin::Judgement, .. }) => self.iterates.check_iterations(),
            // The watchdog ends what does not lead on.
            _ if self.watchdog.is_watching() => self.iterates.check_iterations(),
            _ => self.iterates.check_progress(),
        };
        let is_first = self.iterates.history.len() == 1;
        if is_first || !(progress.is_err() || self.iterates.is_worth_judging()) {
            return progress.map(|()| Verdict::GoOn);
        }
        // A tangent from before a switch is not that of the equations after it.
        if self.iterates.switched() {
            self.set_tangent()?;
        } else {
            self.products_are_old = self.tangent_is_old();
        }
        let follows = if progress.is_ok() { Follows::Step } else { Follows::End };
        let mut rows = self.judge_rows(follows)?;
        let is_corrected = rows.hold || self.iterates.some_field_stays() || self.some_component_vanishes();
        let correction = if is_corrected { self.correction()? } else { None };
        // If the tangent cannot be solved with, the next step reports it.
        match correction {
            None => progress.map(|()| Verdict::GoOn),
            Some(correction) if rows.hold => self.judge_correction(progress, &mut rows, correction),
            Some(correction) => self.judge_without_rows(progress, &mut rows, &correction),
        }
    }

    /// Judges an iterate some of whose rows do not hold by its correction.
    fn judge_without_rows(
        &mut self,
        progress: Result<(), NewtonFailure>,
        rows: &mut Rows,
        correction: &[f64],
    ) -> Result<Verdict, NewtonFailure> {
        let stagnates = matches!(progress, Err(NewtonFailure::Stagnated));
        if (stagnates || self.iterates.stays()) && self.is_small_everywhere(correction)? {
            if !self.iterates.switched() || self.is_rounding(correction) {
                return Ok(Verdict::Solution);
            }
            // The correction is a step of Newton's method, and may switch points back.
            if self.refinement.allows(Reason::Switch) {
                self.refinement.enter(Reason::Switch);
                return Ok(Verdict::Correct(correction.to_vec()));
            }
        }
        match self.without_vanishing_components(correction, rows)? {
            Some(change) => Ok(Verdict::Correct(change)),
            None => progress.map(|()| Verdict::GoOn),
        }
    }

    /// Judges an iterate whose rows hold by its correction.
    fn judge_correction(
        &mut self,
        progress: Result<(), NewtonFailure>,
        rows: &mut Rows,
        correction: Vec<f64>,
    ) -> Result<Verdict, NewtonFailure> {
        let reason = Reason::ToleranceBelowRounding;
        if self.iterates.options.relative_tolerance < ROW_ROUNDING && self.refinement.allows(reason) {
            self.refinement.enter(reason);
            return Ok(Verdict::Correct(correction));
        }
        if rows.after_long_step && self.refinement.allows(Reason::LongStep) {
            self.refinement.enter(Reason::LongStep);
            progress?;
            return Ok(Verdict::Correct(correction));
        }
        let unsettled = self.unsettled(&correction, rows)?;
        if unsettled.is_empty() {
            return Ok(Verdict::Solution);
        }
        if let Some(change) = self.without_vanishing_components(&correction, rows)? {
            return Ok(Verdict::Correct(change));
        }
        let stalls = self.refinement.stalls(unsettled.iter().map(|(_, size)| *size).fold(0.0, f64::max));
        let ends = progress.is_err();
        if (ends || stalls >= TRIES) && !matches!(progress, Err(NewtonFailure::NotConverged { .. })) {
            match self.judge_rounding(&unsettled, &correction)? {
                None => return Ok(Verdict::Solution),
                Some(part) if ends => return Err(NewtonFailure::Uncertain { part }),
                Some(_) => {}
            }
        }
        progress?;
        if stalls > 0 {
            return Ok(Verdict::GoOn); // perhaps another tangent makes it shorter
        }
        Ok(Verdict::Correct(correction))
    }
}
