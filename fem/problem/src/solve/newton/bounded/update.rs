//! The set of held unknowns at an iterate.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::{ActiveSet, Bounded, HeldUnknown, Visit, Way};
use crate::assemble::Terms;
use crate::bounds::Side;
use crate::linear_algebra::vector::{largest, norm};
use crate::solve::newton::convergence::mark;
use crate::solve::newton::{FreeEquations, NewtonFailure};

/// An unknown is at its bound within this part of its component's largest value.
const AT_BOUND: f64 = 64.0 * f64::EPSILON;

/// A reaction below this part of the largest residual may be rounding.
const DOUBTFUL: f64 = 1e-9;

/// Rounding of a row, as a part of (|K| |u|)_i.
const ROW_ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Along the potential, bounds are given up once the other rows are this part of the residuals that draw off.
const PROPORTION: f64 = 0.1;

impl FreeEquations<'_> {
    /// Enters the set of the last iterate, and takes its rows out of the residual.
    ///
    /// # Errors
    /// If assembly fails.
    pub(in crate::solve::newton) fn update_held(&mut self) -> Result<(), NewtonFailure> {
        let Some(mut set) = self.bounds.take() else { return Ok(()) };
        if norm(&self.residuals.reduced).is_finite() {
            let margins = self.margins(&set);
            set.reactions.clone_from(&self.residuals.reduced);
            let rounding = self.rounding_of_reactions(&set, &margins)?;
            set.update(&self.iterates.u, &margins, &rounding);
            let visit = Visit {
                set: set.fingerprint(),
                mark: mark(&self.iterates.u),
                iteration: self.iterates.history.len(),
            };
            set.visits.push(visit);
            set.mask(&mut self.residuals.reduced);
        }
        self.bounds = Some(set);
        Ok(())
    }

    /// The distance from a bound that is none, per bounded unknown.
    pub(super) fn margins(&self, set: &ActiveSet) -> Vec<f64> {
        let u = &self.iterates.u;
        let scales: Vec<f64> = self.iterates.fields.components.iter().map(|one| one.largest(u)).collect();
        set.unknowns.iter().map(|one| AT_BOUND * scales[one.component]).collect()
    }

    /// The rounding of the reactions of bounded unknowns; zeros where none is in doubt.
    fn rounding_of_reactions(&mut self, set: &ActiveSet, margins: &[f64]) -> Result<Vec<f64>, NewtonFailure> {
        let most = DOUBTFUL * largest(&self.residuals.full);
        let u = &self.iterates.u;
        let mut pairs = set.unknowns.iter().zip(margins);
        let in_doubt = pairs.any(|(one, margin)| {
            let reaction = set.reactions[one.place];
            let at_bound = one.held.is_some() || one.touched(u[one.unknown], *margin).is_some();
            at_bound && reaction != 0.0 && reaction.abs() <= most
        });
        if !in_doubt {
            return Ok(vec![0.0; set.unknowns.len()]);
        }
        let forces = self.forces()?;
        let forces = self.elimination.reduce_amounts(&forces)?;
        Ok(set.unknowns.iter().map(|one| ROW_ROUNDING * forces[one.place]).collect())
    }

    /// The unknowns at their bounds in the last iterate, ascending.
    ///
    /// # Errors
    /// If assembly fails.
    pub(in crate::solve::newton) fn unknowns_at_bounds(&mut self) -> Result<Vec<HeldUnknown>, NewtonFailure> {
        let Some(set) = self.bounds.take() else { return Ok(vec![]) };
        let terms = match self.problem.sizes_of_terms(&self.iterates.u, Terms::OfRows)? {
            Some(terms) => terms,
            None => self.forces()?,
        };
        let terms = self.elimination.reduce_amounts(&terms)?;
        let margins = self.margins(&set);
        let tolerance = self.iterates.options.relative_tolerance.max(ROW_ROUNDING);
        let mut held = Vec::new();
        for (one, margin) in set.unknowns.iter().zip(margins) {
            let reaction = set.reactions[one.place];
            if let Some(side) = one.held.or_else(|| one.touched(self.iterates.u[one.unknown], margin)) {
                let is_weak = one.lower < one.upper && reaction.abs() <= tolerance * terms[one.place];
                held.push(HeldUnknown { unknown: one.unknown, side, reaction, is_weak });
            }
        }
        self.bounds = Some(set);
        Ok(held)
    }
}

impl Bounded {
    /// The bound that a value is at or beyond.
    pub(super) fn touched(&self, value: f64, margin: f64) -> Option<Side> {
        if value <= self.lower + margin {
            Some(Side::Lower)
        } else if value >= self.upper - margin {
            Some(Side::Upper)
        } else {
            None
        }
    }

    /// The bound at which an unknown that was free is to be held.
    fn side_to_hold(&self, value: f64, margin: f64, residual: f64, rounding: f64) -> Option<Side> {
        if value < self.lower - margin || (value <= self.lower && residual > rounding) {
            Some(Side::Lower)
        } else if value > self.upper + margin || (value >= self.upper && residual < -rounding) {
            Some(Side::Upper)
        } else {
            None
        }
    }
}

impl ActiveSet {
    /// The set at an iterate, from the one before.
    fn update(&mut self, u: &[f64], margins: &[f64], rounding: &[f64]) {
        let is_drawn_off = |one: &Bounded, rounding: f64| {
            let residual = self.reactions[one.place];
            one.held.is_some_and(|side| one.is_drawn_off(side, residual) && residual.abs() > rounding)
        };
        let drawn: Vec<bool> =
            self.unknowns.iter().zip(rounding).map(|(one, rounding)| is_drawn_off(one, *rounding)).collect();
        let gives_up = self.way != Way::Potential || self.unhindered || self.others_are_settled(&drawn);
        let (mut unsettled, mut restless, mut freed) = (false, vec![], 0);
        let pairs = self.unknowns.iter_mut().zip(margins).zip(rounding).zip(&drawn);
        for (((one, margin), rounding), drawn) in pairs {
            let value = u[one.unknown];
            let held = match one.held {
                Some(_) if *drawn && gives_up => None,
                Some(side) => Some(side),
                None if one.lower == one.upper => Some(Side::Lower),
                None => one.side_to_hold(value, *margin, self.reactions[one.place], *rounding),
            };
            if held != one.held {
                restless.push(one.unknown);
                freed += usize::from(held.is_none());
            }
            unsettled |= held != one.held || (*drawn && !gives_up);
            unsettled |= held.is_some_and(|side| value != one.bound(side));
            one.held = held;
        }
        let came_back = self.peeling.enter(freed, restless.len() - freed, self.count());
        if came_back {
            // It is no cycle of single layers.
            self.visits.clear();
        }
        (self.unsettled, self.restless) = (unsettled, restless);
    }

    /// Whether the rows of free unknowns are small next to the residuals that draw held ones off their bounds.
    fn others_are_settled(&self, drawn: &[bool]) -> bool {
        let mut others = self.reactions.clone();
        self.mask(&mut others);
        let drawing: Vec<f64> = self
            .unknowns
            .iter()
            .zip(drawn)
            .filter(|(_, drawn)| **drawn)
            .map(|(one, _)| self.reactions[one.place])
            .collect();
        norm(&others) <= PROPORTION * norm(&drawing)
    }

    /// A hash of the set.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for one in &self.unknowns {
            one.held.hash(&mut hasher);
        }
        hasher.finish()
    }
}
