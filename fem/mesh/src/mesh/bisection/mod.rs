//! Meshes of triangles or tetrahedra that are refined and coarsened by bisection.

mod closure;
mod coarsening;
mod edge_nodes;
mod marked_edges;
mod refinement;

use super::{Mesh, MeshError, Nesting, Surface};
use crate::element::CellShape;
use crate::instantiate;
use marked_edges::{MarkedEdges, Part};

pub(super) use marked_edges::step_of_bisection;

/// A conforming mesh of triangles or tetrahedra, with the data of its refinement and coarsening by bisection.
///
/// Refinement bisects the marked cells and those that would be left with hanging nodes. In the plane the first bisection of a
/// triangle divides its longest edge, and then the edge opposite the newest vertex: no angle falls below half of the least one of the first
/// mesh. In space the edges are marked so that a tetrahedron and its descendants, however many, have 36 shapes, or at most 73 where the
/// longest edges of its faces do not lie in a plane (D. N. Arnold, A. Mukherjee, L. Pouly, SIAM J. Sci. Comput. 22 (2000)). The first
/// mesh may be any mesh of simplices.
///
/// The parts of a cell take its place in the numbering of the cells, and new nodes follow those that there were. Results depend
/// on the set of marked cells alone.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::{BisectedMesh, doerfler, rectangle};
///
/// let coarse = BisectedMesh::new(rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellShape::Triangle, 1)?)?;
/// let indicators = [4.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// let (fine, nesting) = coarse.refined(&doerfler(&indicators, 0.5)?)?;
/// // The marked triangle and its neighbour across the diagonal.
/// assert_eq!(fine.mesh().cell_count(), 10);
/// assert_eq!((nesting.fine_cells(0), nesting.coarse_cell(5)), (0..2, 3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BisectedMesh<const D: usize> {
    mesh: Mesh<D>,
    /// The marked edges of each cell.
    marks: Vec<MarkedEdges>,
    /// The bisection that each cell comes from.
    origins: Vec<Option<Origin>>,
    /// The bisections that made the mesh.
    bisections: Vec<Bisection>,
}

/// A bisection and the part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Origin {
    bisection: u32,
    part: Part,
}

/// A cell that has been bisected, as its two parts do not tell it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Bisection {
    marks: MarkedEdges,
    origin: Option<Origin>,
}

impl<const D: usize> BisectedMesh<D> {
    /// A mesh before its first bisection; of edges of equal length the one with the larger numbers of nodes counts as longer.
    ///
    /// # Errors
    /// [`MeshError::NotSimplices`] for quadrilaterals and hexahedra, which [`Mesh::simplices`] divides;
    /// [`MeshError::RigidSurface`] for a mesh with rigid surfaces.
    #[inline(never)]
    pub fn new(mesh: Mesh<D>) -> Result<Self, MeshError> {
        mesh.without_rigid_surfaces("bisection")?;
        mesh.without_facet_parts("bisection")?;
        if let Some(shape) = mesh.shapes().into_iter().find(|shape| !shape.is_simplex()) {
            return Err(MeshError::NotSimplices { feature: "bisection", shape });
        }
        let shape = simplex::<D>();
        let marks_of = |cell: usize| {
            let vertices = mesh.cell_vertices(cell);
            MarkedEdges::longest(shape, |edge| {
                let [a, b] = shape.edges()[edge].map(|vertex| vertices[vertex]);
                let [x, y] = [a, b].map(|node| &mesh.nodes[node as usize]);
                let squared: f64 = x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum();
                (squared, a.max(b), a.min(b))
            })
        };
        let count = mesh.cell_count();
        let marks = (0..count).map(marks_of).collect();
        Ok(BisectedMesh { marks, origins: vec![None; count], bisections: vec![], mesh })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// The mesh with the marked cells bisected, and others where nodes would hang; cell numbers may repeat. All regions are kept. New
    /// nodes are where the geometry map has them, so that the mesh covers the same set; see [`BisectedMesh::refined_onto`]. The
    /// [`Nesting`] says from which cell each new one comes.
    ///
    /// # Errors
    /// [`MeshError::MarkedCell`] for a cell that does not exist; [`MeshError::TooLarge`]; [`MeshError::Inverted`] where cells
    /// become so small that rounding degenerates them.
    pub fn refined(&self, marked: &[u32]) -> Result<(Self, Nesting<D>), MeshError> {
        self.refined_onto(marked, &[])
    }

    /// The mesh of [`BisectedMesh::refined`] whose new nodes on the facets of each region are moved by its map, for example onto the circle that the
    /// region approximates. Where regions meet, their maps follow each other in the order given.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{BisectedMesh, annulus, onto_sphere};
    ///
    /// let mut ring = BisectedMesh::new(annulus(1.0, 2.0, 1, 8, CellShape::Triangle, 1)?)?;
    /// for _ in 0..4 {
    ///     let outer: Vec<u32> = ring.mesh().facet_region("outer")?.iter().map(|facet| facet.cell).collect();
    ///     ring = ring.refined_onto(&outer, &[("outer", &onto_sphere([0.0, 0.0], 2.0))])?.0;
    /// }
    /// let mesh = ring.mesh();
    /// for facet in mesh.facet_region("outer")? {
    ///     let ends = mesh.cell_shape(facet.cell as usize).facet_vertices(facet.local.into());
    ///     let [x, y] = mesh.nodes()[mesh.cell(facet.cell as usize)[ends[0]] as usize];
    ///     assert!((x.hypot(y) - 2.0).abs() < 1e-14);
    /// }
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`BisectedMesh::refined`]; [`MeshError::UnknownRegion`]; [`MeshError::NotFinite`] and [`MeshError::Inverted`] where a map
    /// moves nodes to infinity or through a cell.
    #[inline(never)]
    pub fn refined_onto(
        &self,
        marked: &[u32],
        surfaces: &[Surface<'_, D>],
    ) -> Result<(Self, Nesting<D>), MeshError> {
        let closed = closure::Closure::of(self, &self.mesh.marked_cells(marked)?)?;
        refinement::from_closure(self, closed, surfaces)
    }
}

/// The simplex of D dimensions.
fn simplex<const D: usize>() -> CellShape {
    if D == 2 { CellShape::Triangle } else { CellShape::Tetrahedron }
}

/// The facet opposite a vertex.
fn opposite(shape: CellShape, vertex: usize) -> usize {
    if shape == CellShape::Triangle { (vertex + 1) % 3 } else { vertex }
}

instantiate!(bisection: BisectedMesh::<D>::new, BisectedMesh::<D>::refined_onto);

#[cfg(test)]
mod tests;
