//! Facets of an octree's cells that are parts of larger ones.

use std::collections::HashMap;

use super::{Divided, Origin};
use crate::element::CellShape;
use crate::mesh::facet_parts::FacetParts;
use crate::mesh::{Facet, Mesh};

/// No undivided cell.
const NONE: u32 = u32::MAX;

/// The undivided parts of each divided cell, 2^D places for each.
pub(super) fn leaves_of(divided: &Divided, origins: &[Option<Origin>], parts: usize) -> Vec<Option<u32>> {
    let mut leaves = vec![None; divided.count() * parts];
    for (cell, origin) in origins.iter().enumerate() {
        if let Some(Origin { whole, part }) = origin {
            leaves[*whole as usize * parts + usize::from(*part)] = Some(cell as u32);
        }
    }
    leaves
}

/// The facets of a mesh, whose facets without a partner are still all exterior, that are parts of larger ones.
pub(super) fn facet_parts<const D: usize>(
    mesh: &Mesh<D>,
    divided: &Divided,
    origins: &[Option<Origin>],
) -> FacetParts<D> {
    let shape = mesh.cell_shape(0);
    let key = |vertices: &mut dyn Iterator<Item = u32>| {
        let mut key = [NONE; 4];
        key.iter_mut().zip(vertices).for_each(|(entry, vertex)| *entry = vertex);
        key.sort_unstable();
        key
    };
    let exterior = mesh.boundary_facets().iter();
    let by_vertices: HashMap<[u32; 4], Facet> =
        exterior.map(|facet| (key(&mut mesh.facet_vertices(*facet)), *facet)).collect();
    let leaves = leaves_of(divided, origins, 1 << D);
    let mut found = Vec::new();
    for whole in 0..divided.count() {
        let nodes = divided.cell(whole);
        for local in 0..shape.facets() {
            let vertices = shape.facet_vertices(local);
            let Some(&large) = by_vertices.get(&key(&mut vertices.iter().map(|v| nodes[*v]))) else {
                continue;
            };
            for &part in vertices {
                // By balance a part next to an undivided cell of its whole's size is undivided.
                let Some(cell) = leaves[whole * (1 << D) + part] else { continue };
                let small = Facet { cell, local: local as u8 };
                found.push((small, large, corners(mesh, shape, nodes, (part, local), large)));
            }
        }
    }
    FacetParts::new(found)
}

/// The first, second and last vertex of a part's facet, in reference coordinates of the cell across it: each in the middle between the vertex
/// of the part and another vertex of the divided cell, and the cell across has both.
fn corners<const D: usize>(
    mesh: &Mesh<D>,
    shape: CellShape,
    nodes: &[u32],
    (part, local): (usize, usize),
    large: Facet,
) -> [[f64; D]; 3] {
    let across = mesh.cell_vertices(large.cell as usize);
    let at = |vertex: usize| -> [f64; 3] {
        let place = across.iter().position(|node| *node == nodes[vertex]).unwrap_or(0);
        shape.vertex_points()[place]
    };
    let vertices = shape.facet_vertices(local);
    [0, 1, vertices.len() - 1].map(|corner| {
        let (a, b) = (at(part), at(vertices[corner]));
        std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
    })
}
