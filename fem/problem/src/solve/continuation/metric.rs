//! Length along a branch: fields and the parameter, each relative to its change in the first step.

use super::family::Direction;
use crate::solve::FieldUnknowns;

/// ds² = Σ_f ‖du_f‖² / ‖U_f‖² + dλ² / Λ², with the changes U_f and Λ of a first step. Units cancel, and meshes count alike.
#[derive(Clone, Debug)]
pub(super) struct Metric {
    /// One weight per unknown.
    weights: Vec<f64>,
    /// Λ, the size of the parameter's changes.
    pub parameter: f64,
}

/// A field whose first change is below this part of the largest one's does not change.
const NOTHING: f64 = 1e-12;

impl Metric {
    /// The length of changes of the parameter.
    pub fn of_parameter(unknowns: usize, parameter: f64) -> Self {
        Metric { weights: vec![0.0; unknowns], parameter: parameter.abs() }
    }

    /// The length in which each field of a change has length one. A field that does not change has no length.
    pub fn of_change(fields: &[FieldUnknowns], change: &[f64], parameter: f64) -> Self {
        let mut weights = vec![0.0; change.len()];
        let mut ranges = vec![];
        let mut begin = 0;
        for field in fields {
            let end = change.len().min(begin + field.unknowns);
            ranges.push(begin..end);
            begin = end;
        }
        ranges.push(begin..change.len());
        let square = |range: &std::ops::Range<usize>| {
            change[range.clone()].iter().map(|value| value * value).sum::<f64>()
        };
        let most = ranges.iter().map(square).fold(0.0, f64::max);
        for range in ranges {
            let square = square(&range);
            if square > NOTHING * NOTHING * most {
                weights[range].fill(1.0 / square);
            }
        }
        Metric { weights, parameter: parameter.abs() }
    }

    /// The inner product of two directions.
    pub fn inner(&self, a: &Direction, b: &Direction) -> f64 {
        let fields = self.weights.iter().zip(a.u.iter().zip(&b.u)).map(|(weight, (a, b))| weight * a * b);
        fields.sum::<f64>() + a.parameter * b.parameter / self.parameter.powi(2)
    }

    /// The length of a direction.
    pub fn length(&self, direction: &Direction) -> f64 {
        self.inner(direction, direction).sqrt()
    }

    /// A direction with length one; none of one without length.
    pub fn unit(&self, mut direction: Direction) -> Option<Direction> {
        let length = self.length(&direction);
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        direction.u.iter_mut().for_each(|value| *value /= length);
        direction.parameter /= length;
        Some(direction)
    }

    /// The derivative of ⟨direction, ·⟩ by the unknowns, and by λ/Λ.
    pub fn row(&self, direction: &Direction) -> (Vec<f64>, f64) {
        let fields = self.weights.iter().zip(&direction.u).map(|(weight, value)| weight * value);
        (fields.collect(), direction.parameter / self.parameter)
    }
}
