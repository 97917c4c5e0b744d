//! (3), the criterion: closed forms, plain loops, a Taylor test with its derivative in (21).

use std::f64::consts::PI;

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_fem::verification;
use forms_tests::bodies::{Body, data, plane_bodies, solid_bodies, wave};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::assert_close;

#[test]
fn interior_and_boundary_are_the_closed_form() {
    // u = (x, y) on the ring 1 < r < 2, F = (x, y), c = 3: M = ∫r² = π(2⁴ − 1)/2, N = ½·3·2π(1 + 2³).
    let mesh = annulus(1.0, 2.0, 2, 64, CellShape::Quadrilateral, 2).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let u = Field::interpolate(&space, |x| *x).unwrap();
    let (omega, boundary) = (forms::Omega::on("all"), forms::Boundary::on("boundary"));
    let data = data::<2>(0.0).criterion_force(|x: &[f64; 2]| *x).criterion_weight(3.0);
    let found = Assembler::new(&mesh).functional(&forms::criterion(&data, &omega, &boundary, &u));
    let exact = PI * 15.0 / 2.0 + 1.5 * 2.0 * PI * 9.0;
    let error = (found.unwrap() - exact).abs() / exact;
    // Quadratic arcs of π/32 enclose the circles up to (π/32)⁴/180 or so.
    assert!(error < 1e-6, "{error:.1e}");
    // On a square everything is exact: u = (x², y), F = (1, 2), c = 2: 1/3 + 1, and the sides give
    // ∫x⁴ + y² over y = 0, y = 1, x = 0, x = 1: 1/5 + 6/5 + 1/3 + 4/3.
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let u = Field::interpolate(&space, |x| [x[0] * x[0], x[1]]).unwrap();
    let data = data.criterion_force([1.0, 2.0]).criterion_weight(2.0);
    let found = Assembler::new(&mesh).functional(&forms::criterion(&data, &omega, &boundary, &u));
    assert_close("square", &[found.unwrap()], &[1.0 / 3.0 + 1.0 + 7.0 / 5.0 + 5.0 / 3.0], 1e-14);
}

fn check<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    let (assembler, space, data) = (&body.assembler, &body.space, data(1.0));
    let value = |u: &Field<D>| assembler.functional(&body.criterion(&data, u)).unwrap();
    assert_close(body.name, &[value(&body.u)], &[ByLoops::new(body, 1.0).criterion], 1e-13);
    // (21) at p = 0 is J′(u).
    let slope = assembler.residual(&body.discrete_adjoint(&data), &[&Field::zero(space)], &[space]).unwrap();
    let direction = wave(space, 0.1, 0.8);
    let slope: f64 = slope.iter().zip(direction.values()).map(|(slope, d)| slope * d).sum();
    let report = verification::taylor(1.0, &[slope], |step| {
        Ok::<_, AssemblyError>(value(&body.moved(step, &direction)).into())
    });
    println!("{}: order {:.4}", body.name, report.unwrap().second_order().unwrap());
}

#[test]
fn value_and_derivative_on_every_body() {
    plane_bodies().iter().for_each(check);
    solid_bodies().iter().for_each(check);
}
