//! Newton's criterion of convergence, field by field.
//!
//! A field has converged when its residual is small beside its scale, and the correction that is still to be expected is
//! small beside the field itself. The second part is what a bad start cannot spoil: from u = 10¹⁰ the residual of u³ = 1
//! begins with 10³⁰, and 10⁻¹⁰ of it is no scale for anything. It costs nothing: after a step δ that changed the norms of
//! the residuals by factors of at most ρ, the next step is about ρ δ.
//!
//! A residual cannot become smaller than the rounding of the forces that balance in it, row by row. Where the first part
//! asks for more, these forces are computed, and a residual at their rounding level counts as zero. They are products of the
//! tangent with the size of u, or, where u is small and forces are not, as in a body that was deformed for good, what cells
//! contribute.

use std::ops::Range;

use super::{Iteration, NewtonFailure, NonlinearProblem};
use crate::linear_algebra::vector::{largest, norm};
use crate::solve::elimination::Elimination;

/// Beside a field its expected correction may be this much larger than its residual beside its scale: in soft directions
/// a small residual is a large correction, and a fine mesh has directions that are thousands of times softer than others.
const SOFTNESS: f64 = 100.0;

/// A field that had less than this part of its largest residual at the start was not loaded yet: other fields drive it.
const NOT_LOADED: f64 = 1e-8;

/// A residual of at most this part of the forces that balance in its row is rounding: sums over some thirty entries of
/// products at quadrature points.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// One that does not fall any more is rounding up to this part of the forces: cancellation inside cells is not seen in
/// assembled rows.
const STALLED_ROUNDING: f64 = 1e-12;

/// A step below this part of a field leaves it as it is, so that a residual that stays is not a matter of u.
pub(super) const SMALL_STEP: f64 = 1e-6;

/// An expected correction above this part of u, at an iterate that is small beside the one before, means that u is
/// nothing but what is left of a solution that is zero.
const VANISHING: f64 = 0.1;

/// A field below this part of the largest that it was is zero; one that is exactly zero may be the rounding of a large start. Where soft and stiff directions differ by many orders the residual
/// falls faster than u, and no expected correction shows that nothing is left of it.
const ZERO: f64 = 1e-100;

/// The fields of a problem as ranges of its free unknowns.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    /// Among all unknowns.
    all: Vec<Range<usize>>,
    /// Among the free ones.
    free: Vec<Range<usize>>,
}

impl Fields {
    /// Fields of these sizes, one after the other; what is left over is one more.
    pub fn new(sizes: &[usize], elimination: &Elimination) -> Self {
        let (mut all, mut end) = (Vec::new(), 0_usize);
        for size in sizes.iter().copied().chain([elimination.size()]) {
            let begin = end;
            end = elimination.size().min(begin.saturating_add(size));
            if begin < end {
                all.push(begin..end);
            }
        }
        let place = |unknown: usize| elimination.free().partition_point(|free| *free < unknown);
        let free = all.iter().map(|range| place(range.start)..place(range.end)).collect();
        Fields { all, free }
    }

    /// Norm of each field's part of a vector of free unknowns.
    pub fn norms(&self, reduced: &[f64]) -> Vec<f64> {
        self.free.iter().map(|range| norm(&reduced[range.clone()])).collect()
    }

    /// Norms over some free unknowns alone, given by their reduced numbers in ascending order.
    pub fn norms_over(&self, places: &[u32], value: impl Fn(usize) -> f64) -> Vec<f64> {
        let within = |range: &Range<usize>| {
            let place = |end: usize| places.partition_point(|place| (*place as usize) < end);
            let values: Vec<f64> =
                places[place(range.start)..place(range.end)].iter().map(|p| value(*p as usize)).collect();
            norm(&values)
        };
        self.free.iter().map(within).collect()
    }

    /// The largest amount in each field of a vector of all unknowns, in the place of all its entries.
    fn amplitudes(&self, full: &[f64]) -> Vec<f64> {
        let mut amplitudes = vec![0.0; full.len()];
        for range in &self.all {
            amplitudes[range.clone()].fill(largest(&full[range.clone()]));
        }
        amplitudes
    }
}

/// Norms per field at an iterate, over free unknowns.
#[derive(Clone, Debug, Default)]
pub(super) struct Norms {
    pub residual: Vec<f64>,
    pub u: Vec<f64>,
    /// Of the whole Newton step that led here, before it was shortened; none at the start.
    pub step: Option<Vec<f64>>,
    /// A sum of u with weights that tell iterates apart whose norms are equal, as those of mirror images are.
    pub mark: f64,
}

/// Σ w_i u_i with w_i between ½ and 1½ that follow no pattern of a mesh.
pub(super) fn mark(u: &[f64]) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    u.iter().enumerate().map(|(i, u)| (0.5 + (GOLDEN * i as f64).fract()) * u).sum()
}

/// Whether fields count as being at rounding level.
pub(super) enum Rounding {
    /// It was not asked.
    Unknown,
    /// Of each field.
    Known(Vec<bool>),
}

impl Rounding {
    fn is_reached(&self, field: usize) -> bool {
        matches!(self, Rounding::Known(reached) if reached[field])
    }
}

impl Iteration<'_> {
    /// The residual of each field that counts as zero.
    pub fn targets(&self) -> impl Iterator<Item = f64> {
        let count = self.norms.first().map_or(0, |start| start.residual.len());
        (0..count).map(|field| self.options.relative_tolerance * self.scale(field))
    }

    /// The scale of a field's residual: the one at the start, or the largest one where other fields drive it.
    fn scale(&self, field: usize) -> f64 {
        let first = self.norms.first().map_or(0.0, |start| start.residual[field]);
        let most = self.largest_residual(field);
        if first > NOT_LOADED * most { first } else { most }
    }

    /// The largest residual that a field had.
    pub fn largest_residual(&self, field: usize) -> f64 {
        self.norms.iter().map(|norms| norms.residual[field]).fold(0.0, f64::max)
    }

    /// Whether the last iterate is the solution, with what is known of rounding.
    pub fn has_converged(&self, rounding: &Rounding) -> bool {
        let [.., last] = &self.norms[..] else { return false };
        let total = self.history.last().map_or(f64::NAN, |step| step.residual);
        if total <= self.options.absolute_tolerance {
            return true;
        }
        let small =
            |(field, target): (usize, f64)| last.residual[field] <= target || rounding.is_reached(field);
        self.targets().enumerate().all(small) && self.corrections_are_small(rounding)
    }

    /// Whether the next step, expected from the last one, is small in each field. At the start there is none.
    fn corrections_are_small(&self, rounding: &Rounding) -> bool {
        let [.., before, last] = &self.norms[..] else { return true };
        let Some(step) = &last.step else { return true };
        // Fields may drive each other: the one that fell least counts for all.
        let fall = last.residual.iter().zip(&before.residual).enumerate();
        let fall = fall.filter(|(field, (now, _))| **now > 0.0 && !rounding.is_reached(*field));
        let factor = fall.map(|(_, (now, before))| now / before).fold(0.0, f64::max);
        let tolerance = SOFTNESS * self.options.relative_tolerance;
        step.iter().zip(&last.u).zip(&before.u).enumerate().all(|(field, ((step, u), u_before))| {
            let most = self.norms.iter().map(|norms| norms.u[field]).fold(0.0, f64::max);
            if *step == 0.0 || factor == 0.0 || (*u > 0.0 && *u <= ZERO * most) {
                return true;
            }
            let expected = factor * step;
            let later = self.norms.len() > 2;
            expected <= tolerance * u
                || (later && expected >= VANISHING * u && expected <= SMALL_STEP * u_before)
        })
    }

    /// Whether it is worth while to ask whether residuals are rounding: every field has met its target, or stays as it is
    /// above it, or other fields drive it for the first time.
    pub fn may_be_rounding(&self) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        self.targets().enumerate().all(|(field, target)| {
            last.residual[field] <= target || before.residual[field] == 0.0 || self.has_stalled(field)
        })
    }

    /// Whether the last step changed neither a field nor its residual by much. Beside others a field may be zero, and its
    /// steps and its residual the rounding of theirs.
    fn has_stalled(&self, field: usize) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let small = last.step.as_ref().is_some_and(|step| step[field] <= SMALL_STEP * last.u[field]);
        (small || last.u.len() > 1) && last.residual[field] > 0.5 * before.residual[field]
    }

    /// Whether no residual above its target falls. Where u is zero its steps, rounding of forces, are not small beside it.
    pub fn does_not_fall(&self) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let mut targets = self.targets().enumerate();
        targets.all(|(field, target)| {
            last.residual[field] <= target || last.residual[field] > 0.5 * before.residual[field]
        })
    }

    /// Which fields have a residual that is rounding of the forces that balance in each of its rows: products of the
    /// tangent's entries with the size of the field in their column, or the terms that the problem adds up.
    pub fn rounding<P: NonlinearProblem>(
        &self,
        problem: &mut P,
        elimination: &Elimination,
        reduced_residual: &[f64],
    ) -> Result<Rounding, NewtonFailure<P::Error>> {
        let mut reached = vec![false; self.fields.free.len()];
        if self.may_be_rounding() {
            let amplitudes = self.fields.amplitudes(&self.u);
            let forces = problem.balancing_forces(&self.u, &amplitudes).map_err(NewtonFailure::Assembly)?;
            let forces = elimination.reduce_amounts(&forces).map_err(NewtonFailure::Mismatch)?;
            self.compare(reduced_residual, &forces, STALLED_ROUNDING, &mut reached);
        }
        if !self.has_converged(&Rounding::Known(reached.clone())) && self.does_not_fall() {
            let sizes = problem.sizes_of_terms(&self.u).map_err(NewtonFailure::Assembly)?;
            if let Some(sizes) = sizes {
                let sizes = elimination.reduce_amounts(&sizes).map_err(NewtonFailure::Mismatch)?;
                self.compare(reduced_residual, &sizes, ROUNDING, &mut reached);
            }
        }
        Ok(Rounding::Known(reached))
    }

    /// Marks the fields whose residual is rounding of forces, row by row; up to a part of them where it has stalled.
    fn compare(&self, reduced_residual: &[f64], forces: &[f64], stalled: f64, reached: &mut [bool]) {
        for (field, range) in self.fields.free.iter().enumerate() {
            let part = if self.has_stalled(field) { stalled } else { ROUNDING };
            let mut rows = reduced_residual[range.clone()].iter().zip(&forces[range.clone()]);
            reached[field] |= rows.all(|(residual, force)| residual.abs() <= part * force);
        }
    }
}
