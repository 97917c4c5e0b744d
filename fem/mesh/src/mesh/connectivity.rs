//! Checks of node numbers, and which facets are interior or exterior.

use std::cmp::Ordering;

use super::{CellBlock, CellLists, Facet, MeshError};
use crate::element::{CellShape, Lagrange};

pub(super) fn check_nodes<const D: usize>(nodes: &[[f64; D]]) -> Result<(), MeshError> {
    if u32::try_from(nodes.len()).is_err() {
        return Err(MeshError::TooLarge { what: "nodes" });
    }
    match nodes.iter().position(|position| position.iter().any(|x| !x.is_finite())) {
        Some(node) => Err(MeshError::NotFinite { node, position: nodes[node].to_vec() }),
        None => Ok(()),
    }
}

/// Blocks with cells and the nodes of all cells, from each block's shape and nodes. Nothing is said of the nodes yet.
pub(super) fn check_blocks<const D: usize>(
    degree: usize,
    given: Vec<(CellShape, Vec<u32>)>,
) -> Result<(Vec<CellBlock>, Vec<u32>), MeshError> {
    let mut blocks: Vec<CellBlock> = Vec::with_capacity(given.len());
    let mut all = Vec::new();
    for (shape, cells) in given {
        let per_cell = Lagrange::geometry(shape, degree)?.nodes();
        if shape.dimension() != D {
            return Err(MeshError::Dimension { shape, dimension: D });
        }
        if cells.is_empty() {
            continue;
        }
        if !cells.len().is_multiple_of(per_cell) {
            return Err(MeshError::CellLength { length: cells.len(), per_cell });
        }
        // Faces of two shapes in space are triangles and squares, which do not meet.
        if let Some(first) = blocks.first().filter(|first| D == 3 && first.shape != shape) {
            return Err(MeshError::ShapesTogether { shapes: [first.shape, shape] });
        }
        let start = blocks.last().map_or(0, |last| last.cells.end);
        let end = start + cells.len() / per_cell;
        if u32::try_from(end).is_err() {
            return Err(MeshError::TooLarge { what: "cells" });
        }
        match blocks.last_mut() {
            Some(last) if last.shape == shape => last.cells.end = end,
            _ => blocks.push(CellBlock { shape, cells: start..end }),
        }
        if all.is_empty() {
            all = cells;
        } else {
            all.extend(cells);
        }
    }
    if blocks.is_empty() {
        return Err(MeshError::Empty);
    }
    Ok((blocks, all))
}

pub(super) fn check_cells(lists: &CellLists, count: usize, cells: &[u32]) -> Result<(), MeshError> {
    for (cell, nodes) in lists.chunks(cells).enumerate() {
        for (position, &node) in nodes.iter().enumerate() {
            if node as usize >= count {
                return Err(MeshError::NodeRange { cell, node, count });
            }
            if nodes[..position].contains(&node) {
                return Err(MeshError::RepeatedNode { cell, node });
            }
        }
    }
    Ok(())
}

/// The sorted vertices of a facet, filled up with the largest number: equal for the two sides.
fn key(vertices: &[usize], nodes: &[u32]) -> [u32; 4] {
    let mut key = [u32::MAX; 4];
    for (entry, &vertex) in key.iter_mut().zip(vertices) {
        *entry = nodes[vertex];
    }
    key.sort_unstable();
    key
}

type Facets = (Vec<Facet>, Vec<[Facet; 2]>);

/// Exterior facets, and pairs of the two sides of interior ones, both in ascending order.
pub(super) fn match_facets(
    blocks: &[CellBlock],
    lists: &CellLists,
    cells: &[u32],
) -> Result<Facets, MeshError> {
    let places = CellLists::new(blocks, CellShape::facets);
    let sides = sides_by_first_vertex(blocks, lists, cells, places.length());
    // The other side of each facet, itself where there is none: in the order of the facets nothing is left to sort.
    let mut other_side = vec![Facet { cell: 0, local: 0 }; places.length()];
    let place = |facet: &Facet| places.of(facet.cell as usize).start + usize::from(facet.local);
    let (mut exterior_count, mut interior_count) = (0, 0);
    for same in sides.chunk_by(|a, b| a.0 == b.0) {
        match same {
            [(_, facet)] => {
                other_side[place(facet)] = *facet;
                exterior_count += 1;
            }
            [(_, first), (_, second)] => {
                other_side[place(first)] = *second;
                other_side[place(second)] = *first;
                interior_count += 1;
            }
            _ => {
                return Err(MeshError::SharedFacet {
                    vertices: same[0].0.into_iter().filter(|&vertex| vertex != u32::MAX).collect(),
                    cells: same.iter().map(|(_, facet)| facet.cell).collect(),
                });
            }
        }
    }
    let (mut exterior, mut interior) =
        (Vec::with_capacity(exterior_count), Vec::with_capacity(interior_count));
    for (cell, others) in places.chunks(&other_side).enumerate() {
        for (local, other) in others.iter().enumerate() {
            let facet = Facet { cell: cell as u32, local: local as u8 };
            match facet.cmp(other) {
                Ordering::Equal => exterior.push(facet),
                Ordering::Less => interior.push([facet, *other]),
                Ordering::Greater => {}
            }
        }
    }
    Ok((exterior, interior))
}

/// All sides of facets with their keys, in ascending order: counted by their smallest vertex, and sorted among the few that
/// share it.
fn sides_by_first_vertex(
    blocks: &[CellBlock],
    lists: &CellLists,
    cells: &[u32],
    count: usize,
) -> Vec<([u32; 4], Facet)> {
    let for_each = |call: &mut dyn FnMut([u32; 4], Facet)| {
        for block in blocks {
            for cell in block.cells.clone() {
                let nodes = &cells[lists.of(cell)];
                for local in 0..block.shape.facets() {
                    let facet = Facet { cell: cell as u32, local: local as u8 };
                    call(key(block.shape.facet_vertices(local), nodes), facet);
                }
            }
        }
    };
    // Beyond the last node, so that the place after each node's sides is known.
    let mut starts = vec![0_usize; cells.iter().max().map_or(0, |largest| *largest as usize) + 2];
    for_each(&mut |key, _| starts[key[0] as usize + 1] += 1);
    for node in 1..starts.len() {
        starts[node] += starts[node - 1];
    }
    let mut sides = vec![([0; 4], Facet { cell: 0, local: 0 }); count];
    let mut next = starts.clone();
    for_each(&mut |key, facet| {
        let place = &mut next[key[0] as usize];
        sides[*place] = (key, facet);
        *place += 1;
    });
    for node in starts.windows(2) {
        sides[node[0]..node[1]].sort_unstable();
    }
    sides
}

#[cfg(test)]
mod tests {
    use crate::element::CellShape;
    use crate::mesh::{Facet, Mesh};

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    fn triangles(nodes: &[[f64; 2]], cells: &[u32]) -> Result<Mesh<2>, String> {
        Mesh::from_parts(CellShape::Triangle, 1, nodes.to_vec(), cells.to_vec())
            .map_err(|error| error.to_string())
    }

    #[test]
    fn two_triangles_share_one_facet() -> Result<(), String> {
        let mesh = triangles(&SQUARE, &[0, 1, 2, 0, 2, 3])?;
        let facet = |cell, local| Facet { cell, local };
        assert_eq!(mesh.boundary_facets(), [facet(0, 0), facet(0, 1), facet(1, 1), facet(1, 2)]);
        assert_eq!(mesh.interior_facets(), [[facet(0, 2), facet(1, 0)]]);
        assert_eq!((mesh.facet_count(), mesh.cell_count(), mesh.node_count()), (5, 2, 4));
        Ok(())
    }

    #[test]
    fn wrong_cells_are_named() {
        let error = |nodes: &[[f64; 2]], cells: &[u32]| triangles(nodes, cells).err().unwrap_or_default();
        assert_eq!(
            error(&SQUARE, &[0, 1, 2, 0, 2, 4]),
            "cell 1 names node 4, but the mesh has 4 nodes (numbered from 0)"
        );
        assert_eq!(error(&SQUARE, &[0, 1, 2, 2, 2, 3]), "cell 1 names node 2 twice");
        assert_eq!(
            error(&SQUARE, &[0, 1, 2, 3]),
            "the cells list 4 node numbers, which is not a multiple of 3, the nodes of a cell"
        );
        assert_eq!(error(&SQUARE, &[]), "the mesh has no cells");
        assert_eq!(
            error(&[[0.0, 0.0], [1.0, f64::NAN]], &[0, 1, 1]),
            "node 1 has a coordinate that is not finite: [1.0, NaN]"
        );
        assert!(error(&SQUARE, &[0, 1, 2, 0, 3, 2]).starts_with("cell 1 is inverted or degenerate"));
        let five = [SQUARE.as_slice(), &[[2.0, 2.0]]].concat();
        assert!(error(&five, &[0, 2, 4]).starts_with("cell 0 is inverted or degenerate"));
        // An edge whose length has no reciprocal: found by a mutated file.
        let edge = [[0.0, 0.0], [1e-310, 0.0], [0.0, 1.0]];
        assert!(error(&edge, &[0, 1, 2]).starts_with("cell 0 is inverted or degenerate"));
        let fan = [SQUARE.as_slice(), &[[0.2, 0.9]]].concat();
        assert_eq!(
            error(&fan, &[0, 1, 2, 0, 2, 3, 0, 2, 4]),
            "the facet with vertices [0, 2] belongs to more than two cells: [0, 1, 2]"
        );
    }

    #[test]
    fn dimension_and_degree_must_fit() {
        let error = |shape, degree| {
            Mesh::from_parts(shape, degree, SQUARE.to_vec(), vec![0, 1, 2, 3])
                .map(|_| ())
                .map_err(|error| error.to_string())
        };
        assert_eq!(
            error(CellShape::Tetrahedron, 1),
            Err("a mesh of tetrahedron cells has 3 dimensions, not 2".into())
        );
        assert!(error(CellShape::Quadrilateral, 3).is_err());
        assert_eq!(error(CellShape::Quadrilateral, 1), Ok(()));
    }

    #[test]
    fn a_folded_quadratic_cell_is_found() {
        let mut nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
        let mesh = |nodes: &Vec<[f64; 2]>| {
            Mesh::from_parts(CellShape::Triangle, 2, nodes.clone(), (0..6).collect()).is_ok()
        };
        assert!(mesh(&nodes));
        // A midpoint beyond a quarter of its edge folds the map at the vertex.
        nodes[3] = [0.2, 0.0];
        assert!(!mesh(&nodes));
    }
}
