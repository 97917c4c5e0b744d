//! Components that are zero but for rounding.

use super::{LastChange, ROW_ROUNDING, Reason, Rows};
use crate::linear_algebra::vector::largest;
use crate::solve::newton::{FreeEquations, Iterates, NewtonFailure};

/// A step that leaves this part of a component has led to zero, or it is rounding that is left.
const NOTHING_LEFT: f64 = 1e-3;

/// A component is taken for zero where its correction takes away all but this part of it.
pub(super) const LEFT_OVER: f64 = 0.1;

/// The residual of an equation without a component that is zero, as a part of what it was with the rounding of that component.
const VANISHED: f64 = 1e-3;

/// A field of this part of the largest that it was is zero.
const VANISHED_FIELD: f64 = 1e-100;

impl Iterates<'_> {
    /// Whether each field is zero next to the largest that it was: where a solution is zero, iterates may come to it by a constant factor
    /// in each step, and no iterate has another scale.
    pub(super) fn all_fields_vanished(&self) -> bool {
        let [_, .., last] = &self.norms[..] else { return false };
        (0..last.u.len()).all(|field| {
            let most = self.norms.iter().map(|norms| norms.u[field]).fold(0.0, f64::max);
            // Exactly zero may be a place that it came by.
            last.u[field] > 0.0 && last.u[field] <= VANISHED_FIELD * most
        })
    }
}

impl FreeEquations<'_> {
    /// Whether the last step led a component to zero, but for rounding.
    pub(super) fn some_component_vanishes(&self) -> bool {
        let Some(LastChange { values: step, .. }) = &self.last_change else { return false };
        let sizes = self.iterates.fields.sizes(step, &self.iterates.u);
        sizes.iter().any(|sizes| sizes.most > 0.0 && sizes.most <= NOTHING_LEFT * sizes.change)
    }

    /// A change that makes those components zero that are rounding only. None if there is none, or it was tried before.
    pub(super) fn without_vanishing_components(
        &mut self,
        correction: &[f64],
        rows: &mut Rows,
    ) -> Result<Option<Vec<f64>>, NewtonFailure> {
        if !self.refinement.allows(Reason::VanishingComponents) {
            return Ok(None);
        }
        let mut zeroed = self.iterates.u.clone();
        let mut vanishing = vec![false; zeroed.len()];
        let sizes = self.iterates.fields.sizes(correction, &self.iterates.u);
        for (component, sizes) in self.iterates.fields.components.iter().zip(sizes) {
            if sizes.most > 0.0 && sizes.change >= LEFT_OVER * sizes.most {
                for unknown in component.unknowns() {
                    (zeroed[unknown], vanishing[unknown]) = (0.0, true);
                }
            }
        }
        self.elimination.impose(&mut zeroed)?;
        let change: Vec<f64> = zeroed.iter().zip(&self.iterates.u).map(|(zeroed, u)| zeroed - u).collect();
        if self.iterates.fields.together.largest(largest(&change)) == 0.0 {
            return Ok(None);
        }
        let forces = match rows.forces.take() {
            Some(forces) => forces,
            None => self.forces()?,
        };
        let is_rounding = self.is_rounding_in_shared_rows(&vanishing, &forces)?;
        rows.forces = Some(forces);
        if !(is_rounding || self.is_corrected_to_zero(&vanishing, correction)?) {
            return Ok(None);
        }
        self.refinement.enter(Reason::VanishingComponents);
        Ok(Some(change))
    }

    /// Whether the forces of some unknowns are rounding in all rows that others enter, and there is such a row. The multiplier
    /// of a contact that is open is one, and the velocity of a fluid at rest under a pressure.
    fn is_rounding_in_shared_rows(
        &mut self,
        unknowns: &[bool],
        forces: &[f64],
    ) -> Result<bool, NewtonFailure> {
        let amounts = |own: bool| -> Vec<f64> {
            let of = |(u, is_own): (&f64, &bool)| if *is_own == own { u.abs() } else { 0.0 };
            self.iterates.u.iter().zip(unknowns).map(of).collect()
        };
        let (own, others) = (amounts(true), amounts(false));
        let (own, others) = (self.products(&own)?.sizes, self.products(&others)?.sizes);
        let mut shared = own.iter().zip(&others).zip(forces).filter(|((_, others), _)| **others > 0.0);
        let enters = own.iter().zip(&others).any(|(own, others)| *own > 0.0 && *others > 0.0);
        let are_rounding = shared.all(|((own, _), force)| *own <= ROW_ROUNDING * force);
        let together = &self.iterates.fields.together;
        Ok(together.any(enters) && together.all(are_rounding))
    }

    /// Whether the correction takes some unknowns away, and their equations hold without them.
    fn is_corrected_to_zero(&mut self, unknowns: &[bool], correction: &[f64]) -> Result<bool, NewtonFailure> {
        let mut zeroed = self.iterates.u.clone();
        for component in &self.iterates.fields.components {
            let left =
                component.unknowns().map(|unknown| (self.iterates.u[unknown] + correction[unknown]).abs());
            let is_own = unknowns[component.first()];
            if is_own {
                let left = self.iterates.fields.together.largest(left.fold(0.0, f64::max));
                if left > LEFT_OVER * component.largest(&self.iterates.u) {
                    return Ok(false);
                }
            }
            if is_own {
                component.unknowns().for_each(|unknown| zeroed[unknown] = 0.0);
            }
        }
        self.elimination.impose(&mut zeroed)?;
        let of = |full: Vec<f64>| -> Result<f64, NewtonFailure> {
            let reduced = self.elimination.reduce(&full)?;
            let own = self.elimination.free().iter().zip(reduced).filter(|(unknown, _)| unknowns[**unknown]);
            let most = own.fold(0.0, |most, (_, value)| f64::max(most, value.abs()));
            Ok(self.iterates.fields.together.largest(most))
        };
        let now = of(self.problem.residual(&self.iterates.u)?)?;
        let without = of(self.problem.residual(&zeroed)?)?;
        Ok(without <= VANISHED * now)
    }
}
