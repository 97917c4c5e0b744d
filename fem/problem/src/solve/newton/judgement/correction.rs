//! Correction that is still to be expected, −K⁻¹R with the last tangent, next to the variation of the solution.

use super::{LastChange, Rows, UNIFORM, UNKNOWN_ROUNDING, ZERO_COMPONENT, ZERO_PART};
use crate::assemble::Terms;
use crate::solve::newton::convergence::{Component, Sizes};
use crate::solve::newton::{FreeEquations, NewtonFailure};

/// A correction may be this much larger, as a part of u, than a residual as a part of its terms: a fine mesh has directions that
/// are thousands of times softer than others.
const SOFTNESS: f64 = 100.0;

/// A step of this part of a component leaves the tangent about as it is.
const SHORT_STEP: f64 = 1e-3;

impl FreeEquations<'_> {
    /// Whether the last tangent is far from the one at the last iterate, because the step was long.
    pub(super) fn tangent_is_old(&self) -> bool {
        let Some(LastChange { values: step, .. }) = &self.last_change else { return true };
        let sizes = self.iterates.fields.sizes(step, &self.iterates.u);
        sizes.iter().any(|sizes| sizes.change > SHORT_STEP * sizes.most)
    }

    /// −K⁻¹R with the last tangent, on all unknowns; none where it cannot be computed.
    pub(super) fn correction(&mut self) -> Result<Option<Vec<f64>>, NewtonFailure> {
        let residual = &self.residuals.reduced;
        let load: Vec<f64> = residual.iter().map(|value| -value).collect();
        let Ok(found) = self.solver.solve(&load, 1e-2 * self.iterates.fields.norm(residual)) else {
            return Ok(None);
        };
        if !self.iterates.fields.norm(&found.solution).is_finite() {
            return Ok(None);
        }
        Ok(Some(self.elimination.extend_by_zero(&found.solution)?))
    }

    /// The components in which the correction is not small, with its size as a part of what is allowed.
    pub(super) fn unsettled(
        &mut self,
        correction: &[f64],
        rows: &mut Rows,
    ) -> Result<Vec<(Component, f64)>, NewtonFailure> {
        let tolerance = SOFTNESS * self.iterates.options.relative_tolerance;
        let mut unsettled = Vec::new();
        let sizes = self.iterates.fields.sizes(correction, &self.iterates.u);
        for (component, sizes) in self.iterates.fields.components.clone().into_iter().zip(sizes) {
            let Sizes { change, most, range, in_field } = sizes;
            // A component may be zero, and its corrections the rounding of others.
            let part = if most <= ZERO_PART * in_field { ZERO_COMPONENT } else { UNKNOWN_ROUNDING };
            let rounding = part * in_field;
            let mut allowed = (tolerance * range).max(rounding);
            if change > allowed && range <= UNIFORM * most {
                let resisted = self.resistance(&component)?;
                allowed = allowed.max(tolerance * resisted * most);
            }
            if change > allowed {
                let size = change / allowed.max(f64::MIN_POSITIVE);
                unsettled.push((component, size));
            }
        }
        if unsettled.is_empty() {
            return Ok(unsettled);
        }
        // Forces of these corrections may be rounding in all rows.
        let forces = match rows.forces.take() {
            Some(forces) => forces,
            None => self.forces()?,
        };
        let mut rest = vec![0.0; correction.len()];
        for unknown in unsettled.iter().flat_map(|(component, _)| component.unknowns()) {
            rest[unknown] = correction[unknown].abs();
        }
        let made = self.products(&rest)?.sizes;
        let negligible = |terms: &[f64]| {
            let rows = made.iter().zip(&forces).zip(terms);
            rows.into_iter().all(|((made, force), term)| *made <= UNKNOWN_ROUNDING * (force + term))
        };
        let terms = self.problem.sizes_of_terms(&self.iterates.u, Terms::OfRows)?;
        let is_rounding = negligible(terms.as_deref().unwrap_or(&forces));
        let is_rounding = self.iterates.fields.together.all(is_rounding);
        rows.forces = Some(forces);
        Ok(if is_rounding { vec![] } else { unsettled })
    }

    /// The part, from 0 to 1, of a uniform value of a component that every row resists: 0 for a stress, 1 for a mass. Where all
    /// rows do, the value itself is a scale, and not its variation only.
    fn resistance(&mut self, component: &Component) -> Result<f64, NewtonFailure> {
        let mut uniform = vec![0.0; self.iterates.u.len()];
        component.unknowns().for_each(|unknown| uniform[unknown] = 1.0);
        let found = self.products(&uniform)?;
        let part = |unknown: usize| match found.sizes[unknown] {
            0.0 => 1.0,
            size => found.sums[unknown].abs() / size,
        };
        Ok(self.iterates.fields.together.smallest(component.unknowns().map(part).fold(1.0, f64::min)))
    }
}
