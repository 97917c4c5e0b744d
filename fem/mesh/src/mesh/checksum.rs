//! A number by which files recognise the mesh that they belong to.

use super::Mesh;
use crate::instantiate;

/// The start and the factor of FNV-1a with 64 bits (G. Fowler, L. C. Noll, K.-P. Vo; RFC 9923).
const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

impl<const D: usize> Mesh<D> {
    /// FNV-1a of dimension, degree, blocks of cells, cells and nodes, to the last bit of each coordinate: another number of a node, another
    /// order of the cells or a coordinate that differs by rounding give another sum. Names of regions do not count.
    #[inline(never)]
    pub fn checksum(&self) -> u64 {
        let mut sum = OFFSET_BASIS;
        let mut add = |bytes: &[u8]| {
            for &byte in bytes {
                sum = (sum ^ u64::from(byte)).wrapping_mul(PRIME);
            }
        };
        for number in [D, self.degree(), self.node_count(), self.cell_count()] {
            add(&(number as u64).to_le_bytes());
        }
        for block in self.blocks() {
            add(block.shape.name().as_bytes());
            add(&(block.cells.end as u64).to_le_bytes());
        }
        for node in self.cells() {
            add(&node.to_le_bytes());
        }
        for coordinate in self.nodes().iter().flatten() {
            add(&coordinate.to_bits().to_le_bytes());
        }
        sum
    }
}

instantiate!(checksum: Mesh::<D>::checksum);

#[cfg(test)]
mod tests {
    use crate::element::CellShape;
    use crate::mesh::{Mesh, MeshError, rectangle};

    #[test]
    fn what_is_not_the_same_mesh_has_another_sum() -> Result<(), MeshError> {
        let square = |shape| rectangle([0.0; 2], [1.0; 2], [2, 2], shape, 1);
        let mesh = square(CellShape::Triangle)?;
        assert_eq!(mesh.checksum(), square(CellShape::Triangle)?.checksum());
        assert_ne!(mesh.checksum(), square(CellShape::Quadrilateral)?.checksum());
        let mut nodes = mesh.nodes().to_vec();
        nodes[3][0] = nodes[3][0].next_up();
        assert_ne!(mesh.checksum(), mesh.with_nodes(nodes)?.checksum());
        let mut cells = mesh.cells().to_vec();
        cells[..3].rotate_left(1);
        let turned = Mesh::from_parts(CellShape::Triangle, 1, mesh.nodes().to_vec(), cells)?;
        assert_ne!(mesh.checksum(), turned.checksum());
        Ok(())
    }
}
