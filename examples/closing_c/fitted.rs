//! The body of densities as a mesh of triangles that fits it: where the smooth densities are above ½.

use std::collections::HashMap;
use std::error::Error;

use forms_fem::mesh::{MeshError, Remeshing, Sizes};
use forms_fem::prelude::*;

use crate::design::{Closing, LOWER};

/// A crossing of an edge that is nearer to a node than this part of the edge is moved into the node: shorter edges of the outline would ask for as small triangles.
const NEAR: f64 = 0.1;

/// Nodes, triangles, and values that are negative in the body.
#[derive(Default)]
struct Outline {
    nodes: Vec<[f64; 2]>,
    values: Vec<f64>,
    crossings: HashMap<[usize; 2], usize>,
    cells: Vec<u32>,
}

/// The arm and the body below it, without parts of the body that nothing holds. Edges are at most as long as the factor times those of the densities' cells.
pub fn fitted(c: &Closing, smooth: &Field<2>, factor: f64) -> Result<Mesh<2>, Box<dyn Error>> {
    let mut outline = Outline { nodes: smooth.space().positions().to_vec(), ..Outline::default() };
    outline.values = smooth.values().iter().map(|density| 0.5 - density).collect();
    let design = c.mesh().cell_region("design")?;
    // φ is linear on two triangles of each square, as for bodies that are cut from quadrilaterals.
    let halves = |cell: &u32| {
        let nodes = smooth.space().cell_nodes(*cell as usize);
        [[0, 1, 2], [0, 2, 3]].map(|half| half.map(|corner| nodes[corner] as usize))
    };
    let triangles: Vec<[usize; 3]> = design.iter().flat_map(halves).collect();
    outline.snap(&triangles);
    triangles.iter().for_each(|triangle| outline.add(*triangle));
    let size = factor * LOWER / (0.625 * c.across as f64);
    let body = Remeshing::new(Sizes::between(0.25 * size, size)).remesh(&held(outline)?)?;
    let arm = c.mesh().part("arm")?.mesh;
    Ok(Mesh::of_bodies(&[("upper body", &arm), ("lower body", &body)])?)
}

impl Outline {
    /// Moves crossings that are near to nodes into them.
    fn snap(&mut self, triangles: &[[usize; 3]]) {
        let before = self.values.clone();
        for [i, j] in triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]) {
            let (one, other) = (before[i], before[j]);
            for (node, part) in [(i, one / (one - other)), (j, other / (other - one))] {
                if one * other < 0.0 && part < NEAR {
                    self.values[node] = 0.0;
                }
            }
        }
    }

    /// The part of a triangle in the body.
    fn add(&mut self, triangle: [usize; 3]) {
        if triangle.iter().all(|node| self.values[*node] >= 0.0) {
            return;
        }
        let mut corners = vec![];
        for (k, &node) in triangle.iter().enumerate() {
            let next = triangle[(k + 1) % 3];
            if self.values[node] <= 0.0 {
                corners.push(node as u32);
            }
            if self.values[node] * self.values[next] < 0.0 {
                corners.push(self.crossing([node.min(next), node.max(next)]) as u32);
            }
        }
        for pair in corners[1..].windows(2) {
            self.cells.extend([corners[0], pair[0], pair[1]]);
        }
    }

    /// The node where an edge crosses the level.
    fn crossing(&mut self, [i, j]: [usize; 2]) -> usize {
        let (nodes, values) = (&mut self.nodes, &self.values);
        *self.crossings.entry([i, j]).or_insert_with(|| {
            let part = values[i] / (values[i] - values[j]);
            let place = [0, 1].map(|k| (1.0 - part) * nodes[i][k] + part * nodes[j][k]);
            nodes.push(place);
            nodes.len() - 1
        })
    }
}

/// The mesh of the parts that reach the clamped side.
fn held(outline: Outline) -> Result<Mesh<2>, MeshError> {
    // Nodes of the body only.
    let mut used: Vec<u32> = outline.cells.clone();
    used.sort_unstable();
    used.dedup();
    let nodes = used.iter().map(|node| outline.nodes[*node as usize]).collect();
    let cells = outline.cells.iter().map(|node| used.partition_point(|other| other < node) as u32);
    let mut mesh = Mesh::from_parts(CellShape::Triangle, 1, nodes, cells.collect())?;
    mesh.name_facets("clamped side", "boundary", |x| x[0] < 1e-9)?;
    let mut is_held = vec![false; mesh.cell_count()];
    mesh.facet_region("clamped side")?.iter().for_each(|facet| is_held[facet.cell as usize] = true);
    loop {
        let before = is_held.clone();
        for sides in mesh.interior_facets() {
            let [one, other] = sides.map(|side| side.cell as usize);
            let either = is_held[one] || is_held[other];
            (is_held[one], is_held[other]) = (either, either);
        }
        if is_held == before {
            break;
        }
    }
    let cells: Vec<u32> = (0..mesh.cell_count() as u32).filter(|cell| is_held[*cell as usize]).collect();
    mesh.name_listed_cells("held", &cells)?;
    Ok(mesh.part("held")?.mesh)
}
