//! A step of a motion between rows of states, forward and back: the formulas of a scheme as linear maps of rows.
//!
//! A row is the data between two steps: value, rate and second rate of as many states as the scheme reads, newest first, zero where
//! there are none yet; after them the lumped masses, where there are such, the same in all rows.

use std::sync::Arc;

use super::error::HistoryFailure;
use super::step_equations::Solution;
use crate::field::Field;
use crate::linear_algebra::vector::add_scaled;
use crate::space::Space;
use crate::time::{Combination, Formulas, SolvedFor, State, Step};

/// One time step: its formulas and the times at its ends.
pub(super) struct StepMap {
    pub solution: Solution,
    pub formulas: Formulas,
    pub solved_for: SolvedFor,
    /// Time before the step, and at its end.
    pub times: [f64; 2],
    /// Unknowns of a field.
    pub unknowns: usize,
    /// The states in a row.
    pub states: usize,
}

/// The formulas by which the second rate of the first state is found: it is the unknown, with known value and rate.
pub(super) fn of_start() -> Formulas {
    let all = || {
        [
            Combination::new(0.0, [1.0, 0.0, 0.0]),
            Combination::new(0.0, [0.0, 1.0, 0.0]),
            Combination::new(1.0, [0.0; 3]),
        ]
    };
    Formulas { evaluated: all(), end: all(), load_at: 0.0 }
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

    /// The part of a combination that the states of a row give.
    fn known(&self, combination: &Combination, row: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.unknowns];
        let weights = combination.states.iter().flatten().zip(row.chunks(self.unknowns));
        weights.filter(|(weight, _)| **weight != 0.0).for_each(|(weight, part)| {
            add_scaled(&mut sum, *weight, part);
        });
        sum
    }

    /// The slope by a combination, added to that by the row whose states it reads.
    pub fn add_slope(&self, combination: &Combination, slope: &[f64], by_row: &mut [f64]) {
        let weights = combination.states.iter().flatten().zip(by_row.chunks_mut(self.unknowns));
        weights.filter(|(weight, _)| **weight != 0.0).for_each(|(weight, part)| {
            add_scaled(part, *weight, slope);
        });
    }

    /// The step as a form reads it, from the row before.
    ///
    /// # Errors
    /// Values that do not fit the space.
    pub fn step_from<const D: usize>(
        &self,
        space: &Arc<Space<D>>,
        before: &[f64],
    ) -> Result<Step<D>, HistoryFailure> {
        let [from, end] = self.times;
        let part =
            |k: usize| Field::from_values(space, before[k * self.unknowns..(k + 1) * self.unknowns].to_vec());
        let known =
            |which: usize| Field::from_values(space, self.known(&self.formulas.evaluated[which], before));
        Ok(Step {
            before: State { time: from, value: part(0)?, rate: part(1)?, second_rate: part(2)? },
            end,
            time: from + self.formulas.load_at * (end - from),
            weights: self.formulas.evaluated.each_ref().map(|combination| combination.unknown),
            known: [known(0)?, known(1)?, known(2)?],
        })
    }

    /// The row at the end of the step.
    pub fn end_of(&self, before: &[f64], unknown: &[f64]) -> Vec<f64> {
        let mut after = Vec::with_capacity(before.len());
        for combination in &self.formulas.end {
            let mut part = self.known(combination, before);
            add_scaled(&mut part, combination.unknown, unknown);
            after.extend(part);
        }
        let [own, all] = [3, 3 * self.states].map(|parts| parts * self.unknowns);
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
        for (combination, slope) in self.formulas.end.iter().zip(slope.chunks(self.unknowns)) {
            self.add_slope(combination, slope, &mut by_before);
        }
        let [own, all] = [3, 3 * self.states].map(|parts| parts * self.unknowns);
        let carried = match self.solution {
            Solution::Start => &mut by_before[own..all],
            Solution::Step(_) => &mut by_before[..all - own],
        };
        add_scaled(carried, 1.0, &slope[own..all]);
        add_scaled(&mut by_before[all..], 1.0, &slope[all..]);
        by_before
    }

    /// The step's unknown from the rows at its ends: from that of value, rate and second rate which is the unknown, or else from the
    /// first that contains it.
    ///
    /// # Errors
    /// Values that do not fit the space.
    pub fn unknown_of<const D: usize>(
        &self,
        space: &Arc<Space<D>>,
        before: &[f64],
        after: &[f64],
    ) -> Result<Field<D>, HistoryFailure> {
        let end = &self.formulas.end;
        let alone = end.iter().position(is_the_unknown);
        let part = alone.or_else(|| end.iter().position(|part| part.unknown != 0.0)).unwrap_or(0);
        let mut unknown = after[part * self.unknowns..(part + 1) * self.unknowns].to_vec();
        add_scaled(&mut unknown, -1.0, &self.known(&end[part], before));
        unknown.iter_mut().for_each(|value| *value /= end[part].unknown);
        Ok(Field::from_values(space, unknown)?)
    }

    /// The slope by the step's unknown from that by the row at its end.
    pub fn slope_by_unknown(&self, slope: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.unknowns];
        for (combination, slope) in self.formulas.end.iter().zip(slope.chunks(self.unknowns)) {
            add_scaled(&mut sum, combination.unknown, slope);
        }
        sum
    }

    /// The lumped masses of a row with which the step is solved.
    pub fn masses<'r>(&self, row: &'r [f64]) -> Option<&'r [f64]> {
        let masses = &row[3 * self.states * self.unknowns..];
        (self.solved_for == SolvedFor::SecondRate && !masses.is_empty()).then_some(masses)
    }
}
