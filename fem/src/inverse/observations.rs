//! Observations: measured values at points or nodes, and how far a state is from them.

use std::sync::Arc;

use crate::compiled_here::compiled_here;
use crate::element::MAXIMUM_NODES;
use crate::field::{Field, FieldError};
use crate::space::Space;

/// Σ f (u_c(x) − d)² over measured values d of components c of a state at points x, each with a factor f.
#[derive(Clone, Debug)]
pub struct Observations<const D: usize> {
    space: Arc<Space<D>>,
    readings: Vec<Reading>,
}

/// One measured value.
#[derive(Clone, Debug)]
struct Reading {
    /// Unknowns of the state, each with its part in what is measured.
    of: Vec<(usize, f64)>,
    measured: f64,
    factor: f64,
}

impl Reading {
    fn difference(&self, state: &[f64]) -> f64 {
        self.of.iter().map(|(unknown, part)| part * state[*unknown]).sum::<f64>() - self.measured
    }
}

impl<const D: usize> Observations<D> {
    /// Nothing measured yet, of states on a space.
    pub fn new(space: &Arc<Space<D>>) -> Self {
        Observations { space: Arc::clone(space), readings: vec![] }
    }

    /// All components measured at a point.
    ///
    /// # Errors
    /// [`FieldError::Outside`], [`FieldError::OnFacets`], [`FieldError::Length`] for another number of values than of components.
    pub fn at_point(mut self, point: &[f64; D], measured: &[f64], factor: f64) -> Result<Self, FieldError> {
        let components = self.space.components();
        if measured.len() != components {
            return Err(FieldError::Length { unknowns: components, length: measured.len() });
        }
        if let Some(region) = self.space.facet_region() {
            return Err(FieldError::OnFacets { region: region.to_owned() });
        }
        let found = self.space.locator().find(point);
        let (cell, reference) = found.ok_or_else(|| FieldError::Outside { point: point.to_vec() })?;
        let (mut values, mut slopes) = ([0.0; MAXIMUM_NODES], [[0.0; D]; MAXIMUM_NODES]);
        self.space.cell_element(cell).evaluate(&reference, &mut values, &mut slopes);
        for (component, &measured) in measured.iter().enumerate() {
            let nodes = self.space.cell_nodes(cell).iter().zip(values);
            let of = nodes.map(|(node, part)| (*node as usize * components + component, part)).collect();
            self.readings.push(Reading { of, measured, factor });
        }
        Ok(self)
    }

    /// All components measured at all nodes, as the coefficients of a field.
    ///
    /// # Errors
    /// [`FieldError::Length`] for a field of another number of coefficients.
    pub fn at_nodes(mut self, measured: &Field<D>, factor: f64) -> Result<Self, FieldError> {
        let (unknowns, values) = (self.space.unknowns(), measured.values());
        if values.len() != unknowns {
            return Err(FieldError::Length { unknowns, length: values.len() });
        }
        let readings = values.iter().enumerate();
        self.readings.extend(readings.map(|(unknown, &measured)| Reading {
            of: vec![(unknown, 1.0)],
            measured,
            factor,
        }));
        Ok(self)
    }

    /// Whether they are of states on a space.
    pub(super) fn fit(&self, space: &Arc<Space<D>>) -> bool {
        self.space.numbers_as(space)
    }

    /// The sum at a state.
    #[inline(never)]
    pub(super) fn value(&self, state: &[f64]) -> f64 {
        self.readings.iter().map(|reading| reading.factor * reading.difference(state).powi(2)).sum()
    }

    /// Adds its slope by the state.
    #[inline(never)]
    pub(super) fn add_slope(&self, state: &[f64], slope: &mut [f64]) {
        for reading in &self.readings {
            let rate = 2.0 * reading.factor * reading.difference(state);
            reading.of.iter().for_each(|(unknown, part)| slope[*unknown] += rate * part);
        }
    }

    /// Adds its second derivative along a change of the state.
    #[inline(never)]
    pub(super) fn add_curvature(&self, change: &[f64], curvature: &mut [f64]) {
        for reading in &self.readings {
            let moved: f64 = reading.of.iter().map(|(unknown, part)| part * change[*unknown]).sum();
            let rate = 2.0 * reading.factor * moved;
            reading.of.iter().for_each(|(unknown, part)| curvature[*unknown] += rate * part);
        }
    }
}

compiled_here!(Observations::<D>::value, Observations::<D>::add_slope, Observations::<D>::add_curvature);
