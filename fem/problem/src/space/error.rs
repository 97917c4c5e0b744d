//! Errors of spaces.

use thiserror::Error;

use super::Scope;
use crate::element::{ElementError, Elements};
use crate::mesh::MeshError;

/// Errors of spaces.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum SpaceError {
    /// No such element.
    #[error(transparent)]
    Element(#[from] ElementError),
    /// No such element with a scope that has degree 0.
    #[error("there is no Lagrange element of degree {degree} {scope}; the degrees are 0 to 4")]
    Degree {
        /// The scope asked for.
        scope: Scope,
        degree: usize,
    },
    /// Elements that cannot have a scope.
    #[error("there is no space of {elements} {scope}: {reason}")]
    Scope { elements: Elements, scope: Scope, reason: &'static str },
    /// A scope limited to no cell at all.
    #[error("a space {scope} would have no cell")]
    Empty { scope: Scope },
    /// No such facet region.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Spaces that must live on the cells of one mesh do not.
    #[error("the two spaces are not both on the cells of one mesh")]
    OtherMesh,
    /// A value without components.
    #[error("a value of shape {shape:?} has no components")]
    Shape { shape: Vec<usize> },
    /// Unknowns are numbered with `u32`.
    #[error("the space would have {unknowns} unknowns, more than 4294967295")]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
    },
}
