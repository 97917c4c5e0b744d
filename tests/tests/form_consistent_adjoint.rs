//! (22), the consistent adjoint: matrix and right side (with N′ on Γ_C) against plain loops, and its symmetry.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_tests::bodies::{Body, data, plane_bodies, solid_bodies, wave};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::{assert_close, assert_same_matrix, dense, deviation};

fn against_loops<const D: usize>(body: &Body<D>)
where
    forms::consistent_adjoint::Form<D>: Form<D>,
{
    for theta in [-1.0, 0.0, 1.0] {
        let label = format!("{}, theta = {theta}", body.name);
        let (form, space) = (body.consistent_adjoint(&data(theta)), &body.space);
        let loops = ByLoops::new(body, theta);
        let zero = Field::zero(space);
        let side = body.assembler.residual(&form, &[&zero], &[space]).unwrap();
        let side: Vec<f64> = side.into_iter().map(|value| -value).collect();
        let r = assert_close(&label, &side, loops.consistent_side.as_slice(), 1e-13);
        let sparse = body.assembler.tangent(&form, &[&zero], &[space]).unwrap();
        let matrix = dense(&sparse);
        let k = assert_same_matrix(&label, &matrix, &loops.consistent, 1e-13);
        println!("{label}: right side {r:.1e}, matrix {k:.1e}");
        // N′_n on Γ_C makes a right side of its own.
        assert!(deviation(&side, loops.discrete_side.as_slice()) > 1e-3, "{label}");
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
