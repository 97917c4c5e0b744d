//! Rows of an iterate: each equation next to the terms that it is made of.

use super::ROW_ROUNDING;
use crate::assemble::Terms;
use crate::solve::newton::{FreeEquations, NewtonFailure, WorstEquation};

/// Rounding of what is summed at the quadrature points of a cell, as a part of the largest entry of its vector.
pub(super) const CELL_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Rounding of the unknowns that the last step leaves, as a part of its length: u + δ is rounded, and δ was.
const STEP_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A row that is off by this many times what the iterate before was allowed does not hold: its terms would have to have grown as much in one
/// step.
const FAR: f64 = 1e4;

/// Rows of an iterate.
pub(super) struct Rows {
    pub hold: bool,
    /// They hold only because the last step was long, whose rounding the unknowns have.
    pub after_long_step: bool,
    /// (|K| |u|)_i of all rows, once they were asked for.
    pub forces: Option<Vec<f64>>,
}

/// Consequence of rows that do not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Follows {
    /// A further step.
    Step,
    /// The end, with the worst row in the report.
    End,
}

impl FreeEquations<'_> {
    /// Judges the free rows: by the sizes of their terms where residuals have dropped, otherwise first by the rounding of (|K| |u|)_i, whose
    /// tangent the next step reads too. Where a step follows anyway, rows that are far off need no terms of their own.
    pub(super) fn judge_rows(&mut self, follows: Follows) -> Result<Rows, NewtonFailure> {
        self.worst = None;
        if follows == Follows::Step && self.is_far_off() {
            // Of two iterates in a row one is judged by its own terms.
            self.allowed_before.clear();
            return Ok(Rows { hold: false, after_long_step: false, forces: None });
        }
        let (tolerance, together) =
            (self.iterates.options.relative_tolerance, self.iterates.fields.together.clone());
        let (mut terms, mut most) = (None, f64::INFINITY);
        if self.iterates.has_dropped_to(tolerance)
            && let Some(sizes) = self.problem.sizes_of_terms(&self.iterates.u, Terms::OfRows)?
        {
            most = together.sum(sizes.iter().sum());
            let sizes = self.elimination.reduce_amounts(&sizes)?;
            let mut rows = self.residuals.reduced.iter().zip(&sizes);
            if together.all(rows.all(|(r, size)| r.abs() <= tolerance * size)) {
                return Ok(Rows { hold: true, after_long_step: false, forces: None });
            }
            terms = Some(sizes);
        }
        let forces = self.forces()?;
        let residual = &self.residuals.reduced;
        let reduce = |full: &[f64]| self.elimination.reduce_amounts(full);
        let mut allowed: Vec<f64> = reduce(&forces)?.iter().map(|force| ROW_ROUNDING * force).collect();
        let holds = |allowed: &[f64]| {
            together.all(residual.iter().zip(allowed).all(|(r, allowed)| r.abs() <= *allowed))
        };
        if holds(&allowed) {
            return Ok(Rows { hold: true, after_long_step: false, forces: Some(forces) });
        }
        let add = |allowed: &mut [f64], part: f64, sizes: &[f64]| {
            allowed.iter_mut().zip(sizes).for_each(|(allowed, size)| *allowed += part * size);
        };
        let terms = match terms {
            Some(terms) => terms,
            // A problem that does not know its terms has its forces.
            None => {
                let terms = self.problem.sizes_of_terms(&self.iterates.u, Terms::OfRows)?;
                most = together.sum(terms.iter().flatten().sum());
                reduce(terms.as_ref().unwrap_or(&forces))?
            }
        };
        add(&mut allowed, tolerance, &terms);
        // The largest entry of a cell's vector is among the terms of a row: no row's cells have more than all rows have terms.
        let most_of_cells = reduce(&vec![CELL_ROUNDING * most; forces.len()])?;
        let at_most: Vec<f64> =
            allowed.iter().zip(most_of_cells).map(|(allowed, cells)| allowed + cells).collect();
        if !holds(&allowed)
            && holds(&at_most)
            && let Some(cells) = self.problem.sizes_of_terms(&self.iterates.u, Terms::OfCells)?
        {
            add(&mut allowed, CELL_ROUNDING, &reduce(&cells)?);
        }
        let mut after_long_step = false;
        self.allowed_before.clone_from(&allowed);
        if !holds(&allowed)
            && let Some(step) = &self.last_change
        {
            after_long_step = true;
            let moved: Vec<f64> = step.values.iter().map(|step| step.abs()).collect();
            let moved = self.problem.products(&self.iterates.u, &moved)?.sizes;
            add(&mut allowed, STEP_ROUNDING, &reduce(&moved)?);
        }
        let hold = holds(&allowed);
        if !hold {
            // The row that is off by the most of its terms.
            let off = |place: usize| {
                let scale = terms[place].max(allowed[place] / tolerance);
                if residual[place] == 0.0 { 0.0 } else { residual[place].abs() / scale }
            };
            let failing = (0..residual.len()).filter(|place| residual[*place].abs() > allowed[*place]);
            let worst = failing.max_by(|a, b| off(*a).total_cmp(&off(*b)));
            self.worst =
                worst.map(|place| WorstEquation { unknown: self.elimination.free()[place], off: off(place) });
        }
        Ok(Rows { hold, after_long_step, forces: Some(forces) })
    }

    /// Whether some row is far off, by what the iterate before was allowed.
    fn is_far_off(&self) -> bool {
        let (residual, allowed) = (&self.residuals.reduced, &self.allowed_before);
        let is_far = residual.len() == allowed.len()
            && residual.iter().zip(allowed).any(|(r, allowed)| r.abs() > FAR * allowed);
        self.iterates.fields.together.any(is_far)
    }

    /// (|K| |u|)_i of all rows.
    pub(in crate::solve::newton) fn forces(&mut self) -> Result<Vec<f64>, NewtonFailure> {
        let amounts = self.iterates.u.iter().map(|u| u.abs()).collect::<Vec<_>>();
        Ok(self.products(&amounts)?.sizes)
    }
}
