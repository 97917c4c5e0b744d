//! A layer of height 1, periodic sideways, on a flat: its top is moved by (U, .., −δ). Strains are constant, so that every
//! mesh and every degree have the solution to rounding: without a mesh's error the law itself is seen.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::setting::along;

/// Width \[length\]; in space also the depth.
pub const WIDTH: f64 = 1.5;

/// The layer with a space for displacements.
pub struct Layer<const D: usize> {
    pub mesh: Mesh<D>,
    pub space: Arc<Space<D>>,
}

/// Cells inside are of different sizes and shapes, or all alike.
#[derive(Clone, Copy, Debug)]
pub enum Inside {
    Distorted,
    Alike,
}

/// Layers of all shapes in the plane.
pub fn plane_layers(inside: Inside) -> Vec<Layer<2>> {
    vec![layer(CellShape::Triangle, 1, [3, 2], inside), layer(CellShape::Quadrilateral, 2, [3, 2], inside)]
}

/// Layers in space.
pub fn solid_layers(inside: Inside) -> Vec<Layer<3>> {
    vec![
        layer(CellShape::Hexahedron, 1, [2, 2, 2], inside),
        layer(CellShape::Tetrahedron, 1, [2, 2, 2], inside),
    ]
}

/// A layer in space of degree 2.
pub fn quadratic_solid_layer() -> Layer<3> {
    layer(CellShape::Hexahedron, 2, [2, 2, 1], Inside::Distorted)
}

fn layer<const D: usize>(shape: CellShape, degree: usize, divisions: [usize; D], inside: Inside) -> Layer<D> {
    let map = |t: [f64; D]| {
        // Nothing moves on the sides, which are carried onto each other.
        let bump: f64 = t.iter().map(|t| (std::f64::consts::PI * t).sin()).product();
        let bump = if matches!(inside, Inside::Distorted) { 0.08 * bump } else { 0.0 };
        std::array::from_fn(|k| {
            let length = if k == D - 1 { 1.0 } else { WIDTH };
            length * (t[k] + bump * (1.0 + k as f64))
        })
    };
    let mesh = structured(divisions, shape, 1, map).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    Layer { mesh, space }
}

impl<const D: usize> Layer<D>
where
    Dim: Dimension<D>,
{
    /// The area of the flat below it.
    pub fn area(&self) -> f64 {
        WIDTH.powi(D as i32 - 1)
    }

    /// Periodic sideways, the top moved by (U, .., −δ).
    pub fn constraints(&self, aside: f64, down: f64) -> Constraints<D> {
        let mut constraints = Constraints::new(&self.space);
        let mut top = along::<D>(0, aside);
        top[D - 1] = -down;
        constraints.fix("top", |_| top).unwrap();
        let sides = [("left", "right"), ("front", "back")];
        for (axis, (from, to)) in sides.iter().enumerate().take(D - 1) {
            constraints.periodic(from, to, &RigidMap::translation(along(axis, WIDTH))).unwrap();
        }
        constraints
    }

    /// The law on the layer. One rule for all of its integrals.
    pub fn problem<L: ContactLaw<D>>(&self, law: L, aside: f64, down: f64) -> ContactProblem<D, L> {
        ContactProblem::new(&self.space, law, self.constraints(aside, down)).quadrature(Quadrature::Degree(4))
    }

    /// The largest slip and the smallest along the flat, at the nodes there.
    pub fn slips(&self, u: &Field<D>) -> (f64, f64) {
        let nodes = self.space.nodes_on("bottom").unwrap();
        let slips = nodes.iter().map(|node| u.at_node(*node as usize)[0]);
        slips.fold((f64::NEG_INFINITY, f64::INFINITY), |(most, least), s| (most.max(s), least.min(s)))
    }
}

/// Solves and compares the top's traction with (τ, .., −p) and the slip at the flat, each relative to `scale`.
pub fn check<L: ContactLaw<D>, const D: usize>(
    label: &str,
    layer: &Layer<D>,
    law: L,
    moved: [f64; 2],
    expected: Answer,
    tolerance: f64,
) where
    Dim: Dimension<D>,
{
    check_from(label, layer, law, moved, &Field::zero(&layer.space), expected, tolerance);
}

/// The same from another start than zero.
pub fn check_from<L: ContactLaw<D>, const D: usize>(
    label: &str,
    layer: &Layer<D>,
    law: L,
    moved: [f64; 2],
    start: &Field<D>,
    expected: Answer,
    tolerance: f64,
) where
    Dim: Dimension<D>,
{
    let problem = layer.problem(law, moved[0], moved[1]);
    // Strains that are finite converge quadratically, not at once.
    let options = NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    let solved = problem.direct().unwrap().start(start).options(options).solve();
    let solved = solved.unwrap_or_else(|error| panic!("{label}: {error}"));
    let reaction = solved.reaction("top").unwrap();
    let traction: Vec<f64> = reaction.iter().map(|force| force / layer.area()).collect();
    expected.check(label, &traction, layer.slips(solved.field()), tolerance);
}

/// Pressure, shear stress and slip.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    pub pressure: f64,
    pub shear: f64,
    pub slip: f64,
}

impl Answer {
    /// Tractions relative to the pressure, slips to 0.01, the size of the displacements.
    pub fn check(&self, label: &str, traction: &[f64], slips: (f64, f64), tolerance: f64) {
        let last = traction.len() - 1;
        let errors = [
            (traction[last] + self.pressure) / self.pressure,
            (traction[0] - self.shear) / self.pressure,
            (slips.0 - self.slip) / 0.01,
            (slips.1 - self.slip) / 0.01,
        ];
        println!("{label}: {errors:.1?}");
        assert!(errors.iter().all(|error| error.abs() < tolerance), "{label}: {errors:?}, {traction:?}");
        assert!(
            traction[1..last].iter().all(|t| t.abs() < tolerance * self.pressure),
            "{label}: {traction:?}"
        );
    }
}
