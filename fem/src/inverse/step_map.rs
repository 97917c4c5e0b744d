//! A step of a motion between rows of states, forward and back: the formulas of a scheme as linear maps of rows.
//!
//! A row is the data between two steps: value, rate and second rate of as many states as the schemes read, newest first, zero where
//! there are none yet; after them the lumped masses, where there are such, the same in all rows. Each of these parts has the coefficients
//! of all unknowns, one after the other.

use std::ops::Range;
use std::sync::Arc;

use super::error::HistoryFailure;
use super::step_equations::Solution;
use crate::field::{Field, fields_on};
use crate::linear_algebra::vector::add_scaled;
use crate::space::Space;
use crate::time::{Combination, Formulas, SolvedFor, State, Step};

/// One time step: its formulas and the times at its ends.
pub(super) struct StepMap {
    pub solution: Solution,
    /// Of each unknown.
    pub formulas: Vec<Formulas>,
    pub solved_for: SolvedFor,
    /// Time before the step, and at its end.
    pub times: [f64; 2],
    /// The number of coefficients of each unknown.
    pub counts: Vec<usize>,
    /// The states in a row.
    pub states: usize,
}

/// The formulas by which the second rate of the first state is found: it is the unknown, with known value and rate. Where schemes read no
/// second rates the form does not see it.
pub(super) fn of_start(reads_second_rates: bool) -> Formulas {
    let all = |weight| {
        [
            Combination::new(0.0, [1.0, 0.0, 0.0]),
            Combination::new(0.0, [0.0, 1.0, 0.0]),
            Combination::new(weight, [0.0; 3]),
        ]
    };
    Formulas { evaluated: all(f64::from(u8::from(reads_second_rates))), end: all(1.0), load_at: 0.0 }
}

/// Whether a combination is the unknown and nothing else.
fn is_the_unknown(combination: &Combination) -> bool {
    combination.unknown == 1.0 && !reads_states(combination)
}

/// Whether a combination reads states before the step.
pub(super) fn reads_states(combination: &Combination) -> bool {
    combination.states.iter().flatten().any(|weight| *weight != 0.0)
}

impl StepMap {
    /// The number of the step whose controls hold.
    pub fn step(&self) -> usize {
        match self.solution {
            Solution::Start => 0,
            Solution::Step(step) => step,
        }
    }

    /// Whether it is a step whose value is known before its unknown.
    pub fn is_explicit_step(&self) -> bool {
        self.solved_for == SolvedFor::SecondRate && self.solution != Solution::Start
    }

    /// The number of coefficients of all unknowns.
    pub fn count(&self) -> usize {
        self.counts.iter().sum()
    }

    /// The places of an unknown's coefficients in a part of a row.
    pub fn block(&self, unknown: usize) -> Range<usize> {
        let from = self.counts[..unknown].iter().sum();
        from..from + self.counts[unknown]
    }

    /// The part of combinations, one of each unknown, that the states of a row give.
    fn known(&self, of: impl Fn(&Formulas) -> &Combination, row: &[f64]) -> Vec<f64> {
        let count = self.count();
        let mut sum = vec![0.0; count];
        for (unknown, formulas) in self.formulas.iter().enumerate() {
            let block = self.block(unknown);
            let weights = of(formulas).states.iter().flatten().zip(row.chunks(count));
            weights.filter(|(weight, _)| **weight != 0.0).for_each(|(weight, part)| {
                add_scaled(&mut sum[block.clone()], *weight, &part[block.clone()]);
            });
        }
        sum
    }

    /// The slope by a combination of an unknown, added to that by the row whose states it reads.
    pub fn add_slope(&self, unknown: usize, combination: &Combination, slope: &[f64], by_row: &mut [f64]) {
        let block = self.block(unknown);
        let weights = combination.states.iter().flatten().zip(by_row.chunks_mut(self.count()));
        weights.filter(|(weight, _)| **weight != 0.0).for_each(|(weight, part)| {
            add_scaled(&mut part[block.clone()], *weight, slope);
        });
    }

    /// The slopes by what the operators evaluate of each unknown, value, rate and second rate, added to that by the row.
    pub fn add_slopes_by_evaluated(&self, slopes: &[[Vec<f64>; 3]], by_row: &mut [f64]) {
        for (unknown, slopes) in slopes.iter().enumerate() {
            for (combination, slope) in self.formulas[unknown].evaluated.iter().zip(slopes) {
                self.add_slope(unknown, combination, slope, by_row);
            }
        }
    }

    /// The step as a form reads it, of each unknown, from the row before.
    ///
    /// # Errors
    /// Values that do not fit the spaces.
    pub fn steps_from<const D: usize>(
        &self,
        spaces: &[&Arc<Space<D>>],
        before: &[f64],
    ) -> Result<Vec<Step<D>>, HistoryFailure> {
        let ([from, end], count) = (self.times, self.count());
        let known = [0, 1, 2].map(|which| self.known(|formulas| &formulas.evaluated[which], before));
        let step = |(unknown, formulas): (usize, &Formulas)| {
            let block = self.block(unknown);
            let field = |part: &[f64]| Field::from_values(spaces[unknown], part[block.clone()].to_vec());
            let before = |which: usize| field(&before[which * count..]);
            Ok(Step {
                before: State { time: from, value: before(0)?, rate: before(1)?, second_rate: before(2)? },
                end,
                time: from + formulas.load_at * (end - from),
                weights: formulas.evaluated.each_ref().map(|combination| combination.unknown),
                known: [field(&known[0])?, field(&known[1])?, field(&known[2])?],
            })
        };
        self.formulas.iter().enumerate().map(step).collect()
    }

    /// The row at the end of the step.
    pub fn end_of(&self, before: &[f64], unknown: &[f64]) -> Vec<f64> {
        let mut after = Vec::with_capacity(before.len());
        for which in 0..3 {
            let mut part = self.known(|formulas| &formulas.end[which], before);
            for (place, formulas) in self.formulas.iter().enumerate() {
                let block = self.block(place);
                add_scaled(&mut part[block.clone()], formulas.end[which].unknown, &unknown[block]);
            }
            after.extend(part);
        }
        let [own, all] = [3, 3 * self.states].map(|parts| parts * self.count());
        match self.solution {
            Solution::Start => after.extend(&before[own..all]),
            Solution::Step(_) => after.extend(&before[..all - own]),
        }
        after.extend(&before[all..]);
        after
    }

    /// The slope by the row before, with the step's unknown kept fixed, from that by the row at its end.
    pub fn slope_before(&self, slope: &[f64]) -> Vec<f64> {
        let mut by_before = vec![0.0; slope.len()];
        for (unknown, formulas) in self.formulas.iter().enumerate() {
            for (combination, slope) in formulas.end.iter().zip(slope.chunks(self.count())) {
                self.add_slope(unknown, combination, &slope[self.block(unknown)], &mut by_before);
            }
        }
        let [own, all] = [3, 3 * self.states].map(|parts| parts * self.count());
        let carried = match self.solution {
            Solution::Start => &mut by_before[own..all],
            Solution::Step(_) => &mut by_before[..all - own],
        };
        add_scaled(carried, 1.0, &slope[own..all]);
        add_scaled(&mut by_before[all..], 1.0, &slope[all..]);
        by_before
    }

    /// The step's unknowns from the rows at its ends: each from that of value, rate and second rate which is the unknown, or else from the
    /// first that contains it.
    ///
    /// # Errors
    /// Values that do not fit the spaces.
    pub fn unknowns_of<const D: usize>(
        &self,
        spaces: &[&Arc<Space<D>>],
        before: &[f64],
        after: &[f64],
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let count = self.count();
        let mut unknowns = vec![0.0; count];
        for (unknown, formulas) in self.formulas.iter().enumerate() {
            let (end, block) = (&formulas.end, self.block(unknown));
            let only = end.iter().position(is_the_unknown);
            let which = only.or_else(|| end.iter().position(|part| part.unknown != 0.0)).unwrap_or(0);
            let known = self.known(|formulas| &formulas.end[which], before);
            let own = &mut unknowns[block.clone()];
            own.copy_from_slice(&after[which * count..][block.clone()]);
            add_scaled(own, -1.0, &known[block]);
            own.iter_mut().for_each(|value| *value /= end[which].unknown);
        }
        Ok(fields_on(spaces, &unknowns)?)
    }

    /// The slope by the step's unknowns from that by the row at its end.
    pub fn slope_by_unknowns(&self, slope: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.count()];
        for (unknown, formulas) in self.formulas.iter().enumerate() {
            let block = self.block(unknown);
            for (combination, slope) in formulas.end.iter().zip(slope.chunks(self.count())) {
                add_scaled(&mut sum[block.clone()], combination.unknown, &slope[block.clone()]);
            }
        }
        sum
    }

    /// The lumped masses of a row with which the step is solved.
    pub fn masses<'r>(&self, row: &'r [f64]) -> Option<&'r [f64]> {
        let masses = &row[3 * self.states * self.count()..];
        (self.solved_for == SolvedFor::SecondRate && !masses.is_empty()).then_some(masses)
    }
}
