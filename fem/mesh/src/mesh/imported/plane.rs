//! Meshes of the plane: one height, and cells that are listed counter-clockwise.

use std::collections::BTreeMap;

use super::contents::{Contents, Node};
use super::problem::{Flaw, ImportProblem, Note, Result};
use crate::element::{CellShape, Lagrange};

// Nodes at different heights are no mesh of the plane.
pub(super) fn check_plane(contents: &Contents, nodes: &[&Node]) -> Result<()> {
    let first = nodes[0];
    let extent = nodes.iter().flat_map(|node| node.position.map(f64::abs)).fold(0.0, f64::max);
    let z = |node: &Node| node.position[2];
    // Files are written with 16 digits.
    match nodes.iter().find(|node| (z(node) - z(first)).abs() > 1e-12 * extent) {
        Some(other) => Err(Flaw::at(
            other.at,
            ImportProblem::NotPlane {
                first: contents.node(first.tag),
                first_z: z(first),
                second: contents.node(other.tag),
                second_z: z(other),
            },
        )),
        None => Ok(()),
    }
}

// The cells of a surface are oriented alike, and clockwise where the surface's normal points down.
pub(super) fn turn_clockwise_surfaces<const D: usize>(
    contents: &Contents,
    nodes: &[[f64; D]],
    (degree, blocks): (usize, &mut [(CellShape, Vec<u32>)]),
    entities: &[i64],
    notes: &mut Vec<Note>,
) {
    let clockwise = |cell: &[u32], vertices: usize| {
        let corner = |k: usize| nodes[cell[k % vertices] as usize];
        // Relative to the first vertex: far from the origin, round-off would decide otherwise.
        let origin = corner(0);
        let twice: f64 = (1..vertices)
            .map(|k| {
                let (a, b) = (corner(k), corner(k + 1));
                (a[0] - origin[0]) * (b[1] - origin[1]) - (b[0] - origin[0]) * (a[1] - origin[1])
            })
            .sum();
        twice < 0.0
    };
    let per_cell = |shape: CellShape| Lagrange { shape, degree }.nodes();
    let mut surfaces: BTreeMap<i64, (usize, usize)> = BTreeMap::new();
    let cells = blocks
        .iter()
        .flat_map(|(shape, cells)| cells.chunks(per_cell(*shape)).map(|cell| (cell, shape.vertices())));
    for ((cell, vertices), entity) in cells.zip(entities) {
        let (all, turned) = surfaces.entry(*entity).or_default();
        *all += 1;
        *turned += usize::from(clockwise(cell, vertices));
    }
    surfaces.retain(|_, (all, turned)| all == turned);
    let mut entities = entities.iter();
    for (shape, cells) in blocks {
        let mirrored: &[usize] = match (*shape, degree) {
            (CellShape::Triangle, 1) => &[0, 2, 1],
            (CellShape::Triangle, _) => &[0, 2, 1, 5, 4, 3],
            (_, 1) => &[0, 3, 2, 1],
            _ => &[0, 3, 2, 1, 7, 6, 5, 4, 8],
        };
        for (cell, entity) in cells.chunks_mut(per_cell(*shape)).zip(&mut entities) {
            if surfaces.contains_key(entity) {
                let old = cell.to_vec();
                for (node, &from) in cell.iter_mut().zip(mirrored) {
                    *node = old[from];
                }
            }
        }
    }
    let part = |entity| (contents.words.part)(entity);
    notes.extend(surfaces.into_iter().map(|(entity, (cells, _))| Note::Turned { part: part(entity), cells }));
}
