//! A layer of two bodies, one on the other and periodic sideways: pressure, stick and slip compared with closed forms on meshes that do not match;
//! tangents and adjoints.

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as law;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::setting::{LAMBDA, MU, POISSON, THETAS, YOUNG, along};

/// Width \[length\].
pub const WIDTH: f64 = 1.5;

/// Two layers of height ½ with the given number of cells sideways, the upper one `apart` above the lower one.
pub fn layers<const D: usize>(shape: CellShape, cells: [usize; 2], apart: f64) -> Mesh<D> {
    let body = |count: usize, bottom: f64| {
        let mut divisions = [count; D];
        divisions[D - 1] = 2;
        let place = |t: [f64; D]| -> [f64; D] {
            std::array::from_fn(|k| if k == D - 1 { bottom + 0.5 * t[k] } else { WIDTH * t[k] })
        };
        structured(divisions, shape, 1, place).unwrap()
    };
    let (lower, upper) = (body(cells[0], 0.0), body(cells[1], 0.5 + apart));
    Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap()
}

/// The lowest side held, the highest moved by (U, .., −δ), the others periodic.
pub fn constraints<const D: usize>(space: &Arc<Space<D>>, aside: f64, down: f64) -> Constraints<D> {
    let mut constraints = Constraints::new(space);
    let mut top = along::<D>(0, aside);
    top[D - 1] = -down;
    constraints.fix("lower bottom", |_| [0.0; D]).unwrap();
    constraints.fix("upper top", |_| top).unwrap();
    let sides = [("left", "right"), ("front", "back")];
    for body in ["lower", "upper"] {
        for (axis, (from, to)) in sides.iter().enumerate().take(D - 1) {
            let map = RigidMap::translation(along(axis, WIDTH));
            constraints.periodic(&format!("{body} {from}"), &format!("{body} {to}"), &map).unwrap();
        }
    }
    constraints
}

fn data<const D: usize>(friction: f64, theta: f64, share: f64) -> law::Data<D> {
    law::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(20.0 * YOUNG)
        .theta(theta)
        .share(share)
        .friction(friction)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]))
}

pub fn pairings() -> [(Pairing, f64); 3] {
    let (lower, upper) = ("lower top", "upper bottom");
    [
        (Pairing::between(lower, upper), 0.5),
        (Pairing::onto(lower, upper), 1.0),
        (Pairing::onto(upper, lower), 1.0),
    ]
}

/// p = (λ + 2μ) δ, and τ = μ U below κ p/μ, else κ p.
fn layer_answer<const D: usize>(shape: CellShape, cells: [usize; 2], thetas: &[f64])
where
    Dim: Dimension<D>,
{
    let mesh = layers::<D>(shape, cells, 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let area = WIDTH.powi(D as i32 - 1);
    let pressure = (LAMBDA + 2.0 * MU) * 0.01;
    for (pairing, share) in pairings() {
        for &theta in thetas {
            for (aside, shear) in [(0.008, MU * 0.008), (0.02, 0.3 * pressure)] {
                let regions = law::Regions::default().touch(pairing.clone()).gamma_n("upper top");
                let model = law::Model { data: data::<D>(0.3, theta, share), regions };
                let constraints = constraints(&space, aside, 0.01);
                let problem = ContactProblem::new(&space, model, constraints);
                let solved = problem.direct().unwrap().solve().unwrap();
                let reaction = solved.reaction("upper top").unwrap();
                let found = [reaction[D - 1] / area, reaction[0] / area];
                for (found, expected) in found.into_iter().zip([-pressure, shear]) {
                    assert!(
                        (found - expected).abs() < 1e-11 * pressure,
                        "{shape:?} theta {theta} {pairing}: {found} is not {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn layers_in_two_bodies() {
    layer_answer::<2>(CellShape::Quadrilateral, [3, 4], &THETAS);
    layer_answer::<2>(CellShape::Triangle, [3, 2], &[0.0]);
    layer_answer::<3>(CellShape::Hexahedron, [2, 3], &[0.0]);
}

#[test]
fn tangents_and_adjoints() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 2).unwrap();
    let solve = |friction: f64| {
        let regions =
            law::Regions::default().touch(Pairing::between("lower top", "upper bottom")).gamma_n("upper top");
        let model = law::Model { data: data::<2>(friction, 1.0, 0.5), regions };
        let problem = ContactProblem::new(&space, model, constraints(&space, 0.02, 0.01));
        let [u] = problem.direct().unwrap().solve().unwrap().fields;
        (problem, u)
    };
    let (problem, u) = solve(0.3);
    let direction =
        Field::interpolate(&space, |x: &[f64; 2]| [(3.0 * x[1]).sin(), (2.0 * x[0]).cos()]).unwrap();
    let report =
        verification::tangent(&problem.assembler, &problem.law.direct(), &[&u], &[&direction], 1e-6).unwrap();
    assert!(report.second_order().unwrap() > 1.95, "{report:?}");
    let [p] = problem.adjoint(&u).unwrap().solve().unwrap().fields;
    let slope = problem.assembler.functional(&problem.law.by_friction(&u, &p)).unwrap();
    let value = |friction: f64| {
        let (problem, u) = solve(friction);
        problem.assembler.functional(&problem.law.criterion(&u)).unwrap()
    };
    let step = 1e-4;
    let difference = (value(0.3 + step) - value(0.3 - step)) / (2.0 * step);
    assert!((slope - difference).abs() < 1e-8 * slope.abs(), "{slope}, by differences {difference}");
}

/// F = [[1, k], [0, J]] in both bodies: p = μ(1/J − J) − λ ln J/J, τ = μ k while they stick together.
fn finite_layer<const D: usize>(pairing: Pairing, share: f64)
where
    Dim: Dimension<D>,
{
    let (apart, stretch, shear) = (0.01, 0.8, 0.2_f64);
    let mesh = layers::<D>(CellShape::Quadrilateral, [3, 3], apart);
    let space = Space::vector(&mesh, 1).unwrap();
    let area = WIDTH.powi(D as i32 - 1);
    let exact = |x: &[f64; D]| -> [f64; D] {
        let height = if x[D - 1] > 0.505 { x[D - 1] - apart } else { x[D - 1] };
        let mut u = along::<D>(0, shear * height);
        u[D - 1] = stretch * height - x[D - 1];
        u
    };
    let start = Field::interpolate(&space, |x: &[f64; D]| exact(x).map(|u| 0.98 * u)).unwrap();
    let regions = sliding::Regions::default().touch(pairing).gamma_n("upper top");
    let model = sliding::Model { data: data::<D>(0.3, 0.0, share), regions };
    let down = 1.0 + apart - stretch;
    let problem = ContactProblem::new(&space, model, constraints(&space, shear, down));
    let solved = problem.direct().unwrap().start(&start).solve().unwrap();
    let reaction = solved.reaction("upper top").unwrap();
    let pressure = MU * (1.0 / stretch - stretch) - LAMBDA * stretch.ln() / stretch;
    for (found, expected) in [(reaction[D - 1], -pressure), (reaction[0], MU * shear)] {
        let found = found / area;
        assert!((found - expected).abs() < 1e-10 * pressure, "{found} is not {expected}");
    }
}

#[test]
fn layers_of_rubber_in_two_bodies() {
    for (pairing, share) in pairings() {
        finite_layer::<2>(pairing, share);
    }
}

/// A sloped interface of meshes that do not match, sticking: one uniform stress in both bodies, for all variants, by either surface or both.
#[test]
fn a_uniform_stress_goes_through_a_sloped_interface() {
    let body = |cells: [usize; 2], [low, high]: [fn(f64) -> f64; 2]| {
        structured(cells, CellShape::Quadrilateral, 1, |[s, t]: [f64; 2]| {
            let x = WIDTH * s;
            [x, low(x) * (1.0 - t) + high(x) * t]
        })
        .unwrap()
    };
    let interface: fn(f64) -> f64 = |x| 0.25 * (x - 0.5 * WIDTH);
    let (lower, upper) = (body([3, 2], [|_| -0.5, interface]), body([4, 2], [interface, |_| 0.5]));
    let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let down = 0.01;
    let mut held = Constraints::new(&space);
    held.fix_component("lower bottom", 1, |_| 0.0).unwrap();
    held.fix_component("upper top", 1, |_| -down).unwrap();
    held.fix_component("lower left", 0, |_| 0.0).unwrap();
    held.fix_component("upper left", 0, |_| 0.0).unwrap();
    // Plane strain with free sides, height 1.
    let pressure = YOUNG / (1.0 - POISSON * POISSON) * down;
    for (pairing, share) in pairings() {
        for theta in THETAS {
            let sticks = data::<2>(0.0, theta, share).slip_stress(1e6);
            let regions = law::Regions::default().touch(pairing.clone()).gamma_n("upper right");
            let model = law::Model { data: sticks, regions };
            let problem = ContactProblem::new(&space, model, held.clone());
            let u = problem.direct().unwrap().solve().unwrap().into_field();
            let stress =
                problem.assembler.at_quadrature_points(&problem.law.stress(&u), Entity::Cells, "all", 2);
            let worst = stress.unwrap().values.iter().fold(0.0_f64, |worst, value| {
                let errors =
                    value.iter().zip([0.0, 0.0, 0.0, -pressure]).map(|(found, exact)| (found - exact).abs());
                errors.fold(worst, f64::max)
            });
            println!("theta {theta} {pairing}: {:.1e}", worst / pressure);
            assert!(worst < 1e-11 * pressure, "theta {theta} {pairing}: {worst:e} of {pressure}");
        }
    }
}
