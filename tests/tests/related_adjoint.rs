//! The discrete adjoint (21) where unknowns are related: derivatives of the criterion by the load, on contact problems that
//! slide on a skew wall, repeat periodically or carry a rigid plate, against what is computed again.

use forms_contact::forms;
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;
use forms_fem::verification::{Sample, taylor};

fn traction(load: f64) -> Given<[f64; 2], 2> {
    Given::function(move |x: &[f64; 2]| [0.02 * load * x[0].sin(), -0.06 - 0.05 * load * x[0]])
}

/// The problem under another load.
fn loaded(problem: &ContactProblem<2>, load: f64) -> ContactProblem<2> {
    let mut changed = problem.clone();
    changed.law.data.traction = traction(load);
    changed
}

/// A block that sags onto a part of a wavy obstacle.
fn problem(relate: fn(&mut Constraints<2>)) -> ContactProblem<2> {
    // The sides lean, so that normals have two components.
    let lean = |[s, t]: [f64; 2]| [2.0 * s + 0.2 * t, t];
    let mesh = forms_fem::mesh::structured([8, 4], CellShape::Quadrilateral, 1, lean).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    relate(&mut constraints);
    let data = forms::data()
        .lambda(1.0)
        .mu(1.0)
        .gamma0(50.0)
        .obstacle_normal([0.0, -1.0])
        .gap(Given::function(|x| 0.15 + 0.15 * (std::f64::consts::PI * x[0]).cos()))
        .theta(0.0)
        .extension(0.0)
        .body_force([0.01, -0.05])
        .traction(traction(1.0))
        .criterion_force(Given::function(|x| [x[1], 1.0 + x[0]]))
        .criterion_weight(1.0);
    ContactProblem::new(
        &space,
        forms::Model { data, regions: forms::Regions::default().gamma_n("top").gamma_c("bottom") },
        constraints,
    )
    .quadrature(Quadrature::Degree(6))
}

fn criterion(problem: &ContactProblem<2>, u: &Field<2>) -> f64 {
    problem.criterion(u).unwrap()
}

fn solve(problem: &ContactProblem<2>) -> Field<2> {
    let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
    // Without contact the bodies float.
    let pressed = Field::interpolate(&problem.space, |_| [0.0, -0.3]).unwrap();
    problem.direct().unwrap().start(&pressed).options(options).solve().unwrap().into_field()
}

fn check(name: &str, relate: fn(&mut Constraints<2>)) {
    let start = problem(relate);
    assert!(!start.constraints.relations().is_empty());
    let u = solve(&start);
    let active = |problem: &ContactProblem<2>, u: &Field<2>| {
        problem.assembler.active_set(&problem.law.direct(), &[u]).unwrap()
    };
    // A part of the bottom touches.
    let touching = active(&start, &u).expect("contact is a kink");
    let count = touching.iter().filter(|&&switches| switches > 0).count();
    println!("{name}: {count} of {} points touch", touching.len());
    assert!(count > 0 && count < touching.len(), "{name}");
    let p = start.solve_adjoint(Adjoint::Discrete, &u, &mut TangentSolver::default()).unwrap().into_field();
    // The adjoint state obeys the homogeneous relations.
    let mut imposed = p.values().to_vec();
    start.constraints.homogeneous().apply(&mut imposed);
    assert!(imposed.iter().zip(p.values()).all(|(a, b)| (a - b).abs() < 1e-12), "{name}");
    // R is affine in the load.
    let residual = |load: f64| {
        let problem = loaded(&start, load);
        problem.assembler.residual(&problem.law.direct(), &[&u], &[&problem.space]).unwrap()
    };
    let by_load = residual(2.0).into_iter().zip(residual(1.0)).map(|(a, b)| a - b);
    let derivative: f64 = by_load.zip(p.values()).map(|(r, p)| r * p).sum();
    let value = |step: f64| {
        let moved = loaded(&start, 1.0 + step);
        let u = solve(&moved);
        (criterion(&moved, &u), active(&moved, &u))
    };
    let (above, below) = (value(1e-4), value(-1e-4));
    assert_eq!(above.1, below.1, "{name}: the points that touch are the same");
    let central = (above.0 - below.0) / 2e-4;
    println!("{name}: {derivative:e}, central difference {central:e}");
    assert!((derivative - central).abs() < 1e-7 * central.abs(), "{name}: {derivative} {central}");
    let report = taylor(0.02, &[derivative], |step| {
        let (value, active_set) = value(step);
        Ok::<_, AssemblyError>(Sample { value: vec![value], active_set })
    });
    println!("{name}: {}", report.unwrap().second_order().unwrap());
}

#[test]
fn sliding_on_skew_walls() {
    check("sliding", |constraints| {
        constraints.slide_along("left", |_| 0.0).unwrap();
        // The wall on the right moves in.
        constraints.slide_along("right", |_| -0.01).unwrap();
    });
}

#[test]
fn a_periodic_layer() {
    check("periodic", |constraints| {
        constraints.periodic("left", "right", &RigidMap::translation([2.0, 0.0])).unwrap();
        // Nothing else holds the layer along the obstacle.
        constraints.mean_value("all", 0, 0.01).unwrap();
    });
}

#[test]
fn a_rigid_plate() {
    check("rigid plate", |constraints| {
        constraints.rigid_body("top").unwrap();
        constraints.slide("left", |_| [1.0, 0.3], |_| 0.002).unwrap();
    });
}
