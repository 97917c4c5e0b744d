//! Meshes with the same cells at other places.

use super::{Mesh, MeshError};
use crate::instantiate;

impl<const D: usize> Mesh<D> {
    /// The mesh with its nodes at other places \[length\]: cells, facets and regions keep their numbers and names, and
    /// spaces on it number their nodes as on this mesh, so that coefficients can be carried over.
    ///
    /// # Errors
    /// [`MeshError`]: another number of nodes, a coordinate that is not finite (names the node), a cell that is
    /// inverted or degenerate there (names the cell), a hanging node that leaves the facet that it hangs on.
    #[inline(never)]
    pub fn with_nodes(&self, nodes: Vec<[f64; D]>) -> Result<Self, MeshError> {
        if nodes.len() != self.node_count() {
            return Err(MeshError::NodeCount { given: nodes.len(), count: self.node_count() });
        }
        // Normals of rigid surfaces are known where the cells that carry them are.
        let carriers = || self.body_cells().end..self.cell_count();
        if carriers()
            .flat_map(|cell| self.cell(cell))
            .any(|node| nodes[*node as usize] != self.nodes[*node as usize])
        {
            self.without_rigid_surfaces("moving the nodes of the cell that carries a surface")?;
        }
        // The walk of the cells, which numbers nodes, is kept.
        self.cell_order();
        let moved = self.of_nodes(nodes);
        moved.check_places()?;
        Ok(moved)
    }

    /// Puts the nodes of a mesh that is being made to other places, before anything has been derived from them.
    pub(super) fn put_nodes(&mut self, nodes: Vec<[f64; D]>) {
        let data = self.data_mut();
        data.nodes = nodes;
        data.order = super::order::LazyOrder::new();
    }

    /// Check that nodes are at finite positions, no cell is inverted, and no hanging node leaves its facet.
    pub(super) fn check_places(&self) -> Result<(), MeshError> {
        super::connectivity::check_nodes(&self.nodes)?;
        self.check_jacobians()?;
        self.check_parts()
    }

    /// The mesh with its nodes at other places, without a check of the cells: for tests of functions that find inverted cells.
    #[doc(hidden)]
    #[inline(never)]
    pub fn with_unchecked_nodes(&self, nodes: Vec<[f64; D]>) -> Self {
        self.of_nodes(nodes)
    }
}

instantiate!(moved: Mesh::<D>::with_nodes, Mesh::<D>::with_unchecked_nodes);
