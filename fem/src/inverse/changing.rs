//! Histories with the changes of their states along a direction of the controls: the sweep of second order.

use super::controls::Controls;
use super::error::HistoryError;
use super::evolution::Evolution;

/// An evolution that is linearised along a direction of its controls. States are pairs, a state with its change after it, and so
/// are slopes; the second half of the gradient is the change of the first.
pub(super) trait Linearised<const D: usize>: Evolution<Error = HistoryError> {
    /// The first state with its change.
    fn start_along(&mut self, along: &Controls<D>) -> Result<Vec<f64>, HistoryError>;

    /// The pair after a step.
    fn advance_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryError>;

    /// The slopes by the pair before a step from those by the pair after it.
    fn reverse_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        pairs: [&[f64]; 2],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError>;

    /// The derivatives by the controls of the start, told at the end.
    fn reverse_start_along(
        &mut self,
        along: &Controls<D>,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError>;
}

/// A history of pairs.
pub(super) struct Changing<'h, H, const D: usize> {
    pub history: &'h mut H,
    pub along: Controls<D>,
}

/// The first and the second half of a pair.
pub(super) fn halves(pair: &[f64]) -> (&[f64], &[f64]) {
    pair.split_at(pair.len() / 2)
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
        self.history.start_along(&self.along)
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        self.history.advance_along(&self.along, step, before)
    }

    fn cost(&mut self, step: usize, before: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        self.history.cost(step, halves(before).0, halves(after).0)
    }

    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        self.history.reverse_along(&self.along, step, [before, after], &slope, gradient)
    }

    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        self.history.reverse_start_along(&self.along, start, slope, gradient)
    }
}
