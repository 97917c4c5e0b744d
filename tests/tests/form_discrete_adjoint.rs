//! (21), the discrete adjoint: matrix and right side against plain loops, and against the Lagrangian.

use forms_fem::prelude::*;
use forms_fem::verification;
use forms_tests::adjoint_form::check_adjoint;
use forms_tests::bodies::{Body, data, plane_bodies, solid_bodies, wave};
use forms_tests::contact_by_loops::ByLoops;

fn against_loops<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    for theta in [-1.0, 0.0, 1.0] {
        let form = body.discrete_adjoint(&data(theta));
        let loops = ByLoops::new(body, theta);
        check_adjoint(body, theta, &form, &loops.discrete, &loops.discrete_side);
    }
}

#[test]
fn matrix_and_right_side_are_those_of_plain_loops() {
    plane_bodies().iter().for_each(against_loops);
    solid_bodies().iter().for_each(against_loops);
}

/// (21) is the derivative by u of the Lagrangian J(u) + R(u; p), in every direction.
fn lagrangian<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    let (assembler, space) = (&body.assembler, &body.space);
    let (p, direction) = (wave(space, 0.05, 0.8), wave(space, 1.0, 2.1));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for theta in [-1.0, 0.0, 1.0] {
        let label = format!("{}, theta = {theta}", body.name);
        let direct = body.direct(theta);
        let lagrangian = |step: f64| {
            let u = body.moved(step, &direction);
            let criterion = assembler.functional(&body.criterion(&data(theta), &u)).unwrap();
            let work = product(&assembler.residual(&direct, &[&u], &[space])?, p.values());
            Ok::<_, AssemblyError>(verification::Sample::from(criterion + work))
        };
        let form = body.discrete_adjoint(&data(theta));
        let derivative = assembler.residual(&form, &[&p], &[space]).unwrap();
        let slope = product(&derivative, direction.values());
        let first = body.step_without_switch(theta, &direction);
        let report = verification::taylor(first, &[slope], lagrangian).unwrap();
        let order = report.second_order().unwrap();
        println!("{label}: order {order:.4}");
    }
}

#[test]
fn it_is_the_derivative_of_the_lagrangian() {
    plane_bodies().iter().for_each(lagrangian);
    solid_bodies().iter().for_each(lagrangian);
}
