//! Steps of a history, forward and back, from which a sweep makes the gradient of its criterion.

use std::sync::Arc;

use super::controls::Controls;
use super::error::HistoryError;
use crate::space::Space;

/// A row of steps from a state to the next, with a criterion J = Σ Jⁿ, n = 0, 1, …, over them.
pub trait Evolution {
    /// Error of a step.
    type Error;

    /// The number of steps.
    fn steps(&self) -> usize;

    /// The number of controls: the length of the gradient.
    fn control_count(&self) -> usize;

    /// The state before the first step.
    ///
    /// # Errors
    /// Data that do not fit.
    fn start(&mut self) -> Result<Vec<f64>, Self::Error>;

    /// The state after a step.
    ///
    /// # Errors
    /// Equations that were not solved.
    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// Jⁿ, the part of the criterion that a step adds \[J\].
    ///
    /// # Errors
    /// Data that do not fit.
    fn cost(&mut self, step: usize, before: &[f64], after: &[f64]) -> Result<f64, Self::Error>;

    /// From the slope of J, except for this step's part, by the state after a step: the slope by the state before it. What the
    /// step's controls change is added to the gradient.
    ///
    /// # Errors
    /// An adjoint system that was not solved.
    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, Self::Error>;

    /// The end of the way back: the first state, and the slope by it, for controls of that state.
    ///
    /// # Errors
    /// An adjoint system that was not solved.
    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), Self::Error>;

    /// Which switches of the step's equations are on, per quadrature point: where they change, J has a kink. None without kinks.
    ///
    /// # Errors
    /// Data that do not fit.
    fn switches(
        &mut self,
        _step: usize,
        _before: &[f64],
        _after: &[f64],
    ) -> Result<Option<Vec<u32>>, Self::Error> {
        Ok(None)
    }
}

/// An evolution of states on a space, of controls by name.
pub trait ControlledEvolution<const D: usize>: Evolution<Error = HistoryError> {
    /// The controls with their last values.
    fn controls(&self) -> &Controls<D>;

    /// The spaces of the unknowns, whose states follow one after the other.
    fn spaces(&self) -> Vec<&Arc<Space<D>>>;

    /// Takes controls, before steps are asked for.
    ///
    /// # Errors
    /// Controls or data that do not fit.
    fn begin(&mut self, m: &[f64]) -> Result<(), HistoryError>;

    /// Whether anything adds to its criterion.
    fn has_criterion(&self) -> bool;

    /// The most states that are to be stored.
    fn most_stored(&self) -> usize;
}
