//! A number by which files recognise the mesh that they belong to.

use super::Mesh;
use crate::files::checksum;
use crate::instantiate;

impl<const D: usize> Mesh<D> {
    /// FNV-1a of dimension, degree, blocks of cells, cells and nodes, to the last bit of each coordinate: another number of a node, another
    /// order of the cells or a coordinate that differs by rounding give another sum. Names of regions do not count.
    #[inline(never)]
    pub fn checksum(&self) -> u64 {
        let sizes = [D, self.degree(), self.node_count(), self.cell_count()];
        let blocks = self
            .blocks()
            .iter()
            .flat_map(|block| block.shape.name().bytes().chain((block.cells.end as u64).to_le_bytes()));
        let nodes = self.nodes().iter().flatten().flat_map(|coordinate| coordinate.to_bits().to_le_bytes());
        let sizes = sizes.into_iter().flat_map(|number| (number as u64).to_le_bytes());
        let cells = self.cells().iter().flat_map(|node| node.to_le_bytes());
        checksum(sizes.chain(blocks).chain(cells).chain(nodes))
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
