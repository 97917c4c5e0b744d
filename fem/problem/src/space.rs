//! Finite element spaces: unknowns on the nodes of a mesh, or of its facets.

mod cell_nodes;
mod embedding;
mod error;
mod local_nodes;
mod making;
mod numbering;
mod orientation;
mod scope;

use std::sync::{Arc, OnceLock};

pub(crate) use self::cell_nodes::CellNodes;
pub use self::error::SpaceError;
pub use self::local_nodes::Owner;
pub(crate) use self::numbering::CellInSpace;
pub use self::scope::Scope;
use crate::element::{CellShape, Element, Elements, Lagrange, PerShape};
use crate::instantiate::instantiate;
use crate::locate::Locator;
use crate::mesh::{CellLists, Facet, Mesh, MeshError};

/// A finite element space, elements times a scope, with a number of components per node. Unknown number = node * components + component.
///
/// Nodes are numbered in the order in which the cells (or facets) first use them, those inside an edge or a face
/// together (along an edge from the vertex of the lower number in the mesh to that of the higher), along the mesh's
/// [`CellOrder`](crate::mesh::CellOrder): nodes of near numbers lie near each other, however the mesh was numbered.
#[derive(Debug)]
pub struct Space<const D: usize> {
    pub(crate) mesh: Mesh<D>,
    pub(crate) degree: usize,
    pub(crate) elements: Elements,
    /// The elements on the mesh's shapes.
    pub(crate) on_shapes: Arc<PerShape<Element>>,
    pub(crate) scope: Scope,
    /// Whether it lives on facets, and whether on some cells only: asked for each cell.
    on_facets: bool,
    on_some_cells: bool,
    /// `[]` scalar, `[D]` vector, `[D, D]` tensor, or any other.
    pub(crate) shape: Vec<usize>,
    /// Nodes of the space, cell after cell, in the order of the element's nodes; none on facets.
    pub(crate) cell_nodes: Arc<Vec<u32>>,
    /// Places of each cell's nodes there.
    lists: Arc<CellLists>,
    /// The facets that a space on facets lives on, sorted, with their nodes.
    pub(crate) facets: Arc<Vec<(Facet, Vec<u32>)>>,
    /// Position of each node.
    pub(crate) positions: Arc<Vec<[f64; D]>>,
    // Built when a field is first evaluated at a point.
    locator: OnceLock<Locator<D>>,
}

impl<const D: usize> Space<D> {
    /// The continuous scalar Lagrange space of a degree, which need not be that of the geometry.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let space = Space::scalar(&mesh, 2)?;
    /// assert_eq!(space.components(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SpaceError::Element`] unless the degree is 1 to 4; [`SpaceError::TooLarge`].
    pub fn scalar(mesh: &Mesh<D>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Nodes, &[])
    }

    /// The continuous space of vectors with D components.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let space = Space::vector(&mesh, 2)?;
    /// assert_eq!(space.components(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Space::scalar`].
    pub fn vector(mesh: &Mesh<D>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Nodes, &[D])
    }

    /// The continuous space of tensors with D × D components, row-major.
    ///
    /// # Errors
    /// As [`Space::scalar`].
    pub fn tensor(mesh: &Mesh<D>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Nodes, &[D, D])
    }

    /// The discontinuous scalar space of degree 0 (constant on each cell) to 4.
    ///
    /// # Errors
    /// [`SpaceError::Degree`], [`SpaceError::TooLarge`].
    pub fn discontinuous_scalar(mesh: &Mesh<D>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Cell, &[])
    }

    /// The discontinuous space of vectors with D components.
    ///
    /// # Errors
    /// As [`Space::discontinuous_scalar`].
    pub fn discontinuous_vector(mesh: &Mesh<D>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Cell, &[D])
    }

    /// The discontinuous space of tensors with D × D components, row-major.
    ///
    /// # Errors
    /// As [`Space::discontinuous_scalar`].
    pub fn discontinuous_tensor(mesh: &Mesh<D>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Cell, &[D, D])
    }

    /// The scalar space only on the facets of a region: continuous of degree 1 to 4, or constant on each
    /// facet in degree 0.
    ///
    /// # Errors
    /// [`SpaceError::Mesh`] for an unknown region, [`SpaceError::Degree`], [`SpaceError::TooLarge`].
    pub fn on_facets(mesh: &Mesh<D>, region: &str, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Facets(region.to_owned()), &[])
    }

    /// The space of vectors with D components only on the facets of a region.
    ///
    /// # Errors
    /// As [`Space::on_facets`].
    pub fn vector_on_facets(mesh: &Mesh<D>, region: &str, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::Facets(region.to_owned()), &[D])
    }

    /// The scalar space only on the facets of a region, with values that jump between facets: of degree 0 (constant on each
    /// facet) to 4.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [3.0, 1.0], [3, 1], CellShape::Triangle, 1)?;
    /// assert_eq!(Space::on_facets(&mesh, "bottom", 1)?.node_count(), 4);
    /// assert_eq!(Space::discontinuous_on_facets(&mesh, "bottom", 1)?.node_count(), 6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Space::on_facets`].
    pub fn discontinuous_on_facets(
        mesh: &Mesh<D>,
        region: &str,
        degree: usize,
    ) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::EachFacet(region.to_owned()), &[])
    }

    /// The space of vectors with D components only on the facets of a region, with values that jump between facets.
    ///
    /// # Errors
    /// As [`Space::on_facets`].
    pub fn discontinuous_vector_on_facets(
        mesh: &Mesh<D>,
        region: &str,
        degree: usize,
    ) -> Result<Arc<Self>, SpaceError> {
        Space::of(mesh, Elements::Lagrange(degree), Scope::EachFacet(region.to_owned()), &[D])
    }

    /// The space on the same nodes, with values of another shape. It shares the numbers and positions of the nodes, which are not found again.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let displacements = Space::vector(&mesh, 2)?;
    /// let stresses = displacements.with_shape(&[2, 2])?;
    /// assert_eq!((stresses.node_count(), stresses.components()), (displacements.node_count(), 4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SpaceError::Shape`] of a shape without components, [`SpaceError::TooLarge`].
    pub fn with_shape(&self, shape: &[usize]) -> Result<Arc<Self>, SpaceError> {
        making::check_shape(shape, self.node_count())?;
        Ok(self.of_checked_shape(shape.to_vec()))
    }

    /// The scalar space on the same nodes.
    pub(crate) fn scalar_nodes(&self) -> Arc<Self> {
        self.of_checked_shape(vec![])
    }

    #[inline(never)]
    fn of_checked_shape(&self, shape: Vec<usize>) -> Arc<Self> {
        Arc::new(Space {
            mesh: self.mesh.clone(),
            degree: self.degree,
            elements: self.elements.clone(),
            on_shapes: Arc::clone(&self.on_shapes),
            scope: self.scope.clone(),
            on_facets: self.on_facets,
            on_some_cells: self.on_some_cells,
            shape,
            cell_nodes: Arc::clone(&self.cell_nodes),
            lists: Arc::clone(&self.lists),
            facets: Arc::clone(&self.facets),
            positions: Arc::clone(&self.positions),
            locator: OnceLock::new(),
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// The element on a cell; a space on facets has the traces of its basis functions.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    pub fn cell_element(&self, cell: usize) -> &Element {
        self.element_of(self.mesh.cell_shape(cell))
    }

    /// The element on the cells of a shape.
    pub(crate) fn element_of(&self, shape: CellShape) -> &Element {
        &self.on_shapes[shape]
    }

    /// The Lagrange element with the same functions on facets, by which contact pairs are displaced. Spaces without one are refused
    /// before ([`Self::displaces`]).
    pub(crate) fn traces_of(&self, shape: CellShape) -> Lagrange {
        self.on_shapes[shape].traces().unwrap_or(Lagrange { shape, degree: self.degree })
    }

    /// The degree of its traces.
    pub(crate) fn trace_degree(&self) -> usize {
        let degree = |element: &Element| element.traces().map_or(self.degree, |traces| traces.degree);
        self.on_shapes.values().map(degree).max().unwrap_or(0)
    }

    /// Whether a field on it can displace surfaces: it lives in all cells, and its traces are those of Lagrange elements.
    pub(crate) fn displaces(&self) -> bool {
        let known = self.on_shapes.values().all(|element| element.traces().is_some());
        known && matches!(self.scope, Scope::Nodes | Scope::Cell)
    }

    /// The kind of its elements.
    pub fn elements(&self) -> &Elements {
        &self.elements
    }

    /// The cells or facets that share a coefficient.
    pub fn scope(&self) -> &Scope {
        &self.scope
    }

    /// The region of a space that lives only on facets.
    pub fn facet_region(&self) -> Option<&str> {
        self.scope.facet_region()
    }

    /// Whether the values are constant on each cell, or on each facet.
    pub(crate) fn is_constant(&self) -> bool {
        self.elements == Elements::Lagrange(0)
    }

    /// Whether it has functions of its own in all cells, known from the reference cell: what can be drawn and projected.
    pub(crate) fn is_on_all_cells(&self) -> bool {
        matches!(self.scope, Scope::Nodes | Scope::Cell) && !self.on_shapes.values().any(Element::is_in_space)
    }

    /// Whether the values on a facet follow from those at the nodes on it.
    pub(crate) fn has_traces(&self) -> bool {
        self.on_shapes.values().all(Element::has_traces)
    }

    /// Values of a cell's functions at a reference point.
    #[doc(hidden)]
    pub fn basis_in(&self, cell: usize, reference: &[f64; D], value: &mut [f64]) {
        let element = self.cell_element(cell);
        if element.is_in_space() {
            let (x, _) = self.mesh.map(cell, reference);
            let place = CellInSpace::of(&self.mesh, cell).reference(&x);
            return element.evaluate_values(&place, value);
        }
        element.evaluate_values(reference, value);
    }

    /// Whether it is a space of continuous Lagrange elements on all cells.
    pub(crate) fn is_continuous_lagrange(&self) -> bool {
        matches!(self.elements, Elements::Lagrange(_)) && self.scope == Scope::Nodes
    }

    /// The polynomial degree that estimates of quadrature degrees count: of bubbles their own.
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
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
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
        let facets = self.on_facets.then_some(self.facets.as_slice());
        let (on_some, count) = (self.on_some_cells, self.node_count());
        CellNodes { nodes: &self.cell_nodes, lists: &self.lists, facets, on_some, count }
    }

    /// Whether the unknowns of both spaces have the same numbers and places.
    #[inline(never)]
    #[doc(hidden)]
    pub fn numbers_as(self: &Arc<Self>, other: &Arc<Self>) -> bool {
        Arc::ptr_eq(self, other)
            || (self.mesh.is_same(&other.mesh)
                && self.elements == other.elements
                && self.scope == other.scope
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
    /// are not on facets: of a discontinuous space of degree 0 no node is. Those of Crouzeix and Raviart's elements are the facets'
    /// centres, and do not determine the values on the rest of a facet.
    ///
    /// # Errors
    /// [`MeshError::UnknownRegion`], which lists the names that exist.
    #[inline(never)]
    pub fn nodes_on(&self, region: &str) -> Result<Vec<u32>, MeshError> {
        let mesh = &self.mesh;
        let mut nodes: Vec<u32> = if let Ok(sides) = mesh.sides_of(region) {
            self.nodes_of(sides.iter().flatten())
        } else if let Ok(cells) = mesh.cell_region(region) {
            cells.iter().flat_map(|&cell| self.cell_nodes(cell as usize)).copied().collect()
        } else {
            return Err(mesh.unknown_region(region));
        };
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// All nodes on a surface, ascending; of a piece of a mesh also those that only other processes' cells have.
    ///
    /// # Errors
    /// Those of [`Mesh::facets_of_surface`].
    pub(crate) fn nodes_on_whole_surface(&self, name: &str) -> Result<Vec<u32>, MeshError> {
        let mut nodes = self.nodes_of(self.mesh.facets_of_surface(name)?.iter());
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// The nodes of facets.
    fn nodes_of<'f>(&self, facets: impl Iterator<Item = &'f Facet>) -> Vec<u32> {
        let mesh = &self.mesh;
        let of_shape = |shape: CellShape| {
            let local = (0..shape.facets()).map(|facet| self.element_of(shape).facet_nodes(facet));
            (shape, local.collect::<Vec<_>>())
        };
        let local: PerShape<_> = mesh.shapes().into_iter().map(of_shape).collect();
        let mut nodes = Vec::new();
        for facet in facets {
            let of_entity = self.nodes_at(facet.cell, Some(facet.local));
            match self.facet_region() {
                Some(_) => nodes.extend_from_slice(of_entity),
                None if of_entity.is_empty() => {}
                None => {
                    let local = &local[mesh.cell_shape(facet.cell as usize)][usize::from(facet.local)];
                    nodes.extend(local.iter().map(|&node| of_entity[node]));
                }
            }
        }
        nodes
    }

    /// Search for cells by position; built at the first call.
    pub fn locator(&self) -> &Locator<D> {
        self.locator.get_or_init(|| Locator::new(&self.mesh))
    }
}

instantiate!(
    space:
    Space::<D>::of,
    Space::<D>::scalar_nodes,
    Space::<D>::numbers_as,
    Space::<D>::nearest_node,
    Space::<D>::nodes_on
);

#[cfg(test)]
mod tests;
