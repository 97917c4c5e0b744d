//! Options of a descent.

use serde::{Deserialize, Serialize};

use super::error::ShapeOptimisationError;
use super::inner_product::InnerProduct;

/// Options of a descent. Lengths are in the mesh's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DescentOptions {
    /// Steps, at most.
    pub iterations: usize,
    /// The inner product that turns derivatives into movements.
    pub inner_product: InnerProduct,
    /// The longest way of a node in the first step that is tried \[length\].
    pub first_move: f64,
    /// The longest way of a node in any step, and on the way back to the constraint \[length\].
    pub longest_move: f64,
    /// The part of the decrease that the derivative promises which a step must bring, in (0, 1/2).
    pub sufficient_decrease: f64,
    /// r of the augmented Lagrangian, in units of the criterion at the start.
    pub penalty: f64,
    /// |constraint| up to which a shape may be called optimal.
    pub constraint_tolerance: f64,
    /// The norm of the derivative along the constraint, relative to the first, at which the descent has converged.
    pub gradient_tolerance: f64,
    /// The decrease of J + λ c over five steps, relative to the criterion at the start, below which it has stalled.
    pub decrease_tolerance: f64,
    /// The mesh is smoothed when the least scaled Jacobian falls below this.
    pub smooth_below: f64,
    /// No step may let the least scaled Jacobian fall below this.
    pub least_quality: f64,
}

impl DescentOptions {
    /// For a mesh whose cells may move by so much in a step \[length\]; the elastic inner product.
    pub fn new(longest_move: f64) -> Self {
        DescentOptions {
            iterations: 100,
            inner_product: InnerProduct::elasticity(0.0),
            first_move: longest_move,
            longest_move,
            sufficient_decrease: 1e-4,
            penalty: 10.0,
            constraint_tolerance: 5e-4,
            gradient_tolerance: 1e-3,
            decrease_tolerance: 1e-6,
            smooth_below: 0.3,
            least_quality: 0.1,
        }
    }

    pub(super) fn check(&self) -> Result<(), ShapeOptimisationError> {
        let fail = |name, value, why| Err(ShapeOptimisationError::Option { name, value, why });
        let positive =
            [("first_move", self.first_move), ("longest_move", self.longest_move), ("penalty", self.penalty)];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return fail(name, value, "it must be positive");
            }
        }
        if !(self.sufficient_decrease > 0.0 && self.sufficient_decrease < 0.5) {
            return fail("sufficient_decrease", self.sufficient_decrease, "it lies between 0 and 1/2");
        }
        for (name, value) in [
            ("constraint_tolerance", self.constraint_tolerance),
            ("gradient_tolerance", self.gradient_tolerance),
            ("decrease_tolerance", self.decrease_tolerance),
            ("smooth_below", self.smooth_below),
            ("least_quality", self.least_quality),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return fail(name, value, "it must not be negative");
            }
        }
        Ok(())
    }
}
