//! Newton's criterion of convergence: every equation next to the terms that it is made of, and the correction that is still to
//! be expected next to the solution.
//!
//! 1. *Rows.* |R_i| ≤ τ S_i + floor_i in every free row i. S_i is the sum of the amounts that cells and facets contribute to the
//!    row, each integral by itself. floor_i is what rounding may leave: 10³ε (|K| |u|)_i (Arioli, Demmel and Duff 1989), and the same
//!    small multiple of what was computed inside of cells.
//! 2. *Correction.* The simplified Newton correction δ = −K⁻¹R, with the last tangent, is at most 100 τ of the variation of each
//!    component of u. It is an error in the unit of u (Deuflhard 2011), so that a row whose large terms cancel, or a direction in which
//!    the body is soft, cannot hide one.
//!
//! Neither depends on the start, nor on how far the residual has dropped. An iterate that meets the first and not the second is
//! corrected by δ. Where corrections stay, they are what rounding makes of the solution, which is then the best that can be
//! computed: it is accepted up to 10⁻⁶ of u, and refused beyond.

use super::convergence::{Component, SMALL_STEP};
use super::report::WorstEquation;
use super::{Iteration, NewtonFailure, NonlinearProblem};
use crate::assemble::Terms;
use crate::linear_algebra::vector::{largest, norm};
use crate::solve::elimination::Elimination;
use crate::solve::linear_solver::LinearSolver;

/// Rounding of a row, as a part of (|K| |u|)_i: the constant of Arioli, Demmel and Duff.
const ROW_ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Rounding of what is summed at the quadrature points of a cell, as a part of the largest entry of its vector.
const CELL_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Rounding of the unknowns that the last step leaves, as a part of its length: u + δ is rounded, and δ was.
const STEP_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A correction may be this much larger, as a part of u, than a residual as a part of its terms: a fine mesh has directions that
/// are thousands of times softer than others.
const SOFTNESS: f64 = 100.0;

/// A correction below this part of the unknowns themselves is as good as their rounding.
const UNKNOWN_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Corrections that become shorter by less than this factor do not converge any more.
const SHORTER: f64 = 0.5;

/// Corrections that stay this often are rounding: once with the last tangent, and once with a new one.
const TRIES: usize = 2;

/// Largest effect of rounding on a component of the solution, as a part of its largest value.
const LARGEST_ROUNDING: f64 = 1e-6;

/// A component that varies by less than this part of itself is uniform.
const UNIFORM: f64 = 1e-9;

/// A step of this part of a component leaves the tangent about as it is.
const SHORT_STEP: f64 = 1e-3;

/// A component below this part of its field counts as zero.
const ZERO_PART: f64 = 1e-10;

/// A component of this part of its field may be zero: corrections of this size that do not become shorter are rounding of the others.
const ZERO_COMPONENT: f64 = 1e-12;

/// Corrections of an unknown that is zero, where residuals stay, as a part of its field.
const LOCAL_ROUNDING: f64 = 1e-13;

/// A step that leaves this part of a component has led to zero, or it is rounding that is left.
const NOTHING_LEFT: f64 = 1e-3;

/// Most times that components are made zero.
const ZEROINGS: usize = 3;

/// A field of this part of the largest that it was is zero.
const VANISHED_FIELD: f64 = 1e-100;

/// A component is taken for zero where its correction takes away all but this part of it.
const LEFT_OVER: f64 = 0.1;

/// The residual of an equation without a component that is zero, as a part of what it was with the rounding of that component.
const VANISHED: f64 = 1e-3;

/// The outcome of a judgement.
pub(super) enum Verdict {
    /// The last iterate is the solution.
    Solution,
    /// It is to be changed by this, on all unknowns, and judged again.
    Correct(Vec<f64>),
    /// It is not the solution.
    GoOn,
}

/// Corrections of iterates whose rows hold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corrections {
    /// The last one that was shorter than those before, as a part of what is allowed.
    least: f64,
    /// Number of those that came after it.
    tries: usize,
}

/// Rows of an iterate.
struct Rows {
    hold: bool,
    /// They hold only because the last step was long, whose rounding the unknowns have.
    after_long_step: bool,
    /// (|K| |u|)_i of all rows.
    forces: Vec<f64>,
}

impl Iteration<'_> {
    /// Whether the last iterate is the solution, or what to do.
    ///
    /// # Errors
    /// If there is no sense in going on.
    pub fn judge(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        reduced_residual: &[f64],
        solver: &mut dyn LinearSolver,
    ) -> Result<Verdict, NewtonFailure> {
        let total = self.history.last().map_or(f64::NAN, |last| last.residual);
        if !total.is_finite() {
            return Err(NewtonFailure::NotFinite);
        }
        if total <= self.options.absolute_tolerance
            || largest(reduced_residual) == 0.0
            || self.all_fields_vanished()
        {
            return Ok(Verdict::Solution);
        }
        let progress = match self.last_is_correction {
            true => self.check_iterations(),
            false => self.check_progress(),
        };
        let ends = progress.is_err();
        if self.history.len() == 1 || !(ends || self.is_worth_judging()) {
            return progress.map(|()| Verdict::GoOn);
        }
        if self.tangent_is_old() {
            problem.tangent(&self.u)?;
        }
        let rows = self.judge_rows(problem, elimination, reduced_residual)?;
        let correction = match rows.hold || self.some_field_stays() || self.some_component_vanishes() {
            true => self.correction(elimination, reduced_residual, solver)?,
            false => None,
        };
        // If the tangent cannot be solved with, the next step reports it.
        let Some(correction) = correction else { return progress.map(|()| Verdict::GoOn) };
        if !rows.hold {
            let stagnates = matches!(progress, Err(NewtonFailure::Stagnated));
            if (stagnates || self.stays()) && self.is_small_everywhere(problem, &correction)? {
                return Ok(Verdict::Solution);
            }
            let zeroed =
                self.without_vanishing_components(problem, elimination, &correction, &rows.forces)?;
            return match zeroed {
                Some(change) => Ok(Verdict::Correct(change)),
                None => progress.map(|()| Verdict::GoOn),
            };
        }
        // A tolerance below the rounding of rows asks for what one more solve can give.
        if self.options.relative_tolerance < ROW_ROUNDING && !self.polished {
            self.polished = true;
            return Ok(Verdict::Correct(correction));
        }
        if rows.after_long_step && !self.corrected_long_step {
            self.corrected_long_step = true;
            progress?;
            return Ok(Verdict::Correct(correction));
        }
        let unsettled = self.unsettled(problem, &correction, &rows.forces)?;
        if unsettled.is_empty() {
            return Ok(Verdict::Solution);
        }
        if let Some(change) =
            self.without_vanishing_components(problem, elimination, &correction, &rows.forces)?
        {
            return Ok(Verdict::Correct(change));
        }
        let size = unsettled.iter().map(|(_, size)| *size).fold(0.0, f64::max);
        let Corrections { least, tries } = match self.corrections {
            Some(Corrections { least, tries }) if size > SHORTER * least => {
                Corrections { least: least.min(size), tries: tries + 1 }
            }
            _ => Corrections { least: size, tries: 0 },
        };
        self.corrections = Some(Corrections { least, tries });
        if (ends || tries >= TRIES) && !matches!(progress, Err(NewtonFailure::NotConverged { .. })) {
            match self.judge_rounding(problem, &unsettled, &correction)? {
                None => return Ok(Verdict::Solution),
                Some(part) if ends => return Err(NewtonFailure::Uncertain { part }),
                Some(_) => {}
            }
        }
        progress?;
        if tries > 0 {
            return Ok(Verdict::GoOn); // perhaps another tangent makes it shorter
        }
        Ok(Verdict::Correct(correction))
    }

    /// Judges the free rows. Sizes of terms are computed where rounding of (|K| |u|)_i does not suffice.
    fn judge_rows(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        residual: &[f64],
    ) -> Result<Rows, NewtonFailure> {
        let reduce = |full: &[f64]| elimination.reduce_amounts(full);
        let amounts = self.u.iter().map(|u| u.abs()).collect::<Vec<_>>();
        let forces = problem.products(&self.u, &amounts)?.sizes;
        let mut allowed: Vec<f64> = reduce(&forces)?.iter().map(|force| ROW_ROUNDING * force).collect();
        let holds = |allowed: &[f64]| residual.iter().zip(allowed).all(|(r, allowed)| r.abs() <= *allowed);
        self.worst = None;
        if holds(&allowed) {
            return Ok(Rows { hold: true, after_long_step: false, forces });
        }
        let add = |allowed: &mut [f64], part: f64, sizes: &[f64]| {
            allowed.iter_mut().zip(sizes).for_each(|(allowed, size)| *allowed += part * size);
        };
        let terms = problem.sizes_of_terms(&self.u, Terms::OfRows)?;
        // A problem that does not know its terms has its forces.
        let terms = reduce(terms.as_ref().unwrap_or(&forces))?;
        add(&mut allowed, self.options.relative_tolerance, &terms);
        if !holds(&allowed)
            && let Some(cells) = problem.sizes_of_terms(&self.u, Terms::OfCells)?
        {
            add(&mut allowed, CELL_ROUNDING, &reduce(&cells)?);
        }
        let mut after_long_step = false;
        if !holds(&allowed)
            && let Some(step) = &self.last_step
        {
            after_long_step = true;
            let moved: Vec<f64> = step.iter().map(|step| step.abs()).collect();
            let moved = problem.products(&self.u, &moved)?.sizes;
            add(&mut allowed, STEP_ROUNDING, &reduce(&moved)?);
        }
        let hold = holds(&allowed);
        if !hold {
            // The row that is off by the most of its terms.
            let off = |place: usize| {
                let scale = terms[place].max(allowed[place] / self.options.relative_tolerance);
                if residual[place] == 0.0 { 0.0 } else { residual[place].abs() / scale }
            };
            let failing = (0..residual.len()).filter(|place| residual[*place].abs() > allowed[*place]);
            let worst = failing.max_by(|a, b| off(*a).total_cmp(&off(*b)));
            self.worst =
                worst.map(|place| WorstEquation { unknown: elimination.free()[place], off: off(place) });
        }
        Ok(Rows { hold, after_long_step, forces })
    }

    /// −K⁻¹R with the last tangent, on all unknowns; none where it cannot be computed.
    fn correction(
        &self,
        elimination: &Elimination,
        residual: &[f64],
        solver: &mut dyn LinearSolver,
    ) -> Result<Option<Vec<f64>>, NewtonFailure> {
        let load: Vec<f64> = residual.iter().map(|value| -value).collect();
        let Ok(found) = solver.solve(&load, 1e-2 * norm(residual)) else { return Ok(None) };
        if !norm(&found.solution).is_finite() {
            return Ok(None);
        }
        Ok(Some(elimination.extend_by_zero(&found.solution)?))
    }

    /// Whether the last tangent is far from the one at the last iterate: a switch changed, or the step was long.
    fn tangent_is_old(&self) -> bool {
        let changed = self.history.last().is_some_and(|last| last.active_set_changed == Some(true));
        let Some(step) = &self.last_step else { return true };
        let long = |component: &Component| component.largest(step) > SHORT_STEP * component.largest(&self.u);
        changed || self.fields.components.iter().any(long)
    }

    /// Whether the last step changed neither the fields nor their residuals by much.
    fn stays(&self) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let Some(step) = &last.step else { return false };
        (0..step.len()).all(|field| {
            step[field] <= SMALL_STEP * last.u[field]
                && (last.residual[field] > 0.5 * before.residual[field] || last.residual[field] == 0.0)
        })
    }

    /// Whether a correction is small next to the unknowns around each one, wherever they are: then residuals are rounding that
    /// the sizes of their terms do not show, as that of a stress computed from 1 + ∇u.
    fn is_small_everywhere(
        &self,
        problem: &mut dyn NonlinearProblem,
        correction: &[f64],
    ) -> Result<bool, NewtonFailure> {
        for component in &self.fields.components {
            let (change, range) = (component.largest(correction), component.range(&self.u));
            let in_field = component.largest_in_field(&self.u);
            // A pressure may be the same everywhere.
            let uniform = range <= UNIFORM * in_field && change <= ZERO_COMPONENT * in_field;
            if !uniform && change > UNKNOWN_ROUNDING * in_field && change > LARGEST_ROUNDING * range {
                return Ok(false);
            }
            let rounding = LOCAL_ROUNDING * in_field;
            let (mut own, mut uniform) = (vec![0.0; self.u.len()], vec![0.0; self.u.len()]);
            for unknown in component.unknowns() {
                (own[unknown], uniform[unknown]) = (self.u[unknown].abs(), 1.0);
            }
            // Mean values of |u| around an unknown, with the amounts of its row for weights.
            let sums = problem.products(&self.u, &own)?.sizes;
            let weights = problem.products(&self.u, &uniform)?.sizes;
            let small = |unknown: usize| {
                let change = correction[unknown].abs();
                change * weights[unknown] <= LARGEST_ROUNDING * sums[unknown] || change <= rounding
            };
            if !component.unknowns().all(small) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether each field is zero next to the largest that it was: where a solution is zero, iterates may come to it by a constant factor
    /// in each step, and no iterate has another scale.
    fn all_fields_vanished(&self) -> bool {
        let [_, .., last] = &self.norms[..] else { return false };
        (0..last.u.len()).all(|field| {
            let most = self.norms.iter().map(|norms| norms.u[field]).fold(0.0, f64::max);
            // Exactly zero may be a place that it came by.
            last.u[field] > 0.0 && last.u[field] <= VANISHED_FIELD * most
        })
    }

    /// Whether the last step led a component to zero, but for rounding.
    fn some_component_vanishes(&self) -> bool {
        let Some(step) = &self.last_step else { return false };
        let vanishes = |component: &Component| {
            let left = component.largest(&self.u);
            left > 0.0 && left <= NOTHING_LEFT * component.largest(step)
        };
        self.fields.components.iter().any(vanishes)
    }

    /// Whether the residual of a field stays as it is.
    fn some_field_stays(&self) -> bool {
        let count = self.norms.last().map_or(0, |last| last.residual.len());
        (0..count).any(|field| self.has_stalled(field))
    }

    /// The components in which the correction is not small, with its size as a part of what is allowed.
    fn unsettled(
        &self,
        problem: &mut dyn NonlinearProblem,
        correction: &[f64],
        forces: &[f64],
    ) -> Result<Vec<(Component, f64)>, NewtonFailure> {
        let tolerance = SOFTNESS * self.options.relative_tolerance;
        let mut unsettled = Vec::new();
        for component in &self.fields.components {
            let (change, most) = (component.largest(correction), component.largest(&self.u));
            let range = component.range(&self.u);
            // A component may be zero, and its corrections the rounding of others.
            let in_field = component.largest_in_field(&self.u);
            let part = if most <= ZERO_PART * in_field { ZERO_COMPONENT } else { UNKNOWN_ROUNDING };
            let rounding = part * in_field;
            let mut allowed = (tolerance * range).max(rounding);
            if change > allowed && range <= UNIFORM * most {
                let resisted = self.resistance(problem, component)?;
                allowed = allowed.max(tolerance * resisted * most);
            }
            if change > allowed {
                let size = change / allowed.max(f64::MIN_POSITIVE);
                unsettled.push((component.clone(), size));
            }
        }
        if unsettled.is_empty() {
            return Ok(unsettled);
        }
        // Forces of these corrections may be rounding in all rows.
        let mut rest = vec![0.0; correction.len()];
        for unknown in unsettled.iter().flat_map(|(component, _)| component.unknowns()) {
            rest[unknown] = correction[unknown].abs();
        }
        let made = problem.products(&self.u, &rest)?.sizes;
        let negligible = |terms: &[f64]| {
            let rows = made.iter().zip(forces).zip(terms);
            rows.into_iter().all(|((made, force), term)| *made <= UNKNOWN_ROUNDING * (force + term))
        };
        let terms = problem.sizes_of_terms(&self.u, Terms::OfRows)?;
        Ok(if negligible(terms.as_deref().unwrap_or(forces)) { vec![] } else { unsettled })
    }

    /// The part, from 0 to 1, of a uniform value of a component that every row resists: 0 for a stress, 1 for a mass. Where all
    /// rows do, the value itself is a scale, and not its variation only.
    fn resistance(
        &self,
        problem: &mut dyn NonlinearProblem,
        component: &Component,
    ) -> Result<f64, NewtonFailure> {
        let mut uniform = vec![0.0; self.u.len()];
        component.unknowns().for_each(|unknown| uniform[unknown] = 1.0);
        let found = problem.products(&self.u, &uniform)?;
        let part = |unknown: usize| match found.sizes[unknown] {
            0.0 => 1.0,
            size => found.sums[unknown].abs() / size,
        };
        Ok(component.unknowns().map(part).fold(1.0, f64::min))
    }

    /// A change that makes those components zero that are rounding only. None if there is none, or it was tried before.
    fn without_vanishing_components(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        correction: &[f64],
        forces: &[f64],
    ) -> Result<Option<Vec<f64>>, NewtonFailure> {
        if self.zeroings >= ZEROINGS {
            return Ok(None);
        }
        let mut zeroed = self.u.clone();
        let mut vanishing = vec![false; zeroed.len()];
        for component in &self.fields.components {
            let most = component.largest(&self.u);
            if most > 0.0 && component.largest(correction) >= LEFT_OVER * most {
                for unknown in component.unknowns() {
                    (zeroed[unknown], vanishing[unknown]) = (0.0, true);
                }
            }
        }
        elimination.impose(&mut zeroed)?;
        let change: Vec<f64> = zeroed.iter().zip(&self.u).map(|(zeroed, u)| zeroed - u).collect();
        if largest(&change) == 0.0
            || !(self.is_rounding_in_shared_rows(problem, &vanishing, forces)?
                || self.is_corrected_to_zero(problem, elimination, &vanishing, correction)?)
        {
            return Ok(None);
        }
        self.zeroings += 1;
        Ok(Some(change))
    }

    /// Whether the forces of some unknowns are rounding in all rows that others enter, and there is such a row. The multiplier
    /// of a contact that is open is one, and the velocity of a fluid at rest under a pressure.
    fn is_rounding_in_shared_rows(
        &self,
        problem: &mut dyn NonlinearProblem,
        unknowns: &[bool],
        forces: &[f64],
    ) -> Result<bool, NewtonFailure> {
        let amounts = |own: bool| -> Vec<f64> {
            let of = |(u, is_own): (&f64, &bool)| if *is_own == own { u.abs() } else { 0.0 };
            self.u.iter().zip(unknowns).map(of).collect()
        };
        let own = problem.products(&self.u, &amounts(true))?.sizes;
        let others = problem.products(&self.u, &amounts(false))?.sizes;
        let mut shared = own.iter().zip(&others).zip(forces).filter(|((_, others), _)| **others > 0.0);
        let enters = own.iter().zip(&others).any(|(own, others)| *own > 0.0 && *others > 0.0);
        Ok(enters && shared.all(|((own, _), force)| *own <= ROW_ROUNDING * force))
    }

    /// Whether the correction takes some unknowns away, and their equations hold without them.
    fn is_corrected_to_zero(
        &self,
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        unknowns: &[bool],
        correction: &[f64],
    ) -> Result<bool, NewtonFailure> {
        let mut zeroed = self.u.clone();
        for component in &self.fields.components {
            let left = component.unknowns().map(|unknown| (self.u[unknown] + correction[unknown]).abs());
            let is_own = unknowns[component.first()];
            if is_own && left.fold(0.0, f64::max) > LEFT_OVER * component.largest(&self.u) {
                return Ok(false);
            }
            if is_own {
                component.unknowns().for_each(|unknown| zeroed[unknown] = 0.0);
            }
        }
        elimination.impose(&mut zeroed)?;
        let of = |full: Vec<f64>| -> Result<f64, NewtonFailure> {
            let reduced = elimination.reduce(&full)?;
            let own = elimination.free().iter().zip(reduced).filter(|(unknown, _)| unknowns[**unknown]);
            Ok(own.fold(0.0, |most, (_, value)| f64::max(most, value.abs())))
        };
        let now = of(problem.residual(&self.u)?)?;
        let without = of(problem.residual(&zeroed)?)?;
        Ok(without <= VANISHED * now)
    }

    /// None if corrections that do not become shorter are rounding of the solution; otherwise their part of it.
    fn judge_rounding(
        &self,
        problem: &mut dyn NonlinearProblem,
        unsettled: &[(Component, f64)],
        correction: &[f64],
    ) -> Result<Option<f64>, NewtonFailure> {
        let mut rest = vec![0.0; correction.len()];
        let mut part = None;
        for (component, _) in unsettled {
            let (change, most) = (component.largest(correction), component.largest(&self.u));
            let in_field = component.largest_in_field(&self.u);
            if change > LARGEST_ROUNDING * most && change > ZERO_COMPONENT * in_field {
                part = Some(change / most.max(f64::MIN_POSITIVE));
                component.unknowns().for_each(|unknown| rest[unknown] = correction[unknown].abs());
            }
        }
        if part.is_none() {
            return Ok(None);
        }
        // A solution that is zero, under forces that balance, has no other scale than these forces.
        let made = problem.products(&self.u, &rest)?.sizes;
        let terms = problem.sizes_of_terms(&self.u, Terms::OfCellsByComponent)?;
        let Some(terms) = terms else { return Ok(part) };
        let negligible = made.iter().zip(&terms).all(|(made, term)| *made <= ROW_ROUNDING * term);
        Ok(part.filter(|_| !negligible))
    }
}
