//! Cells of a file with nodes on vertices and edges only, completed to those of the complete quadratic geometry: the map is the same.

use std::collections::HashMap;

use crate::element::{CellShape, Lagrange};

/// Nodes that cells share, and the position of a further one as a sum over them.
pub(in crate::mesh) struct Completed {
    pub(in crate::mesh) nodes: Vec<u32>,
    pub(in crate::mesh) weights: Vec<f64>,
}

/// The nodes that have been added to a file's.
#[derive(Default)]
pub(super) struct Completion {
    /// In the order of their numbers, after the file's nodes.
    pub(super) added: Vec<Completed>,
    of_faces: HashMap<Vec<u32>, u32>,
}

impl Completion {
    /// The cells of a shape with all nodes, from lists without those inside faces and cells; `count` nodes are the file's.
    pub(super) fn complete(&mut self, shape: CellShape, listed: &[u32], count: usize) -> Vec<u32> {
        let element = Lagrange { shape, degree: 2 };
        let per_cell = shape.vertices() + shape.edges().len();
        let mut cells = Vec::with_capacity(listed.len() / per_cell * element.nodes());
        for cell in listed.chunks(per_cell) {
            cells.extend_from_slice(cell);
            if shape == CellShape::Hexahedron {
                for local in 0..shape.facets() {
                    let places = element.facet_nodes(local);
                    let around: Vec<u32> = places[..8].iter().map(|place| cell[*place]).collect();
                    let mut key = around.clone();
                    key.sort_unstable();
                    let next = (count + self.added.len()) as u32;
                    let node = *self.of_faces.entry(key).or_insert(next);
                    if node == next {
                        self.add(around, 4, 0.5);
                    }
                    cells.push(node);
                }
            }
            cells.push((count + self.added.len()) as u32);
            let vertices = shape.vertices();
            self.add(cell.to_vec(), vertices, if vertices == 4 { 0.5 } else { 0.25 });
        }
        cells
    }

    /// The centre of a face or a cell: serendipity functions are −¼ there at the vertices, and have this value at the edges.
    fn add(&mut self, nodes: Vec<u32>, vertices: usize, at_edges: f64) {
        let weights = (0..nodes.len()).map(|place| if place < vertices { -0.25 } else { at_edges });
        self.added.push(Completed { weights: weights.collect(), nodes });
    }
}

impl Completed {
    /// The sum of values at the nodes, each of some components.
    pub(in crate::mesh) fn sum(&self, values: &[f64], components: usize) -> Vec<f64> {
        let mut sums = vec![0.0; components];
        for (node, weight) in self.nodes.iter().zip(&self.weights) {
            let of_node = &values[*node as usize * components..][..components];
            sums.iter_mut().zip(of_node).for_each(|(sum, value)| *sum += weight * value);
        }
        sums
    }
}
