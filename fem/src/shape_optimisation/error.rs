//! Reasons why a shape could not be optimised.

use thiserror::Error;

use crate::assemble::AssemblyError;
use crate::constraints::ConstraintsError;
use crate::linear_algebra::LinearAlgebraError;
use crate::mesh::MeshError;
use crate::solve::SolverError;
use crate::space::SpaceError;

/// Error of a problem that could not be solved on a shape.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Errors of a shape optimisation.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum ShapeOptimisationError {
    /// An option without meaning.
    #[error("{name} = {value} is not possible: {why}")]
    Option { name: &'static str, value: f64, why: &'static str },
    /// The problem has no solution on the shape that the descent begins or goes on with.
    #[error("iteration {iteration}: {source}")]
    Problem { iteration: usize, source: Failure },
    /// A derivative has a wrong number of entries.
    #[error("the derivative of {what} has {found} entries, the movements have {expected} unknowns")]
    Length {
        /// The criterion or the constraint.
        what: &'static str,
        /// Unknowns of the movements.
        expected: usize,
        found: usize,
    },
    /// A value that is not a number.
    #[error("iteration {iteration}: {what} is {value}")]
    NotFinite {
        iteration: usize,
        /// The criterion or the constraint.
        what: &'static str,
        value: f64,
    },
    /// The state belongs to another mesh.
    #[error("the state to go on from has {found} coordinates, the mesh {expected}: it is of another mesh")]
    OtherMesh {
        /// Coordinates of the mesh's nodes.
        expected: usize,
        /// Coordinates in the state.
        found: usize,
    },
    /// A node whose turned position is no node.
    #[error(
        "turned by 1/{count} of a full circle about {centre:?}, the node at {position:?} falls on no other (the nearest is {distance:e} away): the mesh does not have this pattern"
    )]
    NotPeriodic {
        /// Parts of the full circle.
        count: usize,
        centre: Vec<f64>,
        position: Vec<f64>,
        /// From the turned position to the nearest node.
        distance: f64,
    },
    /// Data that do not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// No space of movements.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// Boundaries that cannot be held.
    #[error(transparent)]
    Constraints(#[from] ConstraintsError),
    /// The inner product is singular: nothing holds the body.
    #[error("the inner product of movements: {0}")]
    InnerProduct(#[from] SolverError),
    /// Sizes or numbers that do not fit.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
    /// A shape that is none.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
