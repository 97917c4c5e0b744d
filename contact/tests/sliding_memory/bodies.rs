//! A slab and a block above it, which the tests move.

use forms_fem::prelude::*;

pub const YOUNG: f64 = 200.0;
pub const POISSON: f64 = 0.3;
pub const LAMBDA: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
pub const MU: f64 = YOUNG / (2.0 * (1.0 + POISSON));
/// Height of the slab \[length\].
const SLAB: f64 = 0.5;
/// The distance of the bodies before they move \[length\].
pub const APART: f64 = 0.1;

/// A slab, 4 long, and a block of side 1 above it, with cells that do not match.
pub fn plane(cells: usize) -> Mesh<2> {
    let slab = rectangle([0.0, 0.0], [4.0, SLAB], [9, 2], CellShape::Quadrilateral, 1).unwrap();
    let bottom = SLAB + APART;
    let block =
        rectangle([0.4, bottom], [1.4, bottom + 1.0], [cells, 2], CellShape::Quadrilateral, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap()
}

/// The same in space.
pub fn space() -> Mesh<3> {
    let slab = cuboid([0.0; 3], [3.0, 3.0, SLAB], [5, 4, 1], CellShape::Hexahedron, 1).unwrap();
    let bottom = SLAB + APART;
    let block =
        cuboid([0.6, 0.6, bottom], [1.6, 1.6, bottom + 1.0], [3, 3, 1], CellShape::Hexahedron, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap()
}

/// Whether a point belongs to the block.
pub fn is_of_block<const D: usize>(x: &[f64; D]) -> bool {
    x[D - 1] > SLAB + 0.5 * APART
}

/// The block moved rigidly, the slab held.
pub fn moved<const D: usize>(space: &Arc<Space<D>>, by: [f64; D]) -> Field<D> {
    Field::interpolate(space, |x: &[f64; D]| if is_of_block(x) { by } else { [0.0; D] }).unwrap()
}

/// The own points are those of the block.
pub fn touch() -> Pairing {
    Pairing::onto("block bottom", "slab top").within_reach(0.4)
}

/// The unit vector along an axis, times a number.
pub fn along<const D: usize>(axis: usize, size: f64) -> [f64; D] {
    std::array::from_fn(|k| if k == axis { size } else { 0.0 })
}
