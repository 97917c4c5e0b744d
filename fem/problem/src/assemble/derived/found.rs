//! Values of a derived field as they are found: one list for all points.

use super::PointValues;
use crate::assemble::AssemblyError;

/// Values at points that follow each other, without a list for each of them.
#[derive(Debug, Default)]
pub(crate) struct Found<const D: usize> {
    /// Components of the value.
    pub components: usize,
    /// Position of each point.
    pub positions: Vec<[f64; D]>,
    /// Weight of each point.
    pub weights: Vec<f64>,
    /// Components at each point, one point after the other.
    pub values: Vec<f64>,
}

impl<const D: usize> Found<D> {
    /// One more point.
    ///
    /// # Errors
    /// A value that is not finite, of the function of this name.
    pub fn add(
        &mut self,
        form: &'static str,
        value: &[f64],
        weight: f64,
        position: &[f64; D],
    ) -> Result<(), AssemblyError> {
        if !value.iter().all(|entry| entry.is_finite()) {
            return Err(AssemblyError::ValueNotFinite { form, position: position.to_vec() });
        }
        self.positions.push(*position);
        self.weights.push(weight);
        self.values.extend_from_slice(value);
        Ok(())
    }

    /// Further points.
    pub fn append(&mut self, mut other: Self) {
        self.positions.append(&mut other.positions);
        self.weights.append(&mut other.weights);
        self.values.append(&mut other.values);
    }

    /// The value at a point.
    pub fn value(&self, point: usize) -> &[f64] {
        &self.values[point * self.components..(point + 1) * self.components]
    }
}

impl<const D: usize> From<Found<D>> for PointValues<D> {
    fn from(found: Found<D>) -> Self {
        let values = (0..found.weights.len()).map(|point| found.value(point).to_vec()).collect();
        PointValues { positions: found.positions, weights: found.weights, values }
    }
}
