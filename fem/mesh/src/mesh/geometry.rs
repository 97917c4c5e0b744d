//! The geometry map of a cell: positions, Jacobians, centres, diameters.

use super::determinant::{JacobianDeterminant, ROUND_OFF, SMALLEST, Sign};
use super::small_matrices::determinant;
use super::{CellBlock, Facet, Mesh, MeshError};
use crate::element::MAXIMUM_GEOMETRY_NODES;

impl<const D: usize> Mesh<D> {
    /// The position x \[length\] of a reference point of a cell, and the Jacobian
    /// `jacobian[i][j]` = ∂x_i/∂ξ_j there.
    ///
    /// # Panics
    /// When `cell` is not below [`Mesh::cell_count`].
    pub fn map(&self, cell: usize, reference: &[f64; D]) -> ([f64; D], [[f64; D]; D]) {
        let mut value = [0.0; MAXIMUM_GEOMETRY_NODES];
        let mut gradient = [[0.0; D]; MAXIMUM_GEOMETRY_NODES];
        self.cell_element(cell).evaluate(reference, &mut value, &mut gradient);
        self.map_by(cell, &value, &gradient)
    }

    /// [`Mesh::map`] by the geometry's basis functions at the point and their reference gradients, as a table has them.
    #[doc(hidden)]
    #[inline]
    pub fn map_by(&self, cell: usize, value: &[f64], gradient: &[[f64; D]]) -> ([f64; D], [[f64; D]; D]) {
        let (mut position, mut jacobian) = ([0.0; D], [[0.0; D]; D]);
        for ((node, phi), slope) in self.cell(cell).iter().zip(value).zip(gradient) {
            let x = &self.nodes[*node as usize];
            for i in 0..D {
                position[i] += phi * x[i];
                for j in 0..D {
                    jacobian[i][j] += slope[j] * x[i];
                }
            }
        }
        (position, jacobian)
    }

    /// The image of the reference cell's centre \[length\].
    ///
    /// # Panics
    /// When `cell` is not below [`Mesh::cell_count`].
    pub fn cell_centre(&self, cell: usize) -> [f64; D] {
        self.map(cell, &self.cell_shape(cell).centre()).0
    }

    /// A call of `visit` for each of some cells, with its [`Mesh::cell_centre`]; basis functions are evaluated once for each run of cells
    /// of one shape.
    ///
    /// # Panics
    /// When a cell is not below [`Mesh::cell_count`].
    #[doc(hidden)]
    pub fn visit_centres(&self, cells: impl Iterator<Item = u32>, mut visit: impl FnMut(u32, &[f64; D])) {
        let mut value = [0.0; MAXIMUM_GEOMETRY_NODES];
        let mut gradient = [[0.0; D]; MAXIMUM_GEOMETRY_NODES];
        let mut known = None;
        for cell in cells {
            let shape = self.cell_shape(cell as usize);
            if known != Some(shape) {
                self.cell_element(cell as usize).evaluate(&shape.centre(), &mut value, &mut gradient);
                known = Some(shape);
            }
            let mut position = [0.0; D];
            for (node, phi) in self.cell(cell as usize).iter().zip(&value) {
                let x = &self.nodes[*node as usize];
                for i in 0..D {
                    position[i] += phi * x[i];
                }
            }
            visit(cell, &position);
        }
    }

    /// The image of the centre of the facet's reference cell \[length\].
    ///
    /// # Panics
    /// When the mesh has no such facet.
    pub fn facet_centre(&self, facet: Facet) -> [f64; D] {
        let cell = facet.cell as usize;
        self.map(cell, &self.cell_shape(cell).facet_centre(usize::from(facet.local))).0
    }

    /// h, the largest distance between two vertices of a cell \[length\].
    ///
    /// # Panics
    /// When `cell` is not below [`Mesh::cell_count`].
    pub fn diameter(&self, cell: usize) -> f64 {
        let vertices = self.cell_vertices(cell);
        let mut largest = 0.0_f64;
        for (index, &a) in vertices.iter().enumerate() {
            for &b in &vertices[..index] {
                let (a, b) = (&self.nodes[a as usize], &self.nodes[b as usize]);
                largest = largest.max(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum());
            }
        }
        largest.sqrt()
    }

    /// The smallest box \[length\] that contains all nodes: its lower and its upper corner.
    pub fn bounds(&self) -> ([f64; D], [f64; D]) {
        let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for node in &self.nodes {
            for k in 0..D {
                lower[k] = lower[k].min(node[k]);
                upper[k] = upper[k].max(node[k]);
            }
        }
        (lower, upper)
    }

    /// Check that the Jacobian determinant of every cell is positive everywhere in it, and its edges are of sizes that differ by less than double
    /// precision does.
    pub(super) fn check_jacobians(&self) -> Result<(), MeshError> {
        self.blocks().iter().try_for_each(|block| {
            match self.is_affine_on(block.shape) {
                true => self.check_constant_jacobians(block)?,
                false => self.check_varying_jacobians(block)?,
            }
            self.check_edges(block)
        })
    }

    /// Check that no cell has an edge that is round-off compared with its longest one. Determinants do not show it, because they are as small as the
    /// edge.
    fn check_edges(&self, block: &CellBlock) -> Result<(), MeshError> {
        let edges = block.shape.edges();
        for cell in block.cells.clone() {
            let nodes = self.cell(cell);
            let length = |edge: &[usize; 2]| -> f64 {
                let [a, b] = edge.map(|vertex| &self.nodes[nodes[vertex] as usize]);
                // Squares of the largest and the least numbers are none.
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let longest = edges.iter().map(length).fold(0.0, f64::max);
            if let Some(edge) = edges.iter().find(|edge| length(edge) <= ROUND_OFF * longest) {
                let (length, nodes) = (length(edge), edge.map(|vertex| nodes[vertex]));
                return Err(MeshError::ShortEdge { cell, nodes, length, longest });
            }
        }
        Ok(())
    }

    fn check_constant_jacobians(&self, block: &CellBlock) -> Result<(), MeshError> {
        let element = self.element_of(block.shape);
        let centre = block.shape.centre::<D>();
        let slopes = element.tabulate(&[centre]).gradient;
        for cell in block.cells.clone() {
            let mut jacobian = [[0.0; D]; D];
            for (node, slope) in self.cell(cell).iter().zip(&slopes) {
                let x = &self.nodes[*node as usize];
                for i in 0..D {
                    for j in 0..D {
                        jacobian[i][j] += slope[j] * x[i];
                    }
                }
            }
            let determinant = determinant(&jacobian);
            // Round-off of a degenerate cell is of this size relative to its edges.
            let scale: f64 =
                (0..D).map(|j| jacobian.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt()).product();
            if determinant.is_nan() || determinant <= (ROUND_OFF * scale).max(SMALLEST) {
                let position = self.map(cell, &centre).0.to_vec();
                return Err(MeshError::Inverted { cell, determinant, position });
            }
        }
        Ok(())
    }

    fn check_varying_jacobians(&self, block: &CellBlock) -> Result<(), MeshError> {
        let determinant = JacobianDeterminant::new(&self.element_of(block.shape));
        let position = |cell, reference| self.map(cell, &reference).0.to_vec();
        block.cells.clone().try_for_each(|cell| match determinant.sign(self.cell(cell), &self.nodes) {
            Sign::Positive => Ok(()),
            Sign::Folded { reference, determinant } => {
                Err(MeshError::Inverted { cell, determinant, position: position(cell, reference) })
            }
            Sign::Undecided { reference, bound } => {
                Err(MeshError::Undecided { cell, bound, position: position(cell, reference) })
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;

    #[test]
    fn the_map_of_a_quadratic_triangle() -> Result<(), MeshError> {
        // x = ξ + 0.4 ξ η, y = η: a quadratic map, so it is reproduced with its derivative.
        let map = |p: [f64; 2]| [p[0] + 0.4 * p[0] * p[1], p[1]];
        let points = crate::element::Lagrange { shape: CellShape::Triangle, degree: 2 }.node_points::<2>();
        let nodes = points.into_iter().map(map).collect();
        let mesh = Mesh::from_parts(CellShape::Triangle, 2, nodes, (0..6).collect())?;
        let p = [0.3, 0.2];
        let (x, jacobian) = mesh.map(0, &p);
        let expected = [[1.0 + 0.4 * p[1], 0.4 * p[0]], [0.0, 1.0]];
        for i in 0..2 {
            assert!((x[i] - map(p)[i]).abs() < 1e-15);
            for j in 0..2 {
                assert!((jacobian[i][j] - expected[i][j]).abs() < 1e-15);
            }
        }
        assert_eq!(mesh.diameter(0), 2f64.sqrt());
        let centre = mesh.facet_centre(Facet { cell: 0, local: 1 });
        assert!((centre[0] - 0.6).abs() < 1e-15 && (centre[1] - 0.5).abs() < 1e-15);
        assert_eq!(mesh.bounds(), ([0.0, 0.0], [1.0, 1.0]));
        Ok(())
    }

    #[test]
    fn edges_that_are_round_off_are_refused_by_name() {
        let triangle = |short: f64, size: f64| {
            let nodes = [[0.1, 0.0], [0.2, 0.0], [0.1, short]].map(|x: [f64; 2]| x.map(|x| size * x));
            Mesh::from_parts(CellShape::Triangle, 1, nodes.to_vec(), vec![0, 1, 2])
        };
        for size in [1.0, 1e100, 1e-100] {
            assert!(triangle(1e-12, size).is_ok(), "{size}");
            let Err(MeshError::ShortEdge { cell: 0, nodes, length, longest }) = triangle(1e-17, size) else {
                panic!("accepted in size {size}")
            };
            assert_eq!(nodes, [2, 0]);
            assert!(
                (length / size / 1e-17 - 1.0).abs() < 1e-12 && (longest / size / 0.1 - 1.0).abs() < 1e-12
            );
        }
        let message = triangle(1e-17, 1.0).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.starts_with("cell 0 is degenerate: its nodes 2 and 0 are 1e-17 apart"), "{message}");
        // Cells of other shapes and of degree 2.
        let flat = |shape, degree| {
            let plain = crate::mesh::rectangle([0.0; 2], [1.0; 2], [1, 1], shape, degree)?;
            plain.with_nodes(plain.nodes().iter().map(|x| [x[0], 1e-16 * x[1]]).collect())
        };
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            for degree in 1..=2 {
                // Triangles are slivers by their angles, too.
                let refused = flat(shape, degree);
                let degenerate =
                    matches!(refused, Err(MeshError::ShortEdge { .. } | MeshError::Inverted { cell: 0, .. }));
                assert!(degenerate, "{shape:?} {degree}: {refused:?}");
            }
        }
    }
}
