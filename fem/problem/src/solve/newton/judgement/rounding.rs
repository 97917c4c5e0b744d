//! Corrections that do not become shorter: rounding of the solution, or more than that.

use std::collections::BTreeMap;

use super::rows::CELL_ROUNDING;
use super::vanishing::LEFT_OVER;
use super::{LARGEST_ROUNDING, ROW_ROUNDING, UNIFORM, UNKNOWN_ROUNDING, ZERO_COMPONENT, ZERO_PART};
use crate::assemble::Terms;
use crate::solve::newton::convergence::{Component, Sizes};
use crate::solve::newton::{FreeEquations, NewtonFailure};

/// Corrections of an unknown that is zero, where residuals stay, as a part of its field.
const LOCAL_ROUNDING: f64 = 1e-13;

impl FreeEquations<'_> {
    /// Whether a correction is small next to the unknowns around each one, wherever they are: then residuals are rounding that
    /// the sizes of their terms do not show, as that of a stress computed from 1 + ∇u.
    pub(super) fn is_small_everywhere(&mut self, correction: &[f64]) -> Result<bool, NewtonFailure> {
        let sizes = self.iterates.fields.sizes(correction, &self.iterates.u);
        for (component, sizes) in self.iterates.fields.components.clone().into_iter().zip(sizes) {
            let Sizes { change, range, in_field, .. } = sizes;
            // A pressure may be the same everywhere.
            let uniform = range <= UNIFORM * in_field && change <= ZERO_COMPONENT * in_field;
            if !uniform && change > UNKNOWN_ROUNDING * in_field && change > LARGEST_ROUNDING * range {
                return Ok(false);
            }
            let rounding = LOCAL_ROUNDING * in_field;
            let (mut own, mut uniform) = (vec![0.0; self.iterates.u.len()], vec![0.0; self.iterates.u.len()]);
            for unknown in component.unknowns() {
                (own[unknown], uniform[unknown]) = (self.iterates.u[unknown].abs(), 1.0);
            }
            // Mean values of |u| around an unknown, with the amounts of its row for weights.
            let sums = self.products(&own)?.sizes;
            let weights = self.products(&uniform)?.sizes;
            let small = |unknown: usize| {
                let change = correction[unknown].abs();
                change * weights[unknown] <= LARGEST_ROUNDING * sums[unknown] || change <= rounding
            };
            if !self.iterates.fields.together.all(component.unknowns().all(small)) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a correction is below the rounding of each field.
    pub(in crate::solve::newton) fn is_rounding(&self, correction: &[f64]) -> bool {
        let sizes = self.iterates.fields.sizes(correction, &self.iterates.u);
        sizes.iter().all(|sizes| sizes.change <= UNKNOWN_ROUNDING * sizes.in_field)
    }

    /// Whether each residual is below the rounding of its row, whatever the tolerance.
    fn rows_are_rounding(&mut self) -> Result<bool, NewtonFailure> {
        let mut rounding = self.forces()?;
        rounding.iter_mut().for_each(|force| *force *= ROW_ROUNDING);
        if let Some(cells) = self.problem.sizes_of_terms(&self.iterates.u, Terms::OfCells)? {
            rounding.iter_mut().zip(&cells).for_each(|(rounding, cell)| *rounding += CELL_ROUNDING * cell);
        }
        let rounding = self.elimination.reduce_amounts(&rounding)?;
        let mut rows = self.residuals.reduced.iter().zip(&rounding);
        let hold = rows.all(|(residual, rounding)| residual.abs() <= *rounding);
        Ok(self.iterates.fields.together.all(hold))
    }

    /// None if corrections that do not become shorter are rounding of the solution; otherwise their part of it.
    pub(super) fn judge_rounding(
        &mut self,
        unsettled: &[(Component, f64)],
        correction: &[f64],
    ) -> Result<Option<f64>, NewtonFailure> {
        let fields = &self.iterates.fields;
        let all =
            fields.components.iter().map(Component::first).zip(fields.sizes(correction, &self.iterates.u));
        let all: BTreeMap<usize, Sizes> = all.collect();
        let mut rest = vec![0.0; correction.len()];
        let mut part = None;
        for (component, _) in unsettled {
            let Sizes { change, most, range, in_field } = all[&component.first()];
            // An offset is no scale: next to a large one a solution may be all rounding.
            let scale = if range <= UNIFORM * most { most } else { range.min(most) };
            // Nothing of the component is left next to its corrections.
            let is_left_over = change >= LEFT_OVER * most;
            let zero = if most > ZERO_PART * in_field {
                UNKNOWN_ROUNDING
            } else if is_left_over && self.rows_are_rounding()? {
                // As across a nearly incompressible body, which the rounding of a pressure moves that is large compared with
                // the shear modulus.
                ZERO_PART
            } else {
                ZERO_COMPONENT
            };
            if change > LARGEST_ROUNDING * scale && change > zero * in_field {
                part = Some(change / most.max(f64::MIN_POSITIVE));
                let own = |unknown: usize| if is_left_over { 0.0 } else { self.iterates.u[unknown].abs() };
                component
                    .unknowns()
                    .for_each(|unknown| rest[unknown] = correction[unknown].abs().max(own(unknown)));
            }
        }
        if part.is_none() {
            return Ok(part);
        }
        // A solution that is zero, under forces that balance, has no other scale than these forces. What is left of it may be larger than
        // the corrections by chance, and has to be as small then.
        let made = self.products(&rest)?.sizes;
        let terms = self.problem.sizes_of_terms(&self.iterates.u, Terms::OfCellsByComponent)?;
        let Some(terms) = terms else { return Ok(part) };
        let negligible = made.iter().zip(&terms).all(|(made, term)| *made <= ROW_ROUNDING * term);
        let negligible = self.iterates.fields.together.all(negligible);
        Ok(part.filter(|_| !negligible))
    }
}
