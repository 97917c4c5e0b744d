//! The order in which cells are walked: along a Hilbert curve through their centres, so that cells that follow
//! each other share nodes, however the mesh was numbered.

use std::sync::OnceLock;

use super::{Facet, Mesh};

/// The cells of a mesh along a Hilbert curve.
#[derive(Clone, Debug)]
pub struct CellOrder {
    cells: Vec<u32>,
    ranks: Vec<u32>,
}

impl CellOrder {
    /// The cells, in the order of the curve.
    #[inline]
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// The place of each cell on the curve.
    #[inline]
    pub fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    fn new<const D: usize>(mesh: &Mesh<D>) -> Self {
        let (lower, upper) = mesh.bounds();
        let extent = (0..D).map(|k| upper[k] - lower[k]).fold(f64::MIN_POSITIVE, f64::max);
        // One scale for all directions: the boxes of the curve are cubes.
        let scale = f64::from((1_u32 << BITS) - 1) / extent;
        let mut keyed: Vec<(u64, u32)> = Vec::with_capacity(mesh.cell_count());
        for cell in 0..mesh.cell_count() {
            let mut sum = [0.0; D];
            let vertices = mesh.cell_vertices(cell);
            for &vertex in vertices {
                for (sum, x) in sum.iter_mut().zip(&mesh.nodes()[vertex as usize]) {
                    *sum += x;
                }
            }
            let place: [u32; D] =
                std::array::from_fn(|k| ((sum[k] / vertices.len() as f64 - lower[k]) * scale) as u32);
            keyed.push((along_curve(place), cell as u32));
        }
        keyed.sort_unstable();
        let cells: Vec<u32> = keyed.into_iter().map(|(_, cell)| cell).collect();
        let mut ranks = vec![0; cells.len()];
        for (rank, cell) in cells.iter().enumerate() {
            ranks[*cell as usize] = rank as u32;
        }
        CellOrder { cells, ranks }
    }
}

/// Bits per coordinate.
const BITS: u32 = 20;

/// The distance of a cube of the finest level along the Hilbert curve; J. Skilling, Programming the Hilbert
/// curve, AIP Conference Proceedings 707 (2004).
fn along_curve<const D: usize>(mut x: [u32; D]) -> u64 {
    let mut bit = 1 << (BITS - 1);
    while bit > 1 {
        let lower = bit - 1;
        for k in 0..D {
            if x[k] & bit != 0 {
                x[0] ^= lower;
            } else {
                let exchanged = (x[0] ^ x[k]) & lower;
                x[0] ^= exchanged;
                x[k] ^= exchanged;
            }
        }
        bit >>= 1;
    }
    for k in 1..D {
        x[k] ^= x[k - 1];
    }
    let mut flips = 0;
    bit = 1 << (BITS - 1);
    while bit > 1 {
        if x[D - 1] & bit != 0 {
            flips ^= bit - 1;
        }
        bit >>= 1;
    }
    let mut distance = 0;
    for level in (0..BITS).rev() {
        for coordinate in x {
            distance = distance << 1 | u64::from((coordinate ^ flips) >> level & 1);
        }
    }
    distance
}

/// A [`CellOrder`] that is made at the first use. A copy of the mesh keeps it.
pub(super) type LazyOrder = OnceLock<CellOrder>;

impl<const D: usize> Mesh<D> {
    /// The order in which assembly walks the cells, and spaces number their nodes. It follows from the places
    /// of the cells, not from their numbers. Made at the first call.
    pub fn cell_order(&self) -> &CellOrder {
        self.order.get_or_init(|| CellOrder::new(self))
    }

    /// Cells given in ascending order, in the order of the walk.
    #[doc(hidden)]
    pub fn walk_of_cells(&self, cells: &[u32]) -> Vec<u32> {
        let order = self.cell_order();
        if cells.len() == order.cells.len() {
            return order.cells.clone();
        }
        let mut walk = cells.to_vec();
        walk.sort_unstable_by_key(|cell| order.ranks[*cell as usize]);
        walk
    }

    /// The place of a facet in the walk: with the later one of its cells, so that the nodes of all facets
    /// before it have been met before.
    #[doc(hidden)]
    pub fn walk_of_facet(&self, sides: &[Facet]) -> u32 {
        let ranks = &self.cell_order().ranks;
        sides.iter().map(|facet| ranks[facet.cell as usize]).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::{MeshError, cuboid, rectangle};

    /// On a grid of 2^k cells the curve goes from each cell to a neighbour, and meets every cell once.
    #[test]
    fn the_curve_goes_from_neighbour_to_neighbour() -> Result<(), MeshError> {
        let mesh = cuboid([0.0; 3], [8.0; 3], [8; 3], CellShape::Hexahedron, 1)?;
        let order = mesh.cell_order();
        for pair in order.cells().windows(2) {
            let [a, b] = [mesh.cell_centre(pair[0] as usize), mesh.cell_centre(pair[1] as usize)];
            let steps: f64 = (0..3).map(|k| (a[k] - b[k]).abs()).sum();
            assert!((steps - 1.0).abs() < 1e-12, "{a:?} {b:?}");
        }
        let mut sorted = order.cells().to_vec();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..512).collect::<Vec<u32>>());
        Ok(())
    }

    #[test]
    fn the_order_does_not_depend_on_the_numbers_of_the_cells() -> Result<(), MeshError> {
        let mesh = rectangle([0.0; 2], [3.0, 1.0], [9, 4], CellShape::Triangle, 2)?;
        let count = mesh.cell_count();
        let shuffled: Vec<usize> = (0..count).map(|cell| cell * 31 % count).collect();
        let cells = shuffled.iter().flat_map(|&cell| mesh.cell(cell).to_vec()).collect();
        let other = Mesh::from_parts(CellShape::Triangle, 2, mesh.nodes().to_vec(), cells)?;
        let known = other.cell_order().cells().iter().map(|&cell| shuffled[cell as usize] as u32);
        assert_eq!(known.collect::<Vec<_>>(), mesh.cell_order().cells());
        let region = [1, 5, 6, 20];
        let walk = mesh.walk_of_cells(&region);
        let ranks = walk.iter().map(|&cell| mesh.cell_order().ranks()[cell as usize]);
        assert!(ranks.is_sorted() && walk.len() == region.len());
        Ok(())
    }
}
