//! Finite element spaces: unknowns on the nodes of a mesh, or of its facets.

mod cell_nodes;
mod embedding;
mod error;
mod family;
mod numbering;
mod orientation;

use std::sync::{Arc, OnceLock};

pub(crate) use self::cell_nodes::CellNodes;
pub use self::error::SpaceError;
pub use self::family::Family;
use crate::element::{CellShape, Lagrange, MAXIMUM_DEGREE, PerShape};
use crate::instantiate::instantiate;
use crate::locate::Locator;
use crate::mesh::{CellLists, Facet, Mesh, MeshError};

/// A Lagrange space with a number of components per node. Unknown number = node * components + component.
///
/// Nodes are numbered in the order in which the cells (or facets) first use them, those inside an edge or a face
/// together (along an edge from the vertex of the lower number in the mesh to that of the higher), along the mesh's
/// [`CellOrder`](crate::mesh::CellOrder): nodes of near numbers lie near each other, however the mesh was numbered.
#[derive(Debug)]
pub struct Space<const D: usize> {
    pub(crate) mesh: Arc<Mesh<D>>,
    pub(crate) degree: usize,
    pub(crate) family: Family,
    /// `[]` scalar, `[D]` vector, `[D, D]` tensor, or any other.
    pub(crate) shape: Vec<usize>,
    /// Nodes of the space, cell after cell, in the order of the element's nodes; none on facets.
    pub(crate) cell_nodes: Vec<u32>,
    /// Places of each cell's nodes there.
    lists: CellLists,
    /// The facets that a space on facets lives on, sorted, with their nodes.
    pub(crate) facets: Vec<(Facet, Vec<u32>)>,
    /// Position of each node.
    pub(crate) positions: Vec<[f64; D]>,
    // Built when a field is first evaluated at a point.
    locator: OnceLock<Locator<D>>,
}

impl<const D: usize> Space<D> {
    /// The continuous scalar Lagrange space of a degree, which need not be that of the geometry.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = Arc::new(rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?);
    /// let space = Space::scalar(&mesh, 2)?;
    /// assert_eq!(space.components(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SpaceError::Element`] unless the degree is 1 to 4; [`SpaceError::TooLarge`].
    pub fn scalar(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::Continuous, degree, &[])
    }

    /// The continuous space of vectors with D components.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = Arc::new(rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?);
    /// let space = Space::vector(&mesh, 2)?;
    /// assert_eq!(space.components(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Space::scalar`].
    pub fn vector(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::Continuous, degree, &[D])
    }

    /// The continuous space of tensors with D × D components, row-major.
    ///
    /// # Errors
    /// As [`Space::scalar`].
    pub fn tensor(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::Continuous, degree, &[D, D])
    }

    /// The discontinuous scalar space of degree 0 (constant on each cell) to 4.
    ///
    /// # Errors
    /// [`SpaceError::Degree`], [`SpaceError::TooLarge`].
    pub fn discontinuous_scalar(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::Discontinuous, degree, &[])
    }

    /// The discontinuous space of vectors with D components.
    ///
    /// # Errors
    /// As [`Space::discontinuous_scalar`].
    pub fn discontinuous_vector(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::Discontinuous, degree, &[D])
    }

    /// The discontinuous space of tensors with D × D components, row-major.
    ///
    /// # Errors
    /// As [`Space::discontinuous_scalar`].
    pub fn discontinuous_tensor(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::Discontinuous, degree, &[D, D])
    }

    /// The scalar space on the facets of a region alone: continuous of degree 1 to 4, or constant on each
    /// facet in degree 0.
    ///
    /// # Errors
    /// [`SpaceError::Mesh`] for an unknown region, [`SpaceError::Degree`], [`SpaceError::TooLarge`].
    pub fn on_facets(mesh: &Arc<Mesh<D>>, region: &str, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::OnFacets(region.to_owned()), degree, &[])
    }

    /// The space of vectors with D components on the facets of a region alone.
    ///
    /// # Errors
    /// As [`Space::on_facets`].
    pub fn vector_on_facets(
        mesh: &Arc<Mesh<D>>,
        region: &str,
        degree: usize,
    ) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::OnFacets(region.to_owned()), degree, &[D])
    }

    /// The scalar space on the facets of a region alone whose values jump between facets: of degree 0 (constant on each
    /// facet) to 4.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = Arc::new(rectangle([0.0; 2], [3.0, 1.0], [3, 1], CellShape::Triangle, 1)?);
    /// assert_eq!(Space::on_facets(&mesh, "bottom", 1)?.node_count(), 4);
    /// assert_eq!(Space::discontinuous_on_facets(&mesh, "bottom", 1)?.node_count(), 6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Space::on_facets`].
    pub fn discontinuous_on_facets(
        mesh: &Arc<Mesh<D>>,
        region: &str,
        degree: usize,
    ) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::DiscontinuousOnFacets(region.to_owned()), degree, &[])
    }

    /// The space of vectors with D components on the facets of a region alone, whose values jump between facets.
    ///
    /// # Errors
    /// As [`Space::on_facets`].
    pub fn discontinuous_vector_on_facets(
        mesh: &Arc<Mesh<D>>,
        region: &str,
        degree: usize,
    ) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, Family::DiscontinuousOnFacets(region.to_owned()), degree, &[D])
    }

    /// A space of any family with values of any shape: `[]` scalar, `[3]` vectors of three components in any
    /// dimension, `[2, 3]` matrices (row-major).
    ///
    /// # Errors
    /// [`SpaceError`]: a degree that the family does not have, an unknown region, a shape without
    /// components, too many unknowns.
    #[inline(never)]
    pub fn new(
        mesh: &Arc<Mesh<D>>,
        family: Family,
        degree: usize,
        shape: &[usize],
    ) -> Result<Arc<Self>, SpaceError> {
        if shape.contains(&0) {
            return Err(SpaceError::Shape { shape: shape.to_vec() });
        }
        match family {
            Family::Continuous => {
                mesh.shapes().into_iter().try_for_each(|shape| Lagrange::new(shape, degree).map(|_| ()))?
            }
            _ if degree > MAXIMUM_DEGREE => return Err(SpaceError::Degree { family, degree }),
            _ => {}
        }
        let lists = CellLists::new(mesh.blocks(), |shape| Lagrange { shape, degree }.nodes());
        let (mut cell_nodes, mut facets) = (vec![], vec![]);
        let positions = match &family {
            Family::Continuous => {
                cell_nodes = numbering::share_nodes(mesh, degree, &lists);
                numbering::node_positions(mesh, degree, &lists, &cell_nodes)
            }
            Family::Discontinuous => {
                let nodes = lists.length();
                if u32::try_from(nodes).is_err() {
                    return Err(SpaceError::TooLarge { unknowns: nodes });
                }
                cell_nodes = numbering::separate_nodes(mesh, &lists);
                numbering::node_positions(mesh, degree, &lists, &cell_nodes)
            }
            Family::OnFacets(region) | Family::DiscontinuousOnFacets(region) => {
                let entities = mesh.sides_of(region)?;
                mesh.without_facet_parts_in(region, "a space on facets")?;
                let (found, positions) = numbering::facet_nodes(mesh, &family, degree, &lists, &entities);
                facets = found;
                positions
            }
        };
        let unknowns = positions.len() * shape.iter().product::<usize>();
        if u32::try_from(unknowns).is_err() {
            return Err(SpaceError::TooLarge { unknowns });
        }
        let (mesh, shape, locator) = (Arc::clone(mesh), shape.to_vec(), OnceLock::new());
        Ok(Arc::new(Space { mesh, degree, family, shape, cell_nodes, lists, facets, positions, locator }))
    }

    /// The scalar space on the same nodes.
    #[inline(never)]
    pub(crate) fn scalar_nodes(&self) -> Arc<Self> {
        Arc::new(Space {
            mesh: Arc::clone(&self.mesh),
            degree: self.degree,
            family: self.family.clone(),
            shape: vec![],
            cell_nodes: self.cell_nodes.clone(),
            lists: self.lists.clone(),
            facets: self.facets.clone(),
            positions: self.positions.clone(),
            locator: OnceLock::new(),
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh<D>> {
        &self.mesh
    }

    /// The element on a cell; a space on facets has the traces of its basis functions.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    pub fn cell_element(&self, cell: usize) -> Lagrange {
        self.element_of(self.mesh.cell_shape(cell))
    }

    /// The element on the cells of a shape.
    pub(crate) fn element_of(&self, shape: CellShape) -> Lagrange {
        Lagrange { shape, degree: self.degree }
    }

    /// The places of the nodes, and the cells that share them.
    pub fn family(&self) -> &Family {
        &self.family
    }

    /// The region of a space that lives on facets alone.
    pub fn facet_region(&self) -> Option<&str> {
        match &self.family {
            Family::OnFacets(region) | Family::DiscontinuousOnFacets(region) => Some(region),
            Family::Continuous | Family::Discontinuous => None,
        }
    }

    /// The polynomial degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Shape of a value: `[]` scalar, `[D]` vector, `[D, D]` tensor.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Number of scalar components of a value.
    pub fn components(&self) -> usize {
        self.shape.iter().product()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.positions.len()
    }

    /// Number of unknowns: nodes times components.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = Arc::new(rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?);
    /// // 5 × 3 nodes with two components.
    /// assert_eq!(Space::vector(&mesh, 1)?.unknowns(), 30);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn unknowns(&self) -> usize {
        self.node_count() * self.components()
    }

    /// Nodes of a cell, in the order of the element's nodes; none for a space on facets.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    pub fn cell_nodes(&self, cell: usize) -> &[u32] {
        self.nodes_of_cells().of(cell)
    }

    /// Nodes of all cells, cell after cell.
    pub fn all_cell_nodes(&self) -> &[u32] {
        &self.cell_nodes
    }

    /// Nodes whose basis functions live on a cell seen from one of its facets (or from inside): the cell's,
    /// or the facet's for a space on facets.
    pub(crate) fn nodes_at(&self, cell: u32, facet: Option<u8>) -> &[u32] {
        self.nodes_of_cells().at(cell, facet)
    }

    /// The nodes of its cells and facets.
    #[inline]
    pub(crate) fn nodes_of_cells(&self) -> CellNodes<'_> {
        let facets = self.facet_region().map(|_| self.facets.as_slice());
        CellNodes { nodes: &self.cell_nodes, lists: &self.lists, facets, count: self.node_count() }
    }

    /// Whether the unknowns of both spaces have the same numbers and places.
    #[inline(never)]
    #[doc(hidden)]
    pub fn numbers_as(self: &Arc<Self>, other: &Arc<Self>) -> bool {
        Arc::ptr_eq(self, other)
            || (Arc::ptr_eq(&self.mesh, &other.mesh)
                && self.degree == other.degree
                && self.family == other.family
                && self.components() == other.components())
    }

    /// Position of each node \[length\].
    pub fn positions(&self) -> &[[f64; D]] {
        &self.positions
    }

    /// The node nearest to a point; of several the one with the lowest number. `None` for a NaN.
    #[inline(never)]
    pub fn nearest_node(&self, point: &[f64; D]) -> Option<usize> {
        let distance = |x: &[f64; D]| -> f64 { x.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum() };
        let squares = self.positions.iter().map(distance).enumerate();
        squares
            .filter(|(_, square)| !square.is_nan())
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(node, _)| node)
    }

    /// All nodes on a facet region (exterior or interior) or in a cell region, ascending. Nodes inside cells
    /// are not on facets: of a discontinuous space of degree 0 no node is.
    ///
    /// # Errors
    /// [`MeshError::UnknownRegion`], which lists the names that exist.
    #[inline(never)]
    pub fn nodes_on(&self, region: &str) -> Result<Vec<u32>, MeshError> {
        let mesh = &self.mesh;
        let mut nodes: Vec<u32> = if let Ok(sides) = mesh.sides_of(region) {
            let of_shape = |shape: CellShape| {
                let local = (0..shape.facets()).map(|facet| self.element_of(shape).facet_nodes(facet));
                (shape, local.collect::<Vec<_>>())
            };
            let local: PerShape<_> = mesh.shapes().into_iter().map(of_shape).collect();
            let mut nodes = Vec::new();
            for facet in sides.iter().flatten() {
                let of_entity = self.nodes_at(facet.cell, Some(facet.local));
                match self.facet_region() {
                    Some(_) => nodes.extend_from_slice(of_entity),
                    None => {
                        let local = &local[mesh.cell_shape(facet.cell as usize)][usize::from(facet.local)];
                        nodes.extend(local.iter().map(|&node| of_entity[node]));
                    }
                }
            }
            nodes
        } else if let Ok(cells) = mesh.cell_region(region) {
            cells.iter().flat_map(|&cell| self.cell_nodes(cell as usize)).copied().collect()
        } else {
            return Err(mesh.unknown_region(region));
        };
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Search for cells by position; built at the first call.
    pub fn locator(&self) -> &Locator<D> {
        self.locator.get_or_init(|| Locator::new(&self.mesh))
    }
}

instantiate!(
    space:
    Space::<D>::new,
    Space::<D>::scalar_nodes,
    Space::<D>::numbers_as,
    Space::<D>::nearest_node,
    Space::<D>::nodes_on
);

#[cfg(test)]
mod tests;
