//! Finite element spaces: unknowns on the nodes of a mesh.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use thiserror::Error;

use crate::element::{ElementError, Lagrange};
use crate::locate::Locator;
use crate::mesh::{Mesh, MeshError};

/// A Lagrange space with a number of components per node. Unknown number = node * components + component.
///
/// Nodes are numbered in the order in which the cells first use them.
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
    // Built when a field is first evaluated at a point.
    locator: OnceLock<Locator<D>>,
}

/// Why a space does not exist.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SpaceError {
    /// No such element.
    #[error(transparent)]
    Element(#[from] ElementError),
    /// Unknowns are numbered with `u32`.
    #[error("the space would have {unknowns} unknowns, more than 4294967295")]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
    },
}

impl<const D: usize> Space<D> {
    /// The scalar Lagrange space of a degree, which need not be that of the geometry.
    ///
    /// # Errors
    /// [`SpaceError::Element`] unless the degree is 1 or 2; [`SpaceError::TooLarge`].
    pub fn scalar(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, degree, vec![])
    }

    /// The space of vectors with D components.
    ///
    /// # Errors
    /// As [`Space::scalar`].
    pub fn vector(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, degree, vec![D])
    }

    /// The space of tensors with D × D components, row-major.
    ///
    /// # Errors
    /// As [`Space::scalar`].
    pub fn tensor(mesh: &Arc<Mesh<D>>, degree: usize) -> Result<Arc<Self>, SpaceError> {
        Space::new(mesh, degree, vec![D, D])
    }

    fn new(mesh: &Arc<Mesh<D>>, degree: usize, shape: Vec<usize>) -> Result<Arc<Self>, SpaceError> {
        let element = Lagrange::new(mesh.shape(), degree)?;
        let cell_nodes = number_nodes(mesh, &element);
        let positions = node_positions(mesh, &element, &cell_nodes);
        let unknowns = positions.len() * shape.iter().product::<usize>();
        if u32::try_from(unknowns).is_err() {
            return Err(SpaceError::TooLarge { unknowns });
        }
        let mesh = Arc::clone(mesh);
        Ok(Arc::new(Space { mesh, element, shape, cell_nodes, positions, locator: OnceLock::new() }))
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh<D>> {
        &self.mesh
    }

    /// The element.
    pub fn element(&self) -> Lagrange {
        self.element
    }

    /// The polynomial degree.
    pub fn degree(&self) -> usize {
        self.element.degree
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
    pub fn unknowns(&self) -> usize {
        self.node_count() * self.components()
    }

    /// Nodes of a cell, in the order of the element's nodes.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    pub fn cell_nodes(&self, cell: usize) -> &[u32] {
        let count = self.element.nodes();
        &self.cell_nodes[cell * count..(cell + 1) * count]
    }

    /// Nodes of all cells, cell after cell.
    pub fn all_cell_nodes(&self) -> &[u32] {
        &self.cell_nodes
    }

    /// Position of each node \[length\].
    pub fn positions(&self) -> &[[f64; D]] {
        &self.positions
    }

    /// All nodes on a facet region or in a cell region, ascending.
    ///
    /// # Errors
    /// [`MeshError::UnknownRegion`], which lists the names that exist.
    pub fn nodes_on(&self, region: &str) -> Result<Vec<u32>, MeshError> {
        let mesh = &self.mesh;
        let mut nodes: Vec<u32> = if let Ok(facets) = mesh.facet_region(region) {
            let local: Vec<Vec<usize>> =
                (0..mesh.shape().facets()).map(|facet| self.element.facet_nodes(facet)).collect();
            let of_facet = |facet: &crate::mesh::Facet| {
                let cell = self.cell_nodes(facet.cell as usize);
                local[usize::from(facet.local)].iter().map(|&node| cell[node])
            };
            facets.iter().flat_map(of_facet).collect()
        } else if let Ok(cells) = mesh.cell_region(region) {
            cells.iter().flat_map(|&cell| self.cell_nodes(cell as usize)).copied().collect()
        } else {
            return Err(MeshError::UnknownRegion {
                name: region.to_owned(),
                cells: mesh.cell_region_names().map(str::to_owned).collect(),
                facets: mesh.facet_region_names().map(str::to_owned).collect(),
            });
        };
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Finds cells by position; built at the first call.
    pub fn locator(&self) -> &Locator<D> {
        self.locator.get_or_init(|| Locator::new(&self.mesh))
    }
}

const UNNUMBERED: u32 = u32::MAX;

// Cells share the nodes of the vertices, edges and faces that they share; an edge or face is known by its
// sorted vertices.
fn number_nodes<const D: usize>(mesh: &Mesh<D>, element: &Lagrange) -> Vec<u32> {
    let shape = element.shape;
    let mut next = 0;
    let mut fresh = || {
        next += 1;
        next - 1
    };
    let mut of_vertex = vec![UNNUMBERED; mesh.node_count()];
    let mut of_entity: HashMap<[u32; 4], u32> = HashMap::new();
    let mut cell_nodes = Vec::with_capacity(mesh.cell_count() * element.nodes());
    for cell in 0..mesh.cell_count() {
        let vertices = &mesh.cell(cell)[..shape.vertices()];
        for &vertex in vertices {
            let node = &mut of_vertex[vertex as usize];
            if *node == UNNUMBERED {
                *node = fresh();
            }
            cell_nodes.push(*node);
        }
        if element.degree == 1 {
            continue;
        }
        let mut shared = |entity: &[usize]| {
            let mut key = [u32::MAX; 4];
            for (entry, &vertex) in key.iter_mut().zip(entity) {
                *entry = vertices[vertex];
            }
            key.sort_unstable();
            cell_nodes.push(*of_entity.entry(key).or_insert_with(&mut fresh));
        };
        for edge in shape.edges() {
            shared(edge);
        }
        if shape.dimension() == 3 && !shape.is_simplex() {
            for local in 0..shape.facets() {
                shared(shape.facet_vertices(local));
            }
        }
        if !shape.is_simplex() {
            cell_nodes.push(fresh());
        }
    }
    cell_nodes
}

fn node_positions<const D: usize>(mesh: &Mesh<D>, element: &Lagrange, cell_nodes: &[u32]) -> Vec<[f64; D]> {
    let count = cell_nodes.iter().max().map_or(0, |last| *last as usize + 1);
    let mut positions = vec![[0.0; D]; count];
    let mut placed = vec![false; count];
    let tables = mesh.element().tabulate(&element.node_points::<D>());
    for (cell, nodes) in cell_nodes.chunks(element.nodes()).enumerate() {
        let geometry = mesh.cell(cell);
        for (q, &node) in nodes.iter().enumerate() {
            if std::mem::replace(&mut placed[node as usize], true) {
                continue;
            }
            let phi = &tables.value[q * tables.nodes..(q + 1) * tables.nodes];
            let position = &mut positions[node as usize];
            for (phi, &corner) in phi.iter().zip(geometry) {
                for (x, corner) in position.iter_mut().zip(mesh.nodes()[corner as usize]) {
                    *x += phi * corner;
                }
            }
        }
    }
    positions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::{annulus, cuboid, rectangle};

    #[test]
    fn counts_follow_from_euler() -> Result<(), Box<dyn std::error::Error>> {
        // Vertices + edges + faces + centres of structured grids, closed forms.
        for geometry in 1..=2 {
            for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
                let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [3, 4], shape, geometry)?);
                assert_eq!(Space::scalar(&mesh, 1)?.node_count(), 4 * 5);
                let space = Space::vector(&mesh, 2)?;
                assert_eq!((space.node_count(), space.unknowns()), (7 * 9, 2 * 7 * 9));
                assert_eq!(space.nodes_on("left")?.len(), 9);
                assert_eq!(space.nodes_on("boundary")?.len(), 2 * (6 + 8));
                assert_eq!(space.nodes_on("all")?.len(), 7 * 9);
            }
            for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
                let mesh = Arc::new(cuboid([0.0; 3], [1.0; 3], [1, 2, 3], shape, geometry)?);
                assert_eq!(Space::scalar(&mesh, 1)?.node_count(), 2 * 3 * 4);
                let space = Space::tensor(&mesh, 2)?;
                assert_eq!((space.node_count(), space.components()), (3 * 5 * 7, 9));
                assert_eq!(space.nodes_on("bottom")?.len(), 3 * 5);
            }
        }
        Ok(())
    }

    // The numbering shares exactly the nodes that coincide, in order of first use.
    #[test]
    fn nodes_are_shared_where_they_coincide() -> Result<(), Box<dyn std::error::Error>> {
        for (shape, geometry) in [(CellShape::Tetrahedron, 1), (CellShape::Hexahedron, 2)] {
            let mesh = Arc::new(cuboid([0.0; 3], [1.0, 2.0, 4.0], [2, 2, 2], shape, geometry)?);
            let space = Space::scalar(&mesh, 2)?;
            let points = space.element().node_points::<3>();
            let mut next = 0;
            for cell in 0..mesh.cell_count() {
                for (&node, point) in space.cell_nodes(cell).iter().zip(&points) {
                    assert!(node <= next);
                    next = next.max(node + 1);
                    let (x, _) = mesh.map(cell, point);
                    let position = space.positions()[node as usize];
                    assert!((0..3).all(|k| (x[k] - position[k]).abs() < 1e-14));
                }
            }
            let mut places: Vec<_> = space.positions().iter().map(|x| x.map(|x| (16.0 * x) as i64)).collect();
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), space.node_count());
        }
        Ok(())
    }

    #[test]
    fn positions_follow_the_curved_geometry() -> Result<(), Box<dyn std::error::Error>> {
        let mesh = Arc::new(annulus(1.0, 2.0, 1, 6, CellShape::Quadrilateral, 2)?);
        let space = Space::scalar(&mesh, 2)?;
        for node in space.nodes_on("outer")? {
            let [x, y] = space.positions()[node as usize];
            assert!((x.hypot(y) - 2.0).abs() < 1e-15);
        }
        // On straight cells the midpoints are on chords.
        let mesh = Arc::new(annulus(1.0, 2.0, 1, 6, CellShape::Quadrilateral, 1)?);
        let space = Space::scalar(&mesh, 2)?;
        let radii = space.nodes_on("outer")?;
        let radii = radii.iter().map(|&node| space.positions()[node as usize]).map(|[x, y]| x.hypot(y));
        assert_eq!(radii.filter(|radius| (radius - 3f64.sqrt()).abs() < 1e-14).count(), 6);
        Ok(())
    }

    #[test]
    fn errors_name_degree_and_region() -> Result<(), Box<dyn std::error::Error>> {
        let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?);
        assert!(matches!(Space::scalar(&mesh, 3), Err(SpaceError::Element(_))));
        let message = Space::scalar(&mesh, 1)?.nodes_on("lid").err().map(|error| error.to_string());
        assert_eq!(
            message.as_deref(),
            Some(
                "there is no region \"lid\"; the mesh has the cell regions \"all\" and the facet regions \
                 \"bottom\", \"boundary\", \"left\", \"right\", \"top\""
            )
        );
        Ok(())
    }
}
