//! Nearly incompressible blocks on a flat: elements, data and solutions that the tests of their laws share.

use forms_contact::laws::mixed_nitsche::{self as laws, mixed_nitsche as law};
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::setting::along;

/// μ and K, moderate ones.
pub const MU: f64 = 80.0;
pub const BULK: f64 = 400.0;

/// Spaces of u and p.
pub struct Pair<const D: usize> {
    pub name: &'static str,
    pub mesh: Mesh<D>,
    pub displacements: Arc<Space<D>>,
    pub pressures: Arc<Space<D>>,
}

impl<const D: usize> Pair<D>
where
    Dim: Dimension<D>,
{
    fn new(name: &'static str, mesh: &Mesh<D>, u: Elements, (p, scope): (Elements, Scope)) -> Pair<D> {
        Pair {
            name,
            mesh: mesh.clone(),
            displacements: Space::of(mesh, u, Scope::Nodes, &[D]).unwrap(),
            pressures: Space::of(mesh, p, scope, &[]).unwrap(),
        }
    }

    pub fn spaces(&self) -> [&Arc<Space<D>>; 2] {
        [&self.displacements, &self.pressures]
    }

    /// The top moved aside and down.
    pub fn pressed(&self, aside: f64, down: f64) -> Constraints<D> {
        let mut top = along::<D>(0, aside);
        top[D - 1] = -down;
        let mut held = Constraints::new(&self.displacements);
        held.fix("top", |_| top).unwrap();
        held
    }
}

/// Blocks of 2 × 1, of stable elements, with cells that are bent inside.
pub fn plane_pairs(cells: usize) -> [Pair<2>; 3] {
    let block = |shape| {
        let map = |[s, t]: [f64; 2]| {
            let bubble = 0.8 * s * (1.0 - s) * t * (1.0 - t);
            [2.0 * s + bubble, t - 0.7 * bubble]
        };
        structured([2 * cells, cells], shape, 1, map).unwrap()
    };
    let (squares, triangles) = (block(CellShape::Quadrilateral), block(CellShape::Triangle));
    [
        Pair::new("Q2/P-1", &squares, Elements::Lagrange(2), (Elements::LinearInSpace, Scope::Cell)),
        Pair::new("P2/P1", &triangles, Elements::Lagrange(2), (Elements::Lagrange(1), Scope::Nodes)),
        Pair::new("MINI", &triangles, Elements::Mini(1), (Elements::Lagrange(1), Scope::Nodes)),
    ]
}

/// A block of 2 × 1 × 1 with one pressure per hexahedron.
pub fn solid_pair() -> Pair<3> {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], CellShape::Hexahedron, 1).unwrap();
    Pair::new("Q1/P0", &mesh, Elements::Lagrange(1), (Elements::Lagrange(0), Scope::Cell))
}

/// A body on the flat below it, J = ∫ F·u with an F that is nowhere constant.
pub fn data<const D: usize>(bulk: f64, friction: f64, slip_stress: f64) -> law::Data<D> {
    law::data()
        .mu(MU)
        .bulk_modulus(bulk)
        .gamma0(laws::usual_gamma0(MU))
        .obstacle_normal(along(D - 1, -1.0))
        .gap(|x: &[f64; D]| x[D - 1])
        .friction(friction)
        .slip_stress(slip_stress)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]))
}

/// ∂W/∂F at F = diag(1, .., 1, J), along the last axis: its amount is the pressure of a layer that is held sideways.
pub fn layer_pressure(bulk: f64, volume: f64) -> f64 {
    let shape = MU * volume.powf(-2.0 / 3.0) * (volume - (2.0 + volume * volume) / (3.0 * volume));
    -(shape + bulk * (volume - 1.0))
}
