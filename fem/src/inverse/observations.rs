//! Observations: measured values at points or nodes, and how far a state is from them.

use std::sync::Arc;

use super::readings::Readings;
use crate::field::{Field, FieldError};
use crate::instantiate::instantiate;
use crate::space::Space;

/// Σ f (u_c(x) − d)² over measured values d of components c of a state at points x, each with a factor f.
#[derive(Clone, Debug)]
pub struct Observations<const D: usize> {
    readings: Readings<D>,
    /// d and f of each reading.
    measured: Vec<(f64, f64)>,
}

impl<const D: usize> Observations<D> {
    /// Empty observations of states on a space.
    pub fn new(space: &Arc<Space<D>>) -> Self {
        Observations { readings: Readings::new(space), measured: vec![] }
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

    /// The sum at a state.
    #[inline(never)]
    pub(super) fn value(&self, state: &[f64]) -> f64 {
        let read = self.readings.of(state).into_iter().zip(&self.measured);
        read.map(|(read, (measured, factor))| factor * (read - measured).powi(2)).sum()
    }

    /// Adds its slope by the state.
    #[inline(never)]
    pub(super) fn add_slope(&self, state: &[f64], slope: &mut [f64]) {
        let read = self.readings.of(state).into_iter().zip(&self.measured);
        let weights: Vec<f64> =
            read.map(|(read, (measured, factor))| 2.0 * factor * (read - measured)).collect();
        self.readings.add_slope(&weights, slope);
    }

    /// Adds its second derivative along a change of the state.
    #[inline(never)]
    pub(super) fn add_curvature(&self, change: &[f64], curvature: &mut [f64]) {
        let moved = self.readings.of(change).into_iter().zip(&self.measured);
        let weights: Vec<f64> = moved.map(|(moved, (_, factor))| 2.0 * factor * moved).collect();
        self.readings.add_slope(&weights, curvature);
    }
}

instantiate!(observations: Observations::<D>::value, Observations::<D>::add_slope, Observations::<D>::add_curvature);
