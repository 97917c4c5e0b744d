//! A block of 2 × 1 (× 1) on a flat, pressed down and sheared by its top: parts of its base stick, parts slip, parts lift off.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_fem::prelude::*;

use crate::setting::along;

/// A mesh with a space of degree 1.
pub struct Block<const D: usize> {
    pub mesh: Mesh<D>,
    pub space: Arc<Space<D>>,
}

/// In the plane, of this number of quadrilaterals along its height.
pub fn plane_block(cells: usize) -> Block<2> {
    block(rectangle([0.0; 2], [2.0, 1.0], [2 * cells, cells], CellShape::Quadrilateral, 1).unwrap())
}

/// In space.
pub fn solid_block() -> Block<3> {
    block(cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], CellShape::Hexahedron, 1).unwrap())
}

fn block<const D: usize>(mesh: Mesh<D>) -> Block<D> {
    let space = Space::vector(&mesh, 1).unwrap();
    Block { mesh, space }
}

impl<const D: usize> Block<D>
where
    Dim: Dimension<D>,
{
    /// The law on the block, whose top is moved aside and down.
    pub fn problem<L: ContactLaw<D>>(&self, law: L, aside: f64, down: f64) -> ContactProblem<D, L> {
        let mut constraints = Constraints::new(&self.space);
        let mut top = along::<D>(0, aside);
        top[D - 1] = -down;
        constraints.fix("top", |_| top).unwrap();
        ContactProblem::new(&self.space, law, constraints).quadrature(Quadrature::Degree(4))
    }
}
