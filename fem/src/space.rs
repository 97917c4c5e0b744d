//! Finite element spaces: unknowns on the nodes of a mesh.

use std::sync::Arc;

use crate::element::Lagrange;
use crate::mesh::Mesh;

/// A Lagrange space with a number of components per node. Unknown number = node * components + component.
#[derive(Debug)]
pub struct Space<const D: usize> {
    pub(crate) mesh: Arc<Mesh<D>>,
    pub(crate) element: Lagrange,
    /// `[]` scalar, `[D]` vector, `[D, D]` tensor.
    pub(crate) shape: Vec<usize>,
    /// Nodes of the space, cell after cell, in the order of the element's nodes.
    pub(crate) cell_nodes: Vec<u32>,
    /// Position of each node.
    pub(crate) positions: Vec<[f64; D]>,
}
