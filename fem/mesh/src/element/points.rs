//! Values at the points of a rule: functions that are known nowhere else.

use super::CellShape;
use super::lagrange::ElementError;
use crate::quadrature::cell_rule;

/// One function per point of a cell's rule: 1 there and 0 at the other points.
#[derive(Clone, Debug, PartialEq)]
pub struct RulePoints {
    pub(super) shape: CellShape,
    /// Degree of the rule.
    pub(super) degree: usize,
    /// Reference coordinates; the third is zero in two dimensions.
    pub(super) points: Vec<[f64; 3]>,
}

impl RulePoints {
    pub(super) fn of(shape: CellShape, degree: usize) -> Result<Self, ElementError> {
        let refused = |_| ElementError::Rule { shape, degree };
        let points = match shape.dimension() {
            2 => cell_rule::<2>(shape, degree)
                .map_err(refused)?
                .points
                .iter()
                .map(|x| [x[0], x[1], 0.0])
                .collect(),
            _ => cell_rule::<3>(shape, degree).map_err(refused)?.points,
        };
        Ok(RulePoints { shape, degree, points })
    }

    /// The values at a point: those of the rule's, and NaN elsewhere.
    pub(super) fn values<const D: usize>(&self, point: &[f64; D], value: &mut [f64]) {
        let found = self.points.iter().position(|x| (0..D).all(|k| x[k] == point[k]));
        let outside = if found.is_some() { 0.0 } else { f64::NAN };
        value.fill(outside);
        if let Some(value) = found.and_then(|place| value.get_mut(place)) {
            *value = 1.0;
        }
    }
}
