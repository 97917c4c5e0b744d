//! A layer of height 1 that is pressed on a flat below it and held at its sides: one gap and one pressure.

use forms_fem::prelude::*;

pub const LAMBDA: f64 = 1.5;
pub const MU: f64 = 1.0;
/// λ + 2μ.
pub const MODULUS: f64 = LAMBDA + 2.0 * MU;
/// Distance of the flat.
pub const GAP: f64 = 0.05;

/// n_y.
pub fn below<const D: usize>() -> [f64; D] {
    std::array::from_fn(|k| if k + 1 == D { -1.0 } else { 0.0 })
}

pub fn plane() -> Mesh<2> {
    rectangle([0.0; 2], [2.0, 1.0], [5, 3], CellShape::Quadrilateral, 1).unwrap()
}

pub fn solid() -> Mesh<3> {
    cuboid([0.0; 3], [1.0; 3], [2, 2, 3], CellShape::Hexahedron, 1).unwrap()
}

/// The layer's space, with its top moved down by `way`.
pub fn held<const D: usize>(space: &Arc<Space<D>>, way: f64) -> Constraints<D>
where
    Dim: Dimension<D>,
{
    let mut held = Constraints::new(space);
    let sides = [("left", 0), ("right", 0), ("front", 1), ("back", 1)];
    for (side, component) in &sides[..2 * (D - 1)] {
        held.fix_component(side, *component, |_| 0.0).unwrap();
    }
    held.fix("top", |_| below::<D>().map(|n| way * n)).unwrap();
    held
}

/// The gap g at which M (way − GAP + g) = p(g), p falling.
pub fn balanced(way: f64, pressure: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-14, 1.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if MODULUS * (way - GAP + middle) < pressure(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The same smooth field without symmetry on each call.
pub fn wave<const D: usize>(space: &Arc<Space<D>>, size: f64, phase: f64) -> Field<D> {
    let value = |x: &[f64; D]| -> [f64; D] {
        let angle: f64 = x.iter().enumerate().map(|(axis, x)| (2.0 + 0.7 * axis as f64) * x).sum();
        std::array::from_fn(|k| size * (angle + phase + 1.9 * k as f64).sin())
    };
    Field::interpolate(space, value).unwrap()
}
