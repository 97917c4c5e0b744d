//! The problem of a descent: criterion, constraint, and their derivatives.

use std::sync::Arc;

use super::error::Failure;
use crate::constraints::Constraints;
use crate::mesh::Mesh;
use crate::space::Space;

/// A criterion that depends on the shape, perhaps with one constraint.
pub trait ShapeProblem<const D: usize> {
    /// The state on a shape: a displacement, say, with the solver that may be used again.
    type State;

    /// Solves on a shape. It must depend on the mesh alone, to the last bit, if a descent that was interrupted is to end as
    /// one that was not.
    ///
    /// # Errors
    /// The reason why there is no solution; within a line search a shorter step is tried then.
    fn solve(&self, mesh: &Mesh<D>) -> Result<Values<Self::State>, Failure>;

    /// The derivatives by the movements of the mesh's nodes at a shape that was solved for.
    ///
    /// # Errors
    /// The reason why there are none.
    fn derivatives(&self, movements: &Arc<Space<D>>, state: &mut Self::State)
    -> Result<Derivatives, Failure>;

    /// Holds what must not move.
    ///
    /// # Errors
    /// A region that does not exist.
    fn fix(&self, movements: &mut Constraints<D>) -> Result<(), Failure>;
}

/// Values on a shape.
#[derive(Clone, Debug)]
pub struct Values<S> {
    /// The objective.
    pub criterion: f64,
    /// The constraint as a ratio, such as (V − V₀)/V₀, zero where it holds.
    pub constraint: Option<f64>,
    /// The state.
    pub state: S,
}

/// Derivatives by the movement of each node, one number per unknown of the space of the geometry.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Of the criterion \[criterion/length\].
    pub criterion: Vec<f64>,
    /// Of the constraint \[1/length\], where there is one.
    pub constraint: Option<Vec<f64>>,
}
