//! Steps of an iteration with bounds: whole ones, and those that stay between the bounds.

use super::{ActiveSet, Way};
use crate::bounds::Side;
use crate::linear_algebra::vector::{dot, norm};
use crate::solve::newton::free_equations::FreeEquations;
use crate::solve::newton::line_search::{FALL, FLAT, FORCED, Forced, HALVINGS, Taken};
use crate::solve::newton::{Change, Origin};
use crate::solve::newton::{NewtonFailure, Residuals};

/// The next iterate.
pub(in crate::solve::newton) struct Moved {
    pub u: Vec<f64>,
    pub residuals: Residuals,
    /// The part of the step that was taken.
    pub part: f64,
}

impl FreeEquations<'_> {
    /// The iterate to which a change of all unknowns leads.
    ///
    /// # Errors
    /// If assembly fails, or no part of the change serves.
    pub(in crate::solve::newton) fn move_between_bounds(
        &mut self,
        values: &[f64],
        origin: Origin,
    ) -> Result<Moved, NewtonFailure> {
        let Some(mut set) = self.bounds.take() else { return Err(NewtonFailure::NoDescent) };
        let is_step = matches!(origin, Origin::Tangent { .. });
        let limit = if is_step { self.problem.largest_step(&self.iterates.u, values)? } else { 1.0 };
        let step: Vec<f64> = values.iter().map(|value| limit * value).collect();
        set.unhindered = false;
        let moved = match set.way {
            _ if !is_step => self.whole_step(&set, &step, limit),
            Way::Whole => self.whole_step(&set, &step, limit),
            Way::Potential => self.along_potential_between(&mut set, &step),
            Way::Residual => self.along_residual_between(&set, &step),
        };
        self.bounds = Some(set);
        moved.map(|moved| Moved { part: limit * moved.part, ..moved })
    }

    /// A place on a step, with held unknowns at their bounds, where the step is taken to its end, and no unknown beyond one by rounding.
    fn place(&self, set: &ActiveSet, step: &[f64], part: f64, to_its_end: bool) -> Vec<f64> {
        let mut u: Vec<f64> = self.iterates.u.iter().zip(step).map(|(u, step)| u + part * step).collect();
        for (one, margin) in set.unknowns.iter().zip(self.margins(set)) {
            let value = &mut u[one.unknown];
            match one.held {
                Some(side) if to_its_end => *value = one.bound(side),
                _ if *value < one.lower && *value >= one.lower - margin => *value = one.lower,
                _ if *value > one.upper && *value <= one.upper + margin => *value = one.upper,
                _ => {}
            }
        }
        self.elimination.impose_relations(&mut u);
        u
    }

    /// A place on a step, moved between the bounds.
    fn place_between(&self, set: &ActiveSet, step: &[f64], part: f64) -> Vec<f64> {
        let mut u: Vec<f64> = self.iterates.u.iter().zip(step).map(|(u, step)| u + part * step).collect();
        set.project(&mut u);
        self.elimination.impose_relations(&mut u);
        u
    }

    fn whole_step(&mut self, set: &ActiveSet, step: &[f64], limit: f64) -> Result<Moved, NewtonFailure> {
        let u = self.place(set, step, 1.0, limit == 1.0);
        let residuals = Residuals::at(self.problem, &self.elimination, &u)?;
        if norm(&residuals.reduced).is_finite() {
            return Ok(Moved { u, residuals, part: 1.0 });
        }
        // Beyond the bounds there may be nothing to compute.
        let u = self.place_between(set, step, 1.0);
        let residuals = Residuals::at(self.problem, &self.elimination, &u)?;
        Ok(Moved { u, residuals, part: 1.0 })
    }

    /// The place on the projected step where the potential is lower; a step to the first bound where there is no such place.
    fn along_potential_between(&mut self, set: &mut ActiveSet, step: &[f64]) -> Result<Moved, NewtonFailure> {
        let difference =
            |u: &[f64], from: &[f64]| u.iter().zip(from).map(|(u, from)| u - from).collect::<Vec<f64>>();
        for halvings in 0..=HALVINGS {
            let part = 0.5_f64.powi(halvings);
            let u = self.place_between(set, step, part);
            let way = difference(&u, &self.iterates.u);
            let first = dot(&self.residuals.full, &way);
            if !(first < 0.0 && first.is_finite()) {
                continue;
            }
            let residuals = Residuals::at(self.problem, &self.elimination, &u)?;
            // The way is straight: on it the potential has fallen where it does not rise much at its end.
            if dot(&residuals.full, &way) <= FLAT * first.abs() {
                let (end, margins) = (self.place(set, step, 1.0, true), self.margins(set));
                let mut pairs = set.unknowns.iter().zip(margins);
                set.unhindered = halvings == 0
                    && pairs.all(|(one, margin)| (u[one.unknown] - end[one.unknown]).abs() <= margin);
                return Ok(Moved { u, residuals, part });
            }
        }
        if dot(&self.residuals.full, step) >= 0.0 {
            // A whole step that is rounding is taken: the rows judge it.
            let u = self.place_between(set, step, 1.0);
            if !self.is_rounding(step) {
                return Err(NewtonFailure::NoDescent);
            }
            set.unhindered = true;
            let residuals = Residuals::at(self.problem, &self.elimination, &u)?;
            return Ok(Moved { u, residuals, part: 1.0 });
        }
        let reach = set.distance_to_bounds(&self.iterates.u, step).min(1.0);
        let shortened: Vec<f64> = step.iter().map(|step| reach * step).collect();
        let Taken { part, .. } = self.along_potential(&shortened)?;
        let u = self.place_between(set, &shortened, part);
        let residuals = Residuals::at(self.problem, &self.elimination, &u)?;
        Ok(Moved { u, residuals, part: part * reach })
    }

    /// The place on the projected step where the norm of the residual is lower, without the rows that bounds hold there.
    fn along_residual_between(&mut self, set: &ActiveSet, step: &[f64]) -> Result<Moved, NewtonFailure> {
        let scales = self.scales(step)?;
        let before = self.iterates.merit(&self.residuals.reduced, &scales);
        let choice = self.forced_choice(before);
        let mut otherwise = None;
        for halvings in 0..=HALVINGS {
            let part = 0.5_f64.powi(halvings);
            let u = self.place_between(set, step, part);
            let residuals = Residuals::at(self.problem, &self.elimination, &u)?;
            let mut rows = residuals.reduced.clone();
            set.mask_pressed(&u, &mut rows);
            let merit = self.iterates.merit(&rows, &scales);
            let moved = Moved { u, residuals, part };
            if merit <= (1.0 - FALL * part) * before {
                return Ok(moved);
            }
            if merit.is_finite() && halvings >= FORCED[choice] && otherwise.is_none() {
                otherwise = Some(moved);
            }
        }
        self.forced = Some(Forced { before, choice });
        otherwise.ok_or(NewtonFailure::NoDescent)
    }

    /// Holds unknowns at bounds that a change would lead beyond them, along the potential; whether there was one.
    pub(in crate::solve::newton) fn hold_hindering(&mut self, change: &Change) -> bool {
        let Some(set) = &mut self.bounds else { return false };
        if set.way != Way::Potential {
            return false;
        }
        let mut found = false;
        for one in set.unknowns.iter_mut().filter(|one| one.held.is_none()) {
            let (value, step) = (self.iterates.u[one.unknown], change.values[one.unknown]);
            let side = match (value <= one.lower && step < 0.0, value >= one.upper && step > 0.0) {
                (true, _) => Side::Lower,
                (_, true) => Side::Upper,
                _ => continue,
            };
            (one.held, found) = (Some(side), true);
        }
        if found {
            self.residuals.reduced.clone_from(&set.reactions);
            set.mask(&mut self.residuals.reduced);
        }
        found
    }
}

impl ActiveSet {
    /// The part of a step from a place between the bounds to the first bound in its way; ∞ where there is none.
    fn distance_to_bounds(&self, u: &[f64], step: &[f64]) -> f64 {
        let mut reach = f64::INFINITY;
        for one in &self.unknowns {
            let (value, step) = (u[one.unknown], step[one.unknown]);
            let bound = if step < 0.0 { one.lower } else { one.upper };
            if step != 0.0 {
                reach = reach.min((bound - value) / step);
            }
        }
        reach.max(0.0)
    }

    /// Takes the rows out of a residual that bounds hold at a place between them.
    fn mask_pressed(&self, u: &[f64], rows: &mut [f64]) {
        for one in &self.unknowns {
            let (value, row) = (u[one.unknown], &mut rows[one.place]);
            if (value <= one.lower && *row > 0.0) || (value >= one.upper && *row < 0.0) {
                *row = 0.0;
            }
        }
    }
}
