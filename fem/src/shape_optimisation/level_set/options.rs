//! Options of a descent on a level set function.

use serde::{Deserialize, Serialize};

use super::holes::HoleOptions;
use crate::shape_optimisation::ShapeOptimisationError;

/// Options of a descent on φ. φ is about a distance: its values are lengths in the mesh's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelSetOptions {
    /// Steps, at most.
    pub iterations: usize,
    /// α of the inner product (w, v) + α²(∇w, ∇v) \[length\].
    pub smoothing: f64,
    /// ℓ of α² ℓ ∫_Γ ∇_Γ w·∇_Γ v, which the inner product gets on the present interface \[length\]: waves of Γ that are shorter than ℓ move less.
    /// The second derivative of a price of the perimeter is of this kind: without it a descent with such a price takes short steps. None
    /// where it is zero.
    #[serde(default)]
    pub interface_smoothing: f64,
    /// The largest change of φ at a node in a step, on the descent and on the way back to the constraint \[length\].
    pub largest_change: f64,
    /// The part of the decrease that the derivative promises which a step must bring, in (0, 1/2).
    pub sufficient_decrease: f64,
    /// r of the augmented Lagrangian, in units of the criterion at the start.
    pub penalty: f64,
    /// |constraint| up to which a shape may be called optimal.
    pub constraint_tolerance: f64,
    /// The norm of the derivative along the constraint, relative to the first, at which the descent has converged.
    pub gradient_tolerance: f64,
    /// |∇φ| on cut cells outside of this range makes φ a distance again.
    pub slopes: [f64; 2],
    /// New holes; none unless they are asked for.
    #[serde(default)]
    pub holes: Option<HoleOptions>,
}

impl LevelSetOptions {
    /// For cells of this size \[length\]: α = 2h, no smoothing along Γ, changes of φ up to h/2.
    pub fn new(size: f64) -> Self {
        LevelSetOptions {
            iterations: 100,
            smoothing: 2.0 * size,
            interface_smoothing: 0.0,
            largest_change: 0.5 * size,
            sufficient_decrease: 1e-4,
            penalty: 10.0,
            constraint_tolerance: 1e-3,
            gradient_tolerance: 1e-3,
            slopes: [0.5, 2.0],
            holes: None,
        }
    }

    pub(super) fn check(&self) -> Result<(), ShapeOptimisationError> {
        let fail = |name, value, why| Err(ShapeOptimisationError::Option { name, value, why });
        let positive = [
            ("smoothing", self.smoothing),
            ("largest_change", self.largest_change),
            ("penalty", self.penalty),
            ("slopes", self.slopes[0]),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return fail(name, value, "it must be positive");
            }
        }
        if self.slopes[0].partial_cmp(&self.slopes[1]) != Some(std::cmp::Ordering::Less) {
            return fail("slopes", self.slopes[1], "it must be above the lower limit");
        }
        if !(self.sufficient_decrease > 0.0 && self.sufficient_decrease < 0.5) {
            return fail("sufficient_decrease", self.sufficient_decrease, "it lies between 0 and 1/2");
        }
        for (name, value) in [
            ("interface_smoothing", self.interface_smoothing),
            ("constraint_tolerance", self.constraint_tolerance),
            ("gradient_tolerance", self.gradient_tolerance),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return fail(name, value, "it must not be negative");
            }
        }
        Ok(())
    }
}
