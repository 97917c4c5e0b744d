//! Histories with the changes of their states along a direction of the controls: the sweep of second order.

use std::sync::Arc;

use super::controls::{Controls, Start};
use super::error::{HistoryError, HistoryFailure};
use super::evolution::{ControlledEvolution, Evolution};
use crate::space::Space;

/// An evolution whose criterion has a second derivative by its states.
pub(super) trait CurvedCriterion<const D: usize>: ControlledEvolution<D> {
    /// Adds slope and second derivative of a step's part of the criterion by a pair of values after the step.
    fn add_criterion(
        &self,
        step: usize,
        pair: [&[f64]; 2],
        slopes: [&mut [f64]; 2],
    ) -> Result<(), HistoryFailure>;
}

/// An evolution that is linearised along a direction of its controls. States are pairs, a state with its change after it, and so
/// are slopes; the second half of the gradient is the change of the first.
pub(super) trait Linearised<const D: usize>: CurvedCriterion<D> {
    /// The first state with its change.
    fn start_along(&mut self, along: &Controls<D>) -> Result<Vec<f64>, HistoryFailure>;

    /// The pair after a step.
    fn advance_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure>;

    /// The slopes by the pair before a step from those by the pair after it.
    fn reverse_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        pairs: [&[f64]; 2],
        slopes: [&[f64]; 2],
        gradients: [&mut [f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure>;

    /// The slopes by the parts of the first pair that are controls, from those by the whole pair.
    fn reverse_start_along(
        &mut self,
        _along: &Controls<D>,
        _start: &[f64],
        slope: &[f64],
        _gradients: [&mut [f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure> {
        Ok(slope.to_vec())
    }
}

/// A history of pairs.
pub(super) struct Changing<'h, H, const D: usize> {
    pub history: &'h mut H,
    pub along: Controls<D>,
}

/// The first and the second half of a pair.
pub(super) fn halves(pair: &[f64]) -> [&[f64]; 2] {
    pair.split_at(pair.len() / 2).into()
}

fn count_of<const D: usize>(spaces: &[&Arc<Space<D>>]) -> usize {
    spaces.iter().map(|space| space.unknowns()).sum()
}

fn halves_mut(pair: &mut [f64]) -> [&mut [f64]; 2] {
    pair.split_at_mut(pair.len() / 2).into()
}

impl<H: Linearised<D>, const D: usize> Evolution for Changing<'_, H, D> {
    type Error = HistoryError;

    fn steps(&self) -> usize {
        self.history.steps()
    }

    fn control_count(&self) -> usize {
        2 * self.history.control_count()
    }

    fn start(&mut self) -> Result<Vec<f64>, HistoryError> {
        self.history.start_along(&self.along).map_err(|why| why.at(0))
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        self.history.advance_along(&self.along, step, before).map_err(|why| why.at(step))
    }

    fn cost(&mut self, step: usize, before: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        self.history.cost(step, halves(before)[0], halves(after)[0])
    }

    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        mut slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        let count = count_of(&self.history.spaces());
        let [of_state, of_change] = halves_mut(&mut slope);
        let pair = halves(after).map(|half| &half[..count]);
        let (pairs, gradients) = ([before, after], halves_mut(gradient));
        self.history
            .add_criterion(step, pair, [&mut of_state[..count], &mut of_change[..count]])
            .and_then(|()| self.history.reverse_along(&self.along, step, pairs, halves(&slope), gradients))
            .map_err(|why| why.at(step))
    }

    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        let slope = self
            .history
            .reverse_start_along(&self.along, start, slope, halves_mut(gradient))
            .map_err(|why| why.at(0))?;
        let (controls, spaces) = (self.history.controls(), self.history.spaces());
        let count = count_of(&spaces);
        for (slope, gradient) in halves(&slope).into_iter().zip(halves_mut(gradient)) {
            controls.add_start(Start::Value, &spaces, &slope[..count], gradient);
            if let Some(by_rate) = slope.get(count..2 * count) {
                controls.add_start(Start::Rate, &spaces, by_rate, gradient);
            }
        }
        Ok(())
    }
}
