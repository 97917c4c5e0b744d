//! Reasons why a mesh could not be made again.

use thiserror::Error;

use crate::mesh::MeshError;

/// Errors of remeshing.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum RemeshingError {
    /// A setting without meaning.
    #[error("{name} = {value} is not possible: {why}")]
    Setting { name: &'static str, value: f64, why: &'static str },
    /// A boundary that does not close.
    #[error("the boundary through {at:?} does not close")]
    Open {
        /// A node of it.
        at: [f64; 2],
    },
    /// A loop of the boundary that lies in several sectors without running around the centre.
    #[error("the boundary through {at:?} crosses the sides of its sector")]
    AcrossSectors {
        /// A node of it.
        at: [f64; 2],
    },
    /// A ring has one outer and one inner boundary.
    #[error("{found} boundaries run around the centre; a ring of sectors has two")]
    Loops { found: usize },
    /// A sector is cut at a node.
    #[error("the boundary near {at:?} has no node on the side of its sector")]
    NoNodeOnTheCut {
        /// The node that is nearest.
        at: [f64; 2],
    },
    /// The triangulation failed.
    #[error("the outline could not be filled with triangles: {0}")]
    Triangulation(String),
    /// A region that the new mesh does not have as it was.
    #[error("the region {name:?} cannot be carried to another mesh: {why}")]
    Region { name: String, why: &'static str },
    /// The new mesh is none, or the old one has no outline.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
