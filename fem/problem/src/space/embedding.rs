//! The embedding of a space of lower degree in one of higher degree on the same mesh.

use super::{Space, SpaceError};
use crate::linear_algebra::CsrMatrix;

/// Values of basis functions below this are rounding.
const ROUNDING: f64 = 1e-14;

impl<const D: usize> Space<D> {
    /// The values of the scalar basis functions of `coarse` at the nodes of this space: one row per node, one column
    /// per node of `coarse`. Multiplied with nodal values of a function in `coarse` it gives those of its interpolant
    /// here, which is the same function where this space holds the other.
    ///
    /// # Errors
    /// [`SpaceError::OtherMesh`] unless both are spaces on the cells of one mesh.
    pub fn embedding(&self, coarse: &Space<D>) -> Result<CsrMatrix, SpaceError> {
        let on_cells = self.is_on_all_cells() && coarse.is_on_all_cells();
        if !self.mesh.is_same(&coarse.mesh) || !on_cells {
            return Err(SpaceError::OtherMesh);
        }
        let mut seen = vec![false; self.node_count()];
        let mut triplets = Vec::with_capacity(2 * self.node_count());
        for block in self.mesh.blocks() {
            let points = self.element_of(block.shape).node_points::<D>();
            let tables = coarse.element_of(block.shape).tabulate(&points);
            for cell in block.cells.clone() {
                let columns = coarse.cell_nodes(cell);
                for (point, &node) in self.cell_nodes(cell).iter().enumerate() {
                    if std::mem::replace(&mut seen[node as usize], true) {
                        continue;
                    }
                    let values = &tables.value[point * tables.nodes..(point + 1) * tables.nodes];
                    let entries = columns.iter().zip(values).filter(|(_, value)| value.abs() > ROUNDING);
                    triplets.extend(entries.map(|(&column, &value)| (node as usize, column as usize, value)));
                }
            }
        }
        let (rows, columns) = (self.node_count(), coarse.node_count());
        CsrMatrix::from_triplets(rows, columns, &triplets)
            .map_err(|_| SpaceError::TooLarge { unknowns: rows.max(columns) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::{cuboid, rectangle};

    #[test]
    fn a_linear_function_is_itself_in_degree_two() {
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 3, 2], shape, 1).unwrap();
            let (fine, coarse) = (Space::scalar(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
            let f = |x: &[f64; 3]| 1.0 + 2.0 * x[0] - x[1] + 0.5 * x[2];
            let values: Vec<f64> = coarse.positions().iter().map(f).collect();
            let found = fine.embedding(&coarse).unwrap().multiply(&values).unwrap();
            for (value, position) in found.iter().zip(fine.positions()) {
                assert!((value - f(position)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn other_meshes_are_refused() {
        let mesh = || rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
        let (fine, coarse) = (Space::scalar(&mesh(), 2).unwrap(), Space::scalar(&mesh(), 1).unwrap());
        assert_eq!(fine.embedding(&coarse).unwrap_err(), SpaceError::OtherMesh);
    }
}
