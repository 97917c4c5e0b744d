//! Observations: measured values at points or nodes, and how far a state is from them.

use std::sync::Arc;

use super::error::HistoryFailure;
use super::readings::Readings;
use crate::field::{Field, FieldError};
use crate::instantiate::instantiate;
use crate::solve::Processes;
use crate::space::Space;

/// Σ f (u_c(x) − d)² over measured values d of components c of a state at points x, each with a factor f.
#[derive(Clone, Debug)]
pub struct Observations<const D: usize> {
    readings: Readings<D>,
    /// d and f of each reading.
    measured: Vec<(f64, f64)>,
    /// Whether this process counts a reading, of each: all, unless a mesh is divided.
    counted: Vec<bool>,
}

impl<const D: usize> Observations<D> {
    /// Empty observations of states on a space.
    pub fn new(space: &Arc<Space<D>>) -> Self {
        Observations { readings: Readings::new(space), measured: vec![], counted: vec![] }
    }

    /// All components measured at a point.
    ///
    /// # Errors
    /// [`FieldError::Outside`], [`FieldError::OnFacets`], [`FieldError::Length`] for another number of values than of components.
    pub fn at_point(mut self, point: &[f64; D], measured: &[f64], factor: f64) -> Result<Self, FieldError> {
        let components = self.readings.space().components();
        if measured.len() != components {
            return Err(FieldError::Length { unknowns: components, length: measured.len() });
        }
        self.readings = self.readings.at_point(point)?;
        self.measured.extend(measured.iter().map(|measured| (*measured, factor)));
        Ok(self)
    }

    /// All components measured at all nodes, as the coefficients of a field.
    ///
    /// # Errors
    /// [`FieldError::Length`] for a field of another number of coefficients.
    pub fn at_nodes(mut self, measured: &Field<D>, factor: f64) -> Result<Self, FieldError> {
        let (unknowns, values) = (self.readings.space().unknowns(), measured.values());
        if values.len() != unknowns {
            return Err(FieldError::Length { unknowns, length: values.len() });
        }
        self.readings = self.readings.at_nodes();
        self.measured.extend(values.iter().map(|measured| (*measured, factor)));
        Ok(self)
    }

    /// Whether they are of states on a space.
    pub(super) fn fit(&self, space: &Arc<Space<D>>) -> bool {
        self.readings.fit(space)
    }

    /// Learns which readings this process counts, where processes have parts of a mesh.
    ///
    /// # Errors
    /// As [`Readings::counted`].
    pub(super) fn divide(&mut self, processes: &Processes<'_>) -> Result<(), HistoryFailure> {
        self.counted = self.readings.counted(processes)?;
        Ok(())
    }

    /// The readings of a state, each with its number, that are counted.
    fn read(&self, state: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let is_counted = |(number, _): &(usize, f64)| self.counted.get(*number).copied().unwrap_or(true);
        self.readings.of(state).into_iter().enumerate().filter(is_counted)
    }

    /// Weights of all readings from those that are counted.
    fn weights(&self, state: &[f64], weight: impl Fn(f64, (f64, f64)) -> f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.measured.len()];
        self.read(state).for_each(|(number, read)| weights[number] = weight(read, self.measured[number]));
        weights
    }

    /// The sum at a state.
    #[inline(never)]
    pub(super) fn value(&self, state: &[f64]) -> f64 {
        let square = |(number, read): (usize, f64)| {
            let (measured, factor) = self.measured[number];
            factor * (read - measured).powi(2)
        };
        self.read(state).map(square).sum()
    }

    /// Adds its slope by the state.
    #[inline(never)]
    pub(super) fn add_slope(&self, state: &[f64], slope: &mut [f64]) {
        let weights = self.weights(state, |read, (measured, factor)| 2.0 * factor * (read - measured));
        self.readings.add_slope(&weights, slope);
    }

    /// Adds its second derivative along a change of the state.
    #[inline(never)]
    pub(super) fn add_curvature(&self, change: &[f64], curvature: &mut [f64]) {
        let weights = self.weights(change, |moved, (_, factor)| 2.0 * factor * moved);
        self.readings.add_slope(&weights, curvature);
    }
}

instantiate!(observations: Observations::<D>::value, Observations::<D>::add_slope, Observations::<D>::add_curvature);
