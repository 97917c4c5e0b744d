//! Meshes of quadrilaterals or hexahedra that are refined and coarsened by quadtrees or octrees, with hanging nodes.

mod balance;
mod coarsening;
mod parts;
mod refinement;

use super::{Mesh, MeshError, Nesting, Surface};
use crate::element::CellShape;
use crate::instantiate;

/// A mesh of quadrilaterals or hexahedra as roots of quadtrees or octrees, with what its refinement and coarsening go
/// by: a forest of trees (C. Burstedde, L. C. Wilcox, O. Ghattas, SIAM J. Sci. Comput. 33 (2011)).
///
/// Refinement divides the marked cells into 2^D, and with them those that keep cells from differing by more than one division across a
/// facet, and in space across an edge. Nodes hang where they differ.
/// `Constraints::join_hanging_nodes` makes a space continuous there, and the facets between a cell and
/// smaller ones are interior facets, one for each of the smaller cells.
///
/// The parts of a cell take its place in the numbering of the cells, part k at vertex k, and new nodes follow those that there were.
/// Results depend on the set of marked cells alone.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::{OctreeMesh, rectangle};
///
/// let coarse = OctreeMesh::new(rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1)?)?;
/// let (fine, nesting) = coarse.refined(&[0])?;
/// assert_eq!((fine.mesh().cell_count(), nesting.fine_cells(0)), (5, 0..4));
/// // Four between the parts of the first cell, and two with the second one on their other side.
/// assert_eq!(fine.mesh().interior_facets().len(), 6);
/// // Dividing one of the parts next to the second cell divides that, too.
/// assert_eq!(fine.refined(&[1])?.0.mesh().cell_count(), 4 + 3 + 4);
/// # Ok::<(), forms_fem::mesh::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct OctreeMesh<const D: usize> {
    mesh: Mesh<D>,
    /// The divided cell that each cell is a part of.
    origins: Vec<Option<Origin>>,
    divided: Divided,
}

/// A divided cell and the part of it, by the vertex at which it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Origin {
    whole: u32,
    part: u8,
}

/// The cells that have been divided.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Divided {
    /// The cell that contains each part; it comes before its parts.
    origins: Vec<Option<Origin>>,
    /// Their node numbers, cell after cell.
    nodes: Vec<u32>,
}

impl Divided {
    fn count(&self) -> usize {
        self.origins.len()
    }

    /// Node numbers of a divided cell, its vertices first.
    fn cell(&self, whole: usize) -> &[u32] {
        let per_cell = self.nodes.len() / self.count();
        &self.nodes[whole * per_cell..][..per_cell]
    }
}

impl<const D: usize> OctreeMesh<D> {
    /// A mesh before its first division.
    ///
    /// # Errors
    /// [`MeshError::NotTensorProducts`] for triangles and tetrahedra, which [`super::BisectedMesh`] refines;
    /// [`MeshError::RigidSurface`] for a mesh with rigid surfaces; [`MeshError::FacetParts`] for one with hanging nodes.
    #[inline(never)]
    pub fn new(mesh: Mesh<D>) -> Result<Self, MeshError> {
        const FEATURE: &str = "refinement by trees";
        mesh.without_rigid_surfaces(FEATURE)?;
        mesh.without_facet_parts(FEATURE)?;
        if let Some(shape) = mesh.shapes().into_iter().find(|shape| shape.is_simplex()) {
            return Err(MeshError::NotTensorProducts { feature: FEATURE, shape });
        }
        Ok(OctreeMesh { origins: vec![None; mesh.cell_count()], divided: Divided::default(), mesh })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// The mesh with the marked cells divided, and others where cells would differ by more than one division; cell numbers may repeat.
    /// All regions are kept. New nodes are where the geometry map has them, so that the mesh covers the same set; see
    /// [`OctreeMesh::refined_onto`]. The [`Nesting`] says from which cell each new one comes.
    ///
    /// # Errors
    /// [`MeshError::MarkedCell`] for a cell that does not exist; [`MeshError::TooLarge`]; [`MeshError::Inverted`] where cells
    /// become so small that rounding degenerates them.
    pub fn refined(&self, marked: &[u32]) -> Result<(Self, Nesting<D>), MeshError> {
        self.refined_onto(marked, &[])
    }

    /// The mesh of [`OctreeMesh::refined`] whose new nodes on the facets of each region are moved by its map, for example onto the circle that the
    /// region approximates. Where regions meet, their maps follow each other in the order given. A node that hangs stays on the larger cell, and
    /// is moved by the refinement after which it does not hang any more.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{OctreeMesh, annulus, onto_sphere};
    ///
    /// let ring = OctreeMesh::new(annulus(1.0, 2.0, 1, 8, CellShape::Quadrilateral, 1)?)?;
    /// let outer = onto_sphere([0.0, 0.0], 2.0);
    /// let (fine, _) = ring.refined_onto(&[0, 1, 2], &[("outer", &outer)])?;
    /// assert_eq!(fine.mesh().facet_region("outer")?.len(), 8 + 3);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`OctreeMesh::refined`]; [`MeshError::UnknownRegion`]; [`MeshError::NotFinite`] and [`MeshError::Inverted`] where a map
    /// moves nodes to infinity or through a cell.
    #[inline(never)]
    pub fn refined_onto(
        &self,
        marked: &[u32],
        surfaces: &[Surface<'_, D>],
    ) -> Result<(Self, Nesting<D>), MeshError> {
        let divided = balance::divided_with(self, &self.mesh.marked_cells(marked)?);
        refinement::divide(self, &divided, surfaces)
    }

    /// The shape of the cells.
    fn shape(&self) -> CellShape {
        self.mesh.cell_shape(0)
    }
}

/// The facet of a divided cell on which a facet of its part lies: the one of the same number, if the part is at one of its vertices.
fn lies_outside(shape: CellShape, part: u8, local: u8) -> bool {
    shape.facet_vertices(usize::from(local)).contains(&usize::from(part))
}

instantiate!(octree: OctreeMesh::<D>::new, OctreeMesh::<D>::refined_onto);

#[cfg(test)]
mod tests;
