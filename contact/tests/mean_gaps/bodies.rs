//! Two layers, one on the other and periodic sideways, with cells that do not match, and what the tests do with them.

use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;
use forms_fem::verification;

pub const YOUNG: f64 = 200.0;
pub const POISSON: f64 = 0.3;
pub const LAMBDA: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
pub const MU: f64 = YOUNG / (2.0 * (1.0 + POISSON));
/// Width \[length\].
pub const WIDTH: f64 = 1.5;

/// Two layers of height ½ with the given number of cells sideways, the upper one `aside`.
pub fn layers(shape: CellShape, cells: [usize; 2], aside: f64) -> Mesh<2> {
    let body = |count: usize, [left, low]: [f64; 2]| {
        rectangle([left, low], [left + WIDTH, low + 0.5], [count, 2], shape, 1).unwrap()
    };
    let (lower, upper) = (body(cells[0], [0.0, 0.0]), body(cells[1], [aside, 0.5]));
    Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap()
}

/// The same in space, of hexahedra.
pub fn layers_in_space(cells: [usize; 2]) -> Mesh<3> {
    let body = |count: usize, low: f64| {
        let upper = [WIDTH, WIDTH, low + 0.5];
        cuboid([0.0, 0.0, low], upper, [count, count, 2], CellShape::Hexahedron, 1).unwrap()
    };
    let (lower, upper) = (body(cells[0], 0.0), body(cells[1], 0.5));
    Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap()
}

/// The lowest side held, the highest moved by (U, .., −δ), the others periodic.
pub fn constraints<const D: usize>(space: &Arc<Space<D>>, aside: f64, down: f64) -> Constraints<D> {
    let mut constraints = Constraints::new(space);
    let mut top = [0.0; D];
    (top[0], top[D - 1]) = (aside, -down);
    constraints.fix("lower bottom", |_| [0.0; D]).unwrap();
    constraints.fix("upper top", |_| top).unwrap();
    for body in ["lower", "upper"] {
        for (axis, (from, to)) in [("left", "right"), ("front", "back")].iter().enumerate().take(D - 1) {
            let mut step = [0.0; D];
            step[axis] = WIDTH;
            let map = RigidMap::translation(step);
            constraints.periodic(&format!("{body} {from}"), &format!("{body} {to}"), &map).unwrap();
        }
    }
    constraints
}

/// The three ways to integrate over the interface, with each surface's part.
pub fn pairings() -> [(Pairing, f64); 3] {
    let (lower, upper) = ("lower top", "upper bottom");
    [
        (Pairing::between(lower, upper), 0.5),
        (Pairing::onto(lower, upper), 1.0),
        (Pairing::onto(upper, lower), 1.0),
    ]
}

/// A smooth displacement that presses the layers together, shears and bends them.
pub fn bent<const D: usize>(space: &Arc<Space<D>>, size: f64) -> Field<D> {
    Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
        let up = if x[D - 1] > 0.5 + 1e-9 { 1.0 } else { 0.0 };
        std::array::from_fn(|axis| match axis + 1 == D {
            true => size * (-up * x[D - 1] + 0.2 * (3.0 * x[0] + x[D - 1]).sin()),
            false => size * (2.0 * up * x[D - 1] + 0.3 * (2.0 * x[D - 1] + axis as f64).cos()),
        })
    })
    .unwrap()
}

pub fn direction<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|axis| (1.7 * x[0] - 2.3 * x[D - 1] + axis as f64).sin())
    })
    .unwrap()
}

/// The Taylor test of a form's tangent.
pub fn check_tangent<const D: usize>(assembler: &Assembler<D>, form: &Form<D>, u: &Field<D>) {
    let direction = direction(u.space());
    let report = verification::tangent(assembler, form, &[u], &[&direction], 1e-4).unwrap();
    let order = report.second_order().unwrap();
    assert!(order > 1.95, "order {order}: {report}");
}

/// Sums of forces, and without friction of moments, compared with the sizes of the forces.
pub fn check_balance(residual: &[f64], u: &Field<2>, moments: Moments) {
    let scale: f64 = residual.iter().map(|entry| entry.abs()).sum();
    let (mut sums, mut moment) = ([0.0; 2], 0.0);
    for (node, force) in residual.chunks_exact(2).enumerate() {
        let x = u.space().positions()[node];
        let place = [x[0] + u.values()[2 * node], x[1] + u.values()[2 * node + 1]];
        sums = [sums[0] + force[0], sums[1] + force[1]];
        moment += place[0] * force[1] - place[1] * force[0];
    }
    assert!(scale > 0.1 && sums.iter().all(|sum| sum.abs() < 1e-13 * scale), "{sums:?} of {scale}");
    if moments == Moments::Vanish {
        assert!(moment.abs() < 1e-13 * scale, "{moment} of {scale}");
    }
}

/// Whether moments balance: friction acts at X and at Y, which are a gap apart.
#[derive(Clone, Copy, PartialEq)]
pub enum Moments {
    Vanish,
    HaveGaps,
}

/// The largest difference, as a part of the largest entry.
pub fn apart(one: &[f64], other: &[f64]) -> f64 {
    let most = other.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let difference = one.iter().zip(other).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(one.len() == other.len() && most > 0.0);
    difference / most
}
