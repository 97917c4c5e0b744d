//! Quadrilaterals divided into triangles, hexahedra into tetrahedra.

use super::{CellLists, Facet, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};
use crate::instantiate;

impl<const D: usize> Mesh<D> {
    /// The mesh with each quadrilateral divided into two triangles, each hexahedron into six tetrahedra, on the same nodes;
    /// triangles and tetrahedra as they are. Regions are kept.
    ///
    /// Diagonals begin at the vertex with the smallest number, so that neighbours agree on them; J. Dompierre et al., How
    /// to subdivide pyramids, prisms and hexahedra into tetrahedra (1999).
    ///
    /// # Errors
    /// [`MeshError::Inverted`] where a cell is so distorted that a part of it is inverted, [`MeshError::TooLarge`].
    #[inline(never)]
    pub fn simplices(&self) -> Result<Self, MeshError> {
        let parts_of = |shape| match shape {
            CellShape::Triangle | CellShape::Tetrahedron => 1,
            CellShape::Quadrilateral => 2,
            CellShape::Hexahedron => 6,
        };
        self.without_rigid_surfaces("division into simplices")?;
        self.without_facet_parts("division into simplices")?;
        if self.shapes().into_iter().all(CellShape::is_simplex) {
            return Ok(self.clone());
        }
        let shape = if D == 2 { CellShape::Triangle } else { CellShape::Tetrahedron };
        // The numbers of the parts of each cell.
        let parts = CellLists::new(self.blocks(), parts_of);
        if u32::try_from(parts.length()).is_err() {
            return Err(MeshError::TooLarge { what: "cells" });
        }
        let mut cells = Vec::new();
        // The parts by their vertices, numbered in the cell.
        let mut all_vertices: Vec<Vec<usize>> = Vec::with_capacity(parts.length());
        for block in self.blocks() {
            let middle = middles::<D>(&self.element_of(block.shape));
            for cell in block.cells.clone() {
                let nodes = self.cell(cell);
                for vertices in divide(block.shape, nodes) {
                    cells.extend(vertices.iter().map(|&vertex| nodes[vertex]));
                    if self.degree == 2 {
                        let edges = shape.edges().iter();
                        cells.extend(edges.map(|&[a, b]| nodes[middle[vertices[a]][vertices[b]]]));
                    }
                    all_vertices.push(vertices);
                }
            }
        }
        // Every face and every cell has one diagonal, so that the nodes in their middles are used.
        let mut mesh = Mesh::of_sound_cells(self.degree, self.nodes.clone(), vec![(shape, cells)])?;
        let small_facets = |facet: Facet| {
            let large = self.cell_shape(facet.cell as usize).facet_vertices(usize::from(facet.local));
            let cells = parts.of(facet.cell as usize);
            let mut found = Vec::with_capacity(2);
            for cell in cells {
                for local in 0..shape.facets() {
                    let vertices = shape.facet_vertices(local).iter().map(|&v| all_vertices[cell][v]);
                    if vertices.into_iter().all(|vertex| large.contains(&vertex)) {
                        found.push(Facet { cell: cell as u32, local: local as u8 });
                    }
                }
            }
            found
        };
        let parts_of = |cell: u32| {
            let parts = parts.of(cell as usize);
            parts.start as u32..parts.end as u32
        };
        mesh.inherit_regions(self, &parts_of, &small_facets)?;
        Ok(mesh)
    }
}

/// For each pair of vertices the node half way between them: on an edge, a face or inside.
fn middles<const D: usize>(element: &Lagrange) -> Vec<Vec<usize>> {
    let points = element.node_points::<D>();
    let count = element.shape.vertices();
    let node = |a: usize, b: usize| {
        let middle: [f64; D] = std::array::from_fn(|k| 0.5 * (points[a][k] + points[b][k]));
        points.iter().position(|point| *point == middle).unwrap_or(a)
    };
    (0..count).map(|a| (0..count).map(|b| node(a, b)).collect()).collect()
}

/// The simplices of a cell, each as vertices of the cell: a cone from the vertex with the smallest number over the
/// triangles (in the plane: edges) of the facets that do not have it.
fn divide(shape: CellShape, nodes: &[u32]) -> Vec<Vec<usize>> {
    if shape.is_simplex() {
        return vec![(0..shape.vertices()).collect()];
    }
    let smallest =
        |vertices: &mut dyn Iterator<Item = usize>| vertices.min_by_key(|&v| nodes[v]).unwrap_or(0);
    let apex = smallest(&mut (0..shape.vertices()));
    let mut simplices = Vec::with_capacity(6);
    for local in 0..shape.facets() {
        let facet = shape.facet_vertices(local);
        if facet.contains(&apex) {
            continue;
        }
        if facet.len() == 2 {
            simplices.push(vec![apex, facet[0], facet[1]]);
            continue;
        }
        let first = smallest(&mut facet.iter().copied());
        let start = facet.iter().position(|&vertex| vertex == first).unwrap_or(0);
        let corner = |k: usize| facet[(start + k) % 4];
        // A facet's vertices run counter-clockwise seen from outside, those before a tetrahedron's last one clockwise.
        for k in 1..=2 {
            simplices.push(vec![corner(0), corner(k + 1), corner(k), apex]);
        }
    }
    simplices
}

instantiate!(simplices: Mesh::<D>::simplices);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::measures::{close, surface, volume};
    use crate::mesh::{INTERIOR, annulus, structured};

    fn check<const D: usize>(mesh: &Mesh<D>) -> Result<(), MeshError> {
        let simplices = mesh.simplices()?;
        assert!(simplices.shapes()[0].is_simplex() && simplices.degree() == mesh.degree());
        assert_eq!(simplices.nodes(), mesh.nodes());
        let (parts, per_facet) = if D == 2 { (2, 1) } else { (6, 2) };
        assert_eq!(simplices.cell_count(), parts * mesh.cell_count());
        // Neighbours agree on diagonals: no new boundary appears.
        assert_eq!(simplices.boundary_facets().len(), per_facet * mesh.boundary_facets().len());
        for name in mesh.cell_region_names() {
            assert_eq!(simplices.cell_region(name)?.len(), parts * mesh.cell_region(name)?.len());
        }
        for name in mesh.facet_region_names().chain(mesh.interior_facet_region_names()) {
            if name != INTERIOR {
                assert_eq!(simplices.sides_of(name)?.len(), per_facet * mesh.sides_of(name)?.len());
                close(surface(&simplices, name)?.0, surface(mesh, name)?.0, 1e-3);
            }
        }
        close(volume(&simplices), volume(mesh), 1e-3);
        Ok(())
    }

    #[test]
    fn regions_and_measures_stay() -> Result<(), MeshError> {
        for degree in 1..=2 {
            let mut mesh = annulus(1.0, 2.0, 2, 40, CellShape::Quadrilateral, degree)?;
            mesh.name_cells("upper half", |centre| centre[1] > 0.0)?;
            mesh.name_interior_facets("middle", INTERIOR, |x| (x[0].hypot(x[1]) - 1.5).abs() < 0.01)?;
            check(&mesh)?;
            // Nearly straight, so that volumes of trilinear cells and of their tetrahedra nearly agree.
            let bent = |[r, s, t]: [f64; 3]| [r + 0.01 * s * t, s + 0.01 * t * t, t + 0.01 * r * s];
            check(&structured([2, 3, 2], CellShape::Hexahedron, degree, bent)?)?;
        }
        Ok(())
    }
}
