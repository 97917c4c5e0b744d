//! (21), the discrete adjoint: matrix and right side against plain loops, and against the Lagrangian.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_tests::bodies::{Body, data, plane_bodies, solid_bodies, wave};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::{assert_close, assert_same_matrix, dense, deviation};
use forms_tests::taylor::assert_second_order;

fn against_loops<const D: usize>(body: &Body<D>)
where
    forms::discrete_adjoint::Form<D>: Form<D>,
{
    for theta in [-1.0, 0.0, 1.0] {
        let label = format!("{}, theta = {theta}", body.name);
        let (form, space) = (body.discrete_adjoint(&data(theta)), &body.space);
        let loops = ByLoops::new(body, theta);
        let zero = Field::zero(space);
        let side = body.assembler.residual(&form, &[&zero], &[space]).unwrap();
        let side: Vec<f64> = side.into_iter().map(|value| -value).collect();
        let r = assert_close(&label, &side, loops.discrete_side.as_slice(), 1e-13);
        let sparse = body.assembler.tangent(&form, &[&zero], &[space]).unwrap();
        let matrix = dense(&sparse);
        let k = assert_same_matrix(&label, &matrix, &loops.discrete, 1e-13);
        println!("{label}: right side {r:.1e}, matrix {k:.1e}");
        let asymmetry = deviation(matrix.transpose().as_slice(), matrix.as_slice());
        assert_eq!(theta == 1.0, asymmetry < 1e-14, "{label}: asymmetry {asymmetry:.1e}");
        // Affine in p: the matrix is the whole of its dependence.
        let p = wave(space, 1.0, 0.8);
        let found = body.assembler.residual(&form, &[&p], &[space]).unwrap();
        let product = sparse.multiply(p.values()).unwrap();
        let expected: Vec<f64> = product.iter().zip(&side).map(|(a, b)| a - b).collect();
        assert_close(&label, &found, &expected, 1e-13);
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
    forms::direct::Form<D>: Form<D>,
    forms::discrete_adjoint::Form<D>: Form<D>,
    forms::criterion::Form<D>: Functional<D>,
{
    let (assembler, space) = (&body.assembler, &body.space);
    let (p, direction) = (wave(space, 0.05, 0.8), wave(space, 1.0, 2.1));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for theta in [-1.0, 0.0, 1.0] {
        let label = format!("{}, theta = {theta}", body.name);
        let direct = body.direct(theta);
        let lagrangian = |step: f64| {
            let u = body.moved(step, &direction);
            let criterion = assembler.functional(&body.criterion(&data(theta), &u), &[]).unwrap();
            vec![criterion + product(&assembler.residual(&direct, &[&u], &[space]).unwrap(), p.values())]
        };
        let form = body.discrete_adjoint(&data(theta));
        let derivative = assembler.residual(&form, &[&p], &[space]).unwrap();
        let slope = product(&derivative, direction.values());
        let first = body.step_without_switch(theta, &direction);
        let order = assert_second_order(&label, first, lagrangian, &[slope]);
        println!("{label}: order {order:.4}");
    }
}

#[test]
fn it_is_the_derivative_of_the_lagrangian() {
    plane_bodies().iter().for_each(lagrangian);
    solid_bodies().iter().for_each(lagrangian);
}
