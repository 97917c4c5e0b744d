//! Agreement of cells that share a facet: they lie on its two sides, and name the same nodes.

use super::{Facet, Mesh, MeshError};
use crate::element::{CellShape, PerShape};

/// The places of two or more vertices in a cell, and that of the node between them.
type Between = (&'static [usize], usize);

impl<const D: usize> Mesh<D> {
    /// Check that the two cells at each interior facet lie on its two sides and have the same nodes on it, and that all cells
    /// at an edge have the same node in its middle. The cells themselves are taken to be sound: then the order of the
    /// vertices around a facet tells on which side a cell lies.
    pub(super) fn check_shared_facets(&self) -> Result<(), MeshError> {
        for sides in self.interior_facets() {
            self.check_two_sides(sides)?;
        }
        if self.degree == 1 {
            return Ok(());
        }
        let of_shape = |shape: CellShape| {
            let of_facet = |local| self.middle_nodes(shape, local);
            (shape, (0..shape.facets()).map(of_facet).collect::<Vec<_>>())
        };
        let middles: PerShape<_> = self.shapes().into_iter().map(of_shape).collect();
        let on = |facet: Facet| {
            let nodes = self.cell(facet.cell as usize);
            let between = &middles[self.cell_shape(facet.cell as usize)][usize::from(facet.local)];
            between.iter().map(|(corners, middle)| (key(corners.iter().map(|&v| nodes[v])), nodes[*middle]))
        };
        let differ = |vertices: [u32; 4], cells: [u32; 2], nodes: [u32; 2]| {
            let vertices = vertices.into_iter().filter(|vertex| *vertex != u32::MAX).collect();
            Err(MeshError::MiddleNode { cells, nodes, vertices })
        };
        for &[first, second] in self.interior_facets() {
            for (vertices, node) in on(first) {
                let other =
                    on(second).find(|(others, _)| *others == vertices).map_or(node, |(_, other)| other);
                if other != node {
                    return differ(vertices, [first.cell, second.cell], [node, other]);
                }
            }
        }
        // Cells that meet in an edge alone: each lies in a chain of cells that ends at exterior facets.
        let mut exterior: Vec<([u32; 4], u32, u32)> = Vec::new();
        for &facet in self.boundary_facets().iter().filter(|_| D == 3) {
            exterior.extend(on(facet).map(|(vertices, node)| (vertices, node, facet.cell)));
        }
        exterior.sort_unstable();
        for pair in exterior.windows(2) {
            let [(vertices, node, cell), (others, other, next)] = [pair[0], pair[1]];
            if vertices == others && node != other {
                return differ(vertices, [cell, next], [node, other]);
            }
        }
        Ok(())
    }

    /// The order of the vertices around a facet is that of a cell that looks at it from inside: the other cell must see
    /// the opposite one.
    fn check_two_sides(&self, sides: &[Facet; 2]) -> Result<(), MeshError> {
        let [own, other] = sides.map(|facet| key_in_order(self.facet_vertices(facet)));
        let count = self.cell_shape(sides[0].cell as usize).vertices_per_facet();
        let start = other[..count].iter().position(|vertex| *vertex == own[0]).unwrap_or(0);
        let runs = |step: usize| (0..count).all(|k| own[k] == other[(start + k * step) % count]);
        if runs(count - 1) && !(count == 2 && start == 0) {
            return Ok(());
        }
        let cells = sides.map(|facet| facet.cell);
        match runs(1) {
            true => Err(MeshError::SameSide { cells, vertices: own[..count].to_vec() }),
            false => Err(MeshError::TwistedFacet { cells }),
        }
    }

    /// On a facet of a cell of degree 2: the nodes between vertices, in the middle of edges and of the facet itself.
    fn middle_nodes(&self, shape: CellShape, local: usize) -> Vec<Between> {
        let element = self.element_of(shape);
        let nodes = element.facet_nodes(local);
        let corners = shape.facet_vertices(local);
        let inside = &nodes[corners.len()..];
        // Of the cell's edges those on the facet: the nodes inside edges follow the vertices, in the edges' order.
        let edges =
            shape.edges().iter().enumerate().filter(|(_, edge)| edge.iter().all(|v| corners.contains(v)));
        let mut found: Vec<Between> =
            edges.map(|(number, edge)| (&edge[..], shape.vertices() + number)).collect();
        if let Some(&centre) = inside.iter().find(|node| found.iter().all(|(_, known)| known != *node)) {
            found.push((corners, centre));
        }
        found
    }
}

fn key_in_order(vertices: impl Iterator<Item = u32>) -> [u32; 4] {
    let mut key = [u32::MAX; 4];
    for (entry, vertex) in key.iter_mut().zip(vertices) {
        *entry = vertex;
    }
    key
}

fn key(vertices: impl Iterator<Item = u32>) -> [u32; 4] {
    let mut key = key_in_order(vertices);
    key.sort_unstable();
    key
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Lagrange;
    use crate::mesh::{cuboid, rectangle};

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    fn refused<const D: usize>(
        shape: CellShape,
        degree: usize,
        nodes: &[[f64; D]],
        cells: &[u32],
    ) -> Result<String, String> {
        match Mesh::from_parts(shape, degree, nodes.to_vec(), cells.to_vec()) {
            Ok(_) => Err("an invalid mesh was accepted".to_owned()),
            Err(error) => Ok(error.to_string()),
        }
    }

    #[test]
    fn cells_on_one_side_of_their_facet() -> Result<(), String> {
        let side = "lie on the same side of the facet that they share, with the vertices";
        assert_eq!(
            refused(CellShape::Triangle, 1, &SQUARE, &[0, 1, 2, 0, 1, 3])?,
            format!("cells 0 and 1 overlap: they {side} [0, 1]")
        );
        // The same cell twice, and turned.
        assert!(refused(CellShape::Triangle, 1, &SQUARE, &[0, 1, 2, 1, 2, 0])?.contains(side));
        assert!(refused(CellShape::Quadrilateral, 1, &SQUARE, &[0, 1, 2, 3, 0, 1, 2, 3])?.contains(side));
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.4, 0.4, 0.9]];
        assert_eq!(
            refused(CellShape::Tetrahedron, 1, &corners, &[0, 1, 2, 3, 0, 1, 2, 4])?,
            format!("cells 0 and 1 overlap: they {side} [0, 2, 1]")
        );
        // A second cube on the same four vertices, and less high.
        let cube = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Hexahedron, 1).map_err(|e| e.to_string())?;
        let mut nodes = cube.nodes().to_vec();
        let mut cells = cube.cells().to_vec();
        cells.extend_from_slice(&cube.cells()[..4]);
        for &node in &cube.cells()[4..] {
            cells.push(nodes.len() as u32);
            nodes.push(cube.nodes()[node as usize].map(|x| 0.9 * x));
        }
        assert!(refused(CellShape::Hexahedron, 1, &nodes, &cells)?.contains(side));
        Ok(())
    }

    // The side is found where the facet is curved, too.
    #[test]
    fn curved_cells_on_one_side() -> Result<(), String> {
        let nodes = [
            [0.0, 0.0],
            [1.0, 0.0],
            [0.0, 1.0],
            [0.5, -0.2],
            [0.5, 0.5],
            [0.0, 0.5],
            [1.0, 1.0],
            [1.0, 0.5],
            [0.5, 0.55],
        ];
        let error = refused(CellShape::Triangle, 2, &nodes, &[0, 1, 2, 3, 4, 5, 0, 1, 6, 3, 7, 8])?;
        assert!(error.starts_with("cells 0 and 1 overlap"), "{error}");
        Ok(())
    }

    #[test]
    fn neighbours_with_different_nodes_on_an_edge() -> Result<(), String> {
        // Every facet of every pair, and every edge in space, with a copy of its middle node in one of the cells.
        let plane =
            rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 2).map_err(|e| e.to_string())?;
        every_copy(&plane)?;
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            every_copy(&cuboid([0.0; 3], [1.0; 3], [2, 1, 1], shape, 2).map_err(|e| e.to_string())?)?;
        }
        Ok(())
    }

    fn every_copy<const D: usize>(mesh: &Mesh<D>) -> Result<(), String> {
        let shape = mesh.cell_shape(0);
        let element = Lagrange { shape, degree: 2 };
        let uses = |node: u32| mesh.cells().iter().filter(|other| **other == node).count();
        for (place, &node) in mesh.cells().iter().enumerate() {
            if place % element.nodes() < shape.vertices() || uses(node) == 1 {
                continue;
            }
            let (mut nodes, mut cells) = (mesh.nodes().to_vec(), mesh.cells().to_vec());
            cells[place] = nodes.len() as u32;
            nodes.push(nodes[node as usize]);
            let error = refused(shape, 2, &nodes, &cells)?;
            assert!(error.contains("name different nodes"), "{error}");
        }
        Ok(())
    }

    // Two tetrahedra that meet in an edge alone have no facet that would tell.
    #[test]
    fn cells_that_meet_in_an_edge_agree_on_its_middle() -> Result<(), String> {
        let vertices =
            [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let mut nodes: Vec<[f64; 3]> = vertices.to_vec();
        let mut cells = Vec::new();
        for corners in [[0, 2, 3, 1], [0, 4, 5, 1]] {
            cells.extend(corners);
            for edge in CellShape::Tetrahedron.edges() {
                let [a, b] = edge.map(|vertex| vertices[corners[vertex] as usize]);
                cells.push(nodes.len() as u32);
                nodes.push(std::array::from_fn(|k| 0.5 * (a[k] + b[k])));
            }
        }
        let error = refused(CellShape::Tetrahedron, 2, &nodes, &cells)?;
        assert_eq!(
            error,
            "cells 0 and 1 name different nodes, 9 and 15, between the vertices [0, 1] that they share"
        );
        // The middle of the edge from 0 to 1 is the fourth.
        cells[10 + 4 + 3] = cells[4 + 3];
        assert!(Mesh::from_parts(CellShape::Tetrahedron, 2, nodes, cells).is_ok());
        Ok(())
    }
}
