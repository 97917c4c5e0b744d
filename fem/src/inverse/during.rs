//! A step of a motion as its form reads it, and the formulas of its unknown.

use std::cell::Cell;
use std::sync::Arc;

use super::controls::{At, ControlError};
use super::error::HistoryFailure;
use super::step_equations::Solution;
use crate::field::Field;
use crate::linear_algebra::vector::add_scaled;
use crate::space::Space;
use crate::time::operators::{scalar, vector};
use crate::time::step::known;
use crate::time::{Combination, Formulas, State, Step};

/// Data of a form of motion in a step: `during.into()` is the `Data` of the operators of [`time`](crate::time).
#[derive(Clone, Copy, Debug)]
pub struct During<'a, const D: usize> {
    pub(super) step: &'a Step<D>,
    pub(super) at: At<'a, D>,
    /// Whether the state before was asked for.
    pub(super) before_is_read: &'a Cell<bool>,
}

impl<const D: usize> During<'_, D> {
    /// The time for which loads are to be given.
    pub fn time(&self) -> f64 {
        self.step.time
    }

    /// The value before the step, which a form takes as a `State` beside what the operators of [`time`](crate::time) give, as the
    /// schemes of impact do. Its rates then have a test function `by_before`, of the derivative by it.
    pub fn before(&self) -> &Field<D> {
        self.before_is_read.set(true);
        &self.step.before.value
    }

    /// The value of a number in this step.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn number(&self, name: &str) -> Result<f64, ControlError> {
        self.at.number(name)
    }

    /// The field of a control.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn field(&self, name: &str) -> Result<Field<D>, ControlError> {
        self.at.field(name)
    }
}

impl<const D: usize> From<&During<'_, D>> for vector::Data<D> {
    fn from(during: &During<'_, D>) -> Self {
        during.step.into()
    }
}

impl<const D: usize> From<&During<'_, D>> for scalar::Data<D> {
    fn from(during: &During<'_, D>) -> Self {
        during.step.into()
    }
}

/// The formulas by which the second rate of the first state is found: it is the unknown, beside known value and rate.
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

/// Adds to the slope by a state, as a row of value, rate and second rate, that by a combination in which it stands.
pub(super) fn add_slope(combination: &Combination, slope: &[f64], by_state: &mut [f64]) {
    let weights = combination.states.first().into_iter().flatten();
    for (weight, part) in weights.zip(by_state.chunks_mut(slope.len())) {
        add_scaled(part, *weight, slope);
    }
}

/// A step's formulas, and what they are between.
pub(super) struct Interval<'f> {
    pub solution: Solution,
    pub formulas: &'f Formulas,
    pub from: f64,
    pub to: f64,
}

impl<'f> Interval<'f> {
    /// The start at time zero, with the formulas [`of_start`].
    pub fn at_start(formulas: &'f Formulas) -> Self {
        Interval { solution: Solution::Start, formulas, from: 0.0, to: 0.0 }
    }

    /// The number of the step whose controls hold.
    pub fn step(&self) -> usize {
        match self.solution {
            Solution::Start => 0,
            Solution::Step(step) => step,
        }
    }

    /// The step as a form reads it, from a state given as a row of value, rate and second rate.
    pub fn step_from<const D: usize>(
        &self,
        space: &Arc<Space<D>>,
        before: &[f64],
    ) -> Result<Step<D>, HistoryFailure> {
        let count = space.unknowns();
        let part = |k: usize| Field::from_values(space, before[k * count..(k + 1) * count].to_vec());
        let states = [State { time: self.from, value: part(0)?, rate: part(1)?, second_rate: part(2)? }];
        let [value, rate, second_rate] = &self.formulas.evaluated;
        let known = [known(value, &states)?, known(rate, &states)?, known(second_rate, &states)?];
        let [before] = states;
        Ok(Step {
            end: self.to,
            time: self.from + self.formulas.load_at * (self.to - self.from),
            weights: self.formulas.evaluated.each_ref().map(|combination| combination.unknown),
            known,
            before,
        })
    }

    /// The row of value, rate and second rate at the end of the step.
    pub fn end_of<const D: usize>(
        &self,
        before: &State<D>,
        unknown: &Field<D>,
    ) -> Result<Vec<f64>, HistoryFailure> {
        let mut after = vec![];
        for combination in &self.formulas.end {
            let mut part = known(combination, std::slice::from_ref(before))?.values().to_vec();
            add_scaled(&mut part, combination.unknown, unknown.values());
            after.extend(part);
        }
        Ok(after)
    }

    /// The step's unknown from the row at its end: from the first of value, rate and second rate of which it is a part.
    pub fn unknown_of<const D: usize>(
        &self,
        before: &State<D>,
        after: &[f64],
    ) -> Result<Field<D>, HistoryFailure> {
        let space = before.value.space();
        let part = self.formulas.end.iter().position(|combination| combination.unknown != 0.0).unwrap_or(0);
        let (combination, count) = (&self.formulas.end[part], space.unknowns());
        let mut unknown = after[part * count..(part + 1) * count].to_vec();
        add_scaled(&mut unknown, -1.0, known(combination, std::slice::from_ref(before))?.values());
        unknown.iter_mut().for_each(|value| *value /= combination.unknown);
        Ok(Field::from_values(space, unknown)?)
    }

    /// The slope by the step's unknown from that by the row at its end.
    pub fn slope_by_unknown(&self, slope: &[f64]) -> Vec<f64> {
        let count = slope.len() / 3;
        let mut sum = vec![0.0; count];
        for (combination, slope) in self.formulas.end.iter().zip(slope.chunks(count)) {
            add_scaled(&mut sum, combination.unknown, slope);
        }
        sum
    }
}
