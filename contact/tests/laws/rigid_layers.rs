//! Layers on a rigid flat: answers in closed form, whatever the facets of the flat.

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as law;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{RigidSurface, structured};
use forms_fem::prelude::*;

use crate::rigid_tools::data;
use crate::setting::{LAMBDA, MU, along};

const WIDTH: f64 = 1.5;

/// Which law: small strains on the pairs of the undeformed mesh, or rubber with pairs that slide.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Strains {
    Small,
    Finite,
}

/// A flat below y = 0 that looks up, wider than the layer, in parts that fit no mesh.
fn flat<const D: usize>() -> RigidSurface<D> {
    let places = [-0.4, 0.31, 0.8, 1.13, 2.0];
    let (mut points, mut facets) = (vec![], vec![]);
    for (i, &x) in places.iter().enumerate() {
        let rows = if D == 2 { 1 } else { places.len() };
        for (j, &z) in places.iter().take(rows).enumerate() {
            points.push(std::array::from_fn(|k| {
                if k + 1 == D {
                    0.0
                } else if k == 0 {
                    x
                } else {
                    z
                }
            }));
            let (here, n) = ((i * rows + j) as u32, rows as u32);
            if D == 2 && i > 0 {
                facets.push(std::array::from_fn(|k| if k == 0 { here } else { here - 1 }));
            } else if i > 0 && j > 0 {
                let corners = [here - n - 1, here - 1, here, here - n];
                facets.push(std::array::from_fn(|k| corners[[0, 1, 2][k]]));
                facets.push(std::array::from_fn(|k| corners[[0, 2, 3][k]]));
            }
        }
    }
    RigidSurface::new(points, facets).unwrap()
}

/// The layer of height 1, periodic sideways, on the flat; its top moved by (U, .., −δ).
fn layer<const D: usize>(
    shape: CellShape,
    degree: usize,
) -> (Arc<Space<D>>, impl Fn(f64, f64) -> Constraints<D>) {
    let mut divisions = [3; D];
    divisions[D - 1] = 2;
    let place =
        |t: [f64; D]| -> [f64; D] { std::array::from_fn(|k| if k == D - 1 { t[k] } else { WIDTH * t[k] }) };
    let body = structured(divisions, shape, 1, place).unwrap();
    let mesh = body.with_rigid_surfaces(&[("flat", &flat::<D>())]).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let of = space.clone();
    let constraints = move |aside: f64, down: f64| {
        let mut constraints = Constraints::new(&of);
        let mut top = along::<D>(0, aside);
        top[D - 1] = -down;
        constraints.fix("top", |_| top).unwrap();
        for (axis, (from, to)) in [("left", "right"), ("front", "back")].iter().enumerate().take(D - 1) {
            constraints.periodic(from, to, &RigidMap::translation(along(axis, WIDTH))).unwrap();
        }
        constraints.move_rigidly("flat", &RigidMap::translation([0.0; D])).unwrap();
        constraints
    };
    (space, constraints)
}

/// p = (λ + 2μ) δ, and τ = μ U below κ p/μ, else κ p; of rubber p = μ(1/J − J) − λ ln J/J.
fn layer_answer<const D: usize>(shape: CellShape, degree: usize, strains: Strains)
where
    Dim: Dimension<D>,
{
    let (space, constraints) = layer::<D>(shape, degree);
    let area = WIDTH.powi(D as i32 - 1);
    let touch = Pairing::onto("bottom", "flat");
    let down = if strains == Strains::Small { 0.01 } else { 0.2 };
    let pressure = match strains {
        Strains::Small => (LAMBDA + 2.0 * MU) * down,
        Strains::Finite => {
            let stretch = 1.0 - down;
            MU * (1.0 / stretch - stretch) - LAMBDA * stretch.ln() / stretch
        }
    };
    for (aside, shear) in
        [(0.4 * 0.3 * pressure / MU, 0.4 * 0.3 * pressure), (0.5 * pressure / MU, 0.3 * pressure)]
    {
        let solved = match strains {
            Strains::Small => {
                let regions = law::Regions::default().touch(touch.clone()).gamma_n("top");
                let model = law::Model { data: data::<D>(0.3, 0), regions };
                let problem = ContactProblem::new(&space, model, constraints(aside, down))
                    .quadrature(Quadrature::Degree(4));
                problem.direct().unwrap().solve().unwrap()
            }
            Strains::Finite => {
                let regions = sliding::Regions::default().touch(touch.clone()).gamma_n("top");
                let model = sliding::Model { data: data::<D>(0.3, 0), regions };
                let problem = ContactProblem::new(&space, model, constraints(aside, down))
                    .quadrature(Quadrature::Degree(4));
                let slid = aside - shear / MU;
                // The flat stays where it is, also at the start.
                let start = Field::interpolate(&space, |x: &[f64; D]| -> [f64; D] {
                    let mut u = along::<D>(0, 0.98 * (slid + (aside - slid) * x[D - 1]));
                    u[D - 1] = -0.98 * down * x[D - 1];
                    u
                });
                problem.direct().unwrap().start(&start.unwrap()).solve().unwrap()
            }
        };
        let (top, tool) = (solved.reaction("top").unwrap(), solved.reaction("flat").unwrap());
        for (axis, expected) in [(D - 1, -pressure), (0, shear)] {
            let found = top[axis] / area;
            assert!(
                (found - expected).abs() < 1e-10 * pressure,
                "{D}D {shape:?} {degree} {strains:?}: {found} is not {expected}"
            );
            let sum = top[axis] + tool[axis];
            assert!(sum.abs() < 1e-10 * pressure, "{D}D {shape:?}: supports leave {sum:e}");
        }
    }
}

#[test]
fn layers_on_a_rigid_flat() {
    for strains in [Strains::Small, Strains::Finite] {
        layer_answer::<2>(CellShape::Quadrilateral, 2, strains);
        layer_answer::<2>(CellShape::Triangle, 1, strains);
        layer_answer::<3>(CellShape::Hexahedron, 1, strains);
        layer_answer::<3>(CellShape::Tetrahedron, 2, strains);
    }
}
