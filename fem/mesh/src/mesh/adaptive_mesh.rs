//! Meshes that are refined and coarsened locally, of any shape of cells.

use super::{BisectedMesh, Mesh, MeshError, Nesting, OctreeMesh, Surface};
use crate::element::CellShape;
use crate::instantiate;

/// A mesh of one shape of cells that is refined and coarsened where cells are marked: by bisection, or by trees with hanging nodes.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::{AdaptiveMesh, rectangle};
///
/// for (shape, count) in [(CellShape::Triangle, 10), (CellShape::Quadrilateral, 7)] {
///     let coarse = AdaptiveMesh::new(rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], shape, 1)?)?;
///     let (fine, _) = coarse.refined_onto(&[0], &[])?;
///     assert_eq!(fine.mesh().cell_count(), count);
/// }
/// # Ok::<(), forms_fem::mesh::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub enum AdaptiveMesh<const D: usize> {
    /// Triangles or tetrahedra.
    Bisected(BisectedMesh<D>),
    /// Quadrilaterals or hexahedra.
    Octree(OctreeMesh<D>),
}

impl<const D: usize> AdaptiveMesh<D> {
    /// A mesh before its first division.
    ///
    /// # Errors
    /// Those of [`BisectedMesh::new`] and [`OctreeMesh::new`]; [`MeshError::NotSimplices`] for a mesh of quadrilaterals and triangles.
    #[inline(never)]
    pub fn new(mesh: Mesh<D>) -> Result<Self, MeshError> {
        if mesh.shapes().into_iter().any(CellShape::is_simplex) {
            BisectedMesh::new(mesh).map(AdaptiveMesh::Bisected)
        } else {
            OctreeMesh::new(mesh).map(AdaptiveMesh::Octree)
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        match self {
            AdaptiveMesh::Bisected(mesh) => mesh.mesh(),
            AdaptiveMesh::Octree(mesh) => mesh.mesh(),
        }
    }

    /// The mesh with the marked cells divided, and those that have to be with them; new nodes on the facets of each region are moved by its
    /// map. See [`BisectedMesh::refined_onto`] and [`OctreeMesh::refined_onto`].
    ///
    /// # Errors
    /// Theirs.
    #[inline(never)]
    pub fn refined_onto(
        &self,
        marked: &[u32],
        surfaces: &[Surface<'_, D>],
    ) -> Result<(Self, Nesting<D>), MeshError> {
        Ok(match self {
            AdaptiveMesh::Bisected(mesh) => {
                let (mesh, nesting) = mesh.refined_onto(marked, surfaces)?;
                (AdaptiveMesh::Bisected(mesh), nesting)
            }
            AdaptiveMesh::Octree(mesh) => {
                let (mesh, nesting) = mesh.refined_onto(marked, surfaces)?;
                (AdaptiveMesh::Octree(mesh), nesting)
            }
        })
    }

    /// The mesh with divisions undone where that is allowed: [`BisectedMesh::coarsened`], [`OctreeMesh::coarsened`].
    ///
    /// # Errors
    /// [`MeshError::MarkedCell`] for a cell that does not exist.
    #[inline(never)]
    pub fn coarsened(&self, marked: &[u32]) -> Result<(Self, Nesting<D>), MeshError> {
        Ok(match self {
            AdaptiveMesh::Bisected(mesh) => {
                let (mesh, nesting) = mesh.coarsened(marked)?;
                (AdaptiveMesh::Bisected(mesh), nesting)
            }
            AdaptiveMesh::Octree(mesh) => {
                let (mesh, nesting) = mesh.coarsened(marked)?;
                (AdaptiveMesh::Octree(mesh), nesting)
            }
        })
    }
}

instantiate!(adaptive_mesh: AdaptiveMesh::<D>::new, AdaptiveMesh::<D>::refined_onto, AdaptiveMesh::<D>::coarsened);
