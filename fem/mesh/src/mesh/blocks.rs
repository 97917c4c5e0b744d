//! Meshes of blocks that meet: cells name their nodes by keys, and equal keys are one node.

use std::collections::HashMap;
use std::hash::Hash;

use super::{Facet, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};

/// A node of a block: its key, its position, and the surfaces that it lies on, as bits.
pub(super) struct BlockNode<K, const D: usize> {
    pub(super) key: K,
    pub(super) position: [f64; D],
    pub(super) surfaces: u8,
}

/// Quadrilaterals or hexahedra, cell by cell.
pub(super) struct Blocks<K, const D: usize> {
    element: Lagrange,
    /// Places of the element's nodes, in steps of 1/degree.
    steps: Vec<[usize; D]>,
    numbers: HashMap<K, u32>,
    nodes: Vec<[f64; D]>,
    surfaces: Vec<u8>,
    cells: Vec<u32>,
}

impl<K: Eq + Hash, const D: usize> Blocks<K, D> {
    pub(super) fn new(shape: CellShape, degree: usize) -> Result<Self, MeshError> {
        let element = Lagrange::geometry(shape, degree)?;
        let whole = |point: [f64; D]| point.map(|x| (degree as f64 * x).round() as usize);
        let steps = element.node_points::<D>().into_iter().map(whole).collect();
        Ok(Blocks { element, steps, numbers: HashMap::new(), nodes: vec![], surfaces: vec![], cells: vec![] })
    }

    /// A cell; `node` gives the node at a place, in steps of 1/degree from the cell's first corner.
    pub(super) fn add_cell(&mut self, node: impl Fn([usize; D]) -> BlockNode<K, D>) {
        for &steps in &self.steps {
            let node = node(steps);
            let number = *self.numbers.entry(node.key).or_insert_with(|| {
                self.nodes.push(node.position);
                self.surfaces.push(node.surfaces);
                self.nodes.len() as u32 - 1
            });
            self.cells.push(number);
        }
    }

    /// The mesh; the facets whose vertices all lie on the surface of a bit are the region of its name.
    pub(super) fn mesh(self, surfaces: &[(u8, &str)]) -> Result<Mesh<D>, MeshError> {
        let Lagrange { shape, degree } = self.element;
        let mut mesh = Mesh::from_parts(shape, degree, self.nodes, self.cells)?;
        for &(bit, name) in surfaces {
            let lies_on = |facet: &&Facet| {
                let nodes = mesh.cell(facet.cell as usize);
                let vertices = shape.facet_vertices(usize::from(facet.local));
                vertices.iter().all(|&vertex| self.surfaces[nodes[vertex] as usize] & bit != 0)
            };
            let facets = mesh.boundary_facets().iter().filter(lies_on).copied().collect();
            mesh.insert_facets(name, facets)?;
        }
        Ok(mesh)
    }
}
