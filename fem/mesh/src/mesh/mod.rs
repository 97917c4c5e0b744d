//! Meshes with named regions.

mod adaptive_mesh;
mod affine;
mod ball;
mod bisection;
mod blocks;
mod bodies;
mod cell_blocks;
mod checksum;
mod conformity;
mod connectivity;
#[doc(hidden)]
pub mod determinant;
mod disc;
mod error;
mod facet_parts;
mod generators;
mod geometry;
pub mod gmsh;
mod hanging_facets;
mod imported;
mod interior;
mod marking;
instantiate!(mesh: Mesh::<D>::from_blocks, Mesh::<D>::from_nonconforming_blocks);

#[cfg(test)]
mod measures;
mod moved;
mod nesting;
mod octree;
mod order;
mod part;
mod perforated;
mod piece;
mod point_tree;
mod quality;
#[cfg(test)]
mod random_markings;
mod refine;
mod regions;
#[cfg(feature = "remeshing")]
mod remeshing;
mod rigid_surface;
mod shared_facets;
mod simplices;
#[doc(hidden)]
pub mod small_matrices;
mod structured;
pub mod vtk;

use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

use crate::element::{CellShape, Lagrange};
use crate::instantiate;

pub use crate::facet::Facet;
pub use adaptive_mesh::AdaptiveMesh;
#[doc(hidden)]
pub use affine::AffineMaps;
pub use ball::ball;
pub use bisection::BisectedMesh;
pub use cell_blocks::CellBlock;
#[doc(hidden)]
pub use cell_blocks::CellLists;
pub use conformity::{Conformity, HangingNode, Overlap};
pub use disc::{disc, half_disc};
pub use error::MeshError;
#[doc(hidden)]
pub use facet_parts::Facing;
#[doc(hidden)]
pub use generators::straight_map;
pub use generators::{annulus, cuboid, hollow_cylinder, rectangle};
pub use gmsh::{GmshError, GmshMesh};
pub use marking::{MarkingError, doerfler};
pub use nesting::Nesting;
pub use octree::OctreeMesh;
pub use order::CellOrder;
pub use part::PartOfMesh;
pub use perforated::PerforatedAnnulus;
#[doc(hidden)]
pub use piece::{GhostCells, RegionNames, TAKE_THE_WHOLE};
pub use quality::{ASPECT_RATIOS, CellQuality, MeshQuality};
pub use refine::{Surface, onto_sphere};
pub use regions::{BOUNDARY, EVERYWHERE, INTERIOR};
#[cfg(feature = "remeshing")]
pub use remeshing::{Remeshing, RemeshingError, Sizes};
#[doc(hidden)]
pub use rigid_surface::CarriedSurface;
pub use rigid_surface::{RigidSurface, RigidSurfaceError, SignedDistance};
pub use structured::{Grid, structured};
pub use vtk::{VtkError, VtkMesh, VtkReader};

/// A mesh of cells in D dimensions, with isoparametric geometry of degree 1 or 2. All cells have one shape, or, in the
/// plane, some are triangles and some quadrilaterals: then cells of one shape follow each other in blocks.
/// Geometry nodes of a cell are in the order of [`crate::element::Lagrange`].
///
/// The cell region "all", the facet region "boundary" and (where cells share facets) the region "interior" of
/// interior facets always exist. Rigid surfaces ([`Mesh::with_rigid_surfaces`]) have further cells, which are in none of them.
///
/// A mesh is a handle: a clone costs nothing and is the same mesh, to spaces too. A region that is named afterwards belongs to the
/// handle that names it, which is another mesh from then on: regions come before spaces.
#[derive(Clone, Debug)]
pub struct Mesh<const D: usize>(Arc<MeshData<D>>);

/// The data that the handles of a mesh share.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct MeshData<const D: usize> {
    /// Which cells have which shape.
    blocks: Vec<CellBlock>,
    /// Places of each cell's nodes among those of all.
    lists: CellLists,
    /// Degree of the geometry map.
    pub(crate) degree: usize,
    /// Node coordinates \[length\].
    pub(crate) nodes: Vec<[f64; D]>,
    /// Node numbers, cell after cell.
    pub(crate) cells: Vec<u32>,
    /// Named sets of cells.
    pub(crate) cell_regions: BTreeMap<String, Vec<u32>>,
    /// Named sets of facets.
    pub(crate) facet_regions: BTreeMap<String, Vec<Facet>>,
    /// Named sets of interior facets, each with its two sides.
    interior_regions: BTreeMap<String, Vec<[Facet; 2]>>,
    /// Facets that are parts of larger ones.
    parts: facet_parts::FacetParts<D>,
    /// Rigid surfaces, each on one of the last cells, in their order.
    rigid: Vec<CarriedSurface<D>>,
    order: order::LazyOrder,
    extent: piece::Extent,
}

impl<const D: usize> Deref for Mesh<D> {
    type Target = MeshData<D>;

    #[inline]
    fn deref(&self) -> &MeshData<D> {
        &self.0
    }
}

impl<const D: usize> Mesh<D> {
    /// Whether both are handles of one mesh. Meshes that were made separately are two, however much they agree.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::{element::CellShape, mesh::rectangle};
    ///
    /// let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
    /// let mut named = mesh.clone();
    /// assert!(named.is_same(&mesh));
    /// named.name_facets("half", "bottom", |x| x[0] < 0.5)?;
    /// assert!(!named.is_same(&mesh) && mesh.facet_region("half").is_err());
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    #[inline]
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// The data to change: its own from now on, if other handles share it.
    fn data_mut(&mut self) -> &mut MeshData<D> {
        Arc::make_mut(&mut self.0)
    }

    /// The mesh with other nodes.
    fn of_nodes(&self, nodes: Vec<[f64; D]>) -> Self {
        Mesh(Arc::new(MeshData { nodes, ..(*self.0).clone() }))
    }

    /// A mesh from node coordinates \[length\] and the node numbers of its cells, cell after cell, each
    /// cell's in the order of [`Lagrange`].
    ///
    /// # Errors
    /// A [`MeshError`] that names the cell or node: a degree other than 1 and 2, a shape that does not
    /// live in D dimensions, no cells, a list of cells that breaks off, a node number out of range or twice
    /// in a cell, a coordinate that is not finite, a cell that is inverted or degenerate anywhere in it (proved by
    /// bounds of its Jacobian determinant, and by its edges), a facet that more than two cells share, two cells on the same side of
    /// a facet or with different nodes on it, and a hanging node, a vertex on a facet of a cell that does not have it.
    /// Facets that coincide with cells on both sides are cracks, and allowed: [`Mesh::conformity`] lists them.
    pub fn from_parts(
        shape: CellShape,
        degree: usize,
        nodes: Vec<[f64; D]>,
        cells: Vec<u32>,
    ) -> Result<Self, MeshError> {
        Mesh::from_blocks(degree, nodes, vec![(shape, cells)])
    }

    /// A mesh from blocks of cells, each of one shape: triangles with quadrilaterals. Cells are numbered block after
    /// block; blocks without cells are left out.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::Mesh;
    ///
    /// let nodes = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.5, 0.5]];
    /// let square = (CellShape::Quadrilateral, vec![0, 1, 2, 3]);
    /// let roof = (CellShape::Triangle, vec![1, 4, 2]);
    /// let house = Mesh::from_blocks(1, nodes, vec![square, roof])?;
    /// assert_eq!((house.cell_count(), house.interior_facets().len()), (2, 1));
    /// assert_eq!(house.cell_shape(1), CellShape::Triangle);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Mesh::from_parts`]; [`MeshError::ShapesTogether`] for shapes in space that are not all the same.
    #[inline(never)]
    pub fn from_blocks(
        degree: usize,
        nodes: Vec<[f64; D]>,
        blocks: Vec<(CellShape, Vec<u32>)>,
    ) -> Result<Self, MeshError> {
        let mesh = Mesh::of_sound_cells(degree, nodes, blocks)?;
        mesh.check_conformity()?;
        Ok(mesh)
    }

    /// A mesh like that of [`Mesh::from_blocks`], of cells that may touch in other ways than by sharing facets: with hanging nodes, as where
    /// bodies touch or coarse cells meet fine ones. Nothing holds the two sides together there, unless a form does:
    /// the facets are exterior. [`Mesh::conformity`] lists what touches.
    ///
    /// # Errors
    /// As [`Mesh::from_blocks`], except for [`MeshError::HangingNode`].
    #[inline(never)]
    pub fn from_nonconforming_blocks(
        degree: usize,
        nodes: Vec<[f64; D]>,
        blocks: Vec<(CellShape, Vec<u32>)>,
    ) -> Result<Self, MeshError> {
        let mesh = Mesh::of_sound_cells(degree, nodes, blocks)?;
        mesh.touching().check_sides(&mesh)?;
        Ok(mesh)
    }

    /// A mesh of cells that are sound, and fit each other where they share facets. What else touches is not looked at.
    #[inline(never)]
    fn of_sound_cells(
        degree: usize,
        nodes: Vec<[f64; D]>,
        blocks: Vec<(CellShape, Vec<u32>)>,
    ) -> Result<Self, MeshError> {
        let (blocks, cells) = connectivity::check_blocks::<D>(degree, blocks)?;
        connectivity::check_nodes(&nodes)?;
        let lists = CellLists::new(&blocks, |shape| Lagrange { shape, degree }.nodes());
        connectivity::check_cells(&lists, nodes.len(), &cells)?;
        let (boundary, interior_facets) = connectivity::match_facets(&blocks, &lists, &cells)?;
        let all = (0..blocks.last().map_or(0, |last| last.cells.end) as u32).collect();
        let mesh = Mesh(Arc::new(MeshData {
            blocks,
            lists,
            degree,
            nodes,
            cells,
            cell_regions: BTreeMap::from([(EVERYWHERE.to_owned(), all)]),
            facet_regions: BTreeMap::from([(BOUNDARY.to_owned(), boundary)]),
            interior_regions: BTreeMap::from([(INTERIOR.to_owned(), interior_facets)]),
            parts: facet_parts::FacetParts::default(),
            rigid: vec![],
            order: order::LazyOrder::new(),
            extent: piece::Extent::Whole,
        }));
        mesh.check_jacobians()?;
        mesh.check_shared_facets()?;
        Ok(mesh)
    }

    /// Degree of the geometry map.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Whether the Jacobian of every cell is constant: simplices of degree 1.
    pub fn is_affine(&self) -> bool {
        self.blocks.iter().all(|block| self.is_affine_on(block.shape))
    }

    /// Node coordinates \[length\].
    pub fn nodes(&self) -> &[[f64; D]] {
        &self.nodes
    }

    /// Number of geometry nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Node numbers, cell after cell.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.blocks.last().map_or(0, |last| last.cells.end)
    }

    /// Node numbers of a cell, its vertices first.
    ///
    /// # Panics
    /// When `cell` is not below [`Mesh::cell_count`].
    #[inline]
    pub fn cell(&self, cell: usize) -> &[u32] {
        &self.cells[self.lists.of(cell)]
    }

    /// The facets that belong to one cell only, in order of cell and local number.
    pub fn boundary_facets(&self) -> &[Facet] {
        self.facet_regions.get(BOUNDARY).map_or(&[], Vec::as_slice)
    }

    /// The two sides of each facet between two cells, the cell with the smaller index first. Where a cell meets smaller ones, in an
    /// [`OctreeMesh`], there is one for each of their facets, with the larger facet on the other side.
    pub fn interior_facets(&self) -> &[[Facet; 2]] {
        self.interior_regions.get(INTERIOR).map_or(&[], Vec::as_slice)
    }

    /// Number of facets, those between two cells counted once.
    pub fn facet_count(&self) -> usize {
        self.boundary_facets().len() + self.interior_facets().len()
    }
}
