//! Identities of every adjoint form, on a body and for a θ.

use forms_fem::prelude::*;
use nalgebra::{DMatrix, DVector};

use crate::bodies::{Body, wave};
use crate::dense::{assert_close, assert_same_matrix, dense, deviation};

/// Matrix and right side are the expected ones, the matrix is symmetric exactly for θ = 1, and the form is
/// affine in its unknown. Gives the right side back.
pub fn check_adjoint<const D: usize>(
    body: &Body<D>,
    theta: f64,
    form: &Form<D>,
    expected: &DMatrix<f64>,
    expected_side: &DVector<f64>,
) -> Vec<f64> {
    let label = format!("{}, {}, theta = {theta}", form.name(), body.name);
    let space = &body.space;
    let zero = Field::zero(space);
    let side = body.assembler.residual(form, &[&zero], &[space]).unwrap();
    let side: Vec<f64> = side.into_iter().map(|value| -value).collect();
    let r = assert_close(&label, &side, expected_side.as_slice(), 1e-13);
    let sparse = body.assembler.tangent(form, &[&zero], &[space]).unwrap();
    let matrix = dense(&sparse);
    let k = assert_same_matrix(&label, &matrix, expected, 1e-13);
    println!("{label}: right side {r:.1e}, matrix {k:.1e}");
    let asymmetry = deviation(matrix.transpose().as_slice(), matrix.as_slice());
    assert_eq!(theta == 1.0, asymmetry < 1e-14, "{label}: asymmetry {asymmetry:.1e}");
    // Affine: the matrix is the whole of its dependence.
    let p = wave(space, 1.0, 0.8);
    let found = body.assembler.residual(form, &[&p], &[space]).unwrap();
    let product = sparse.multiply(p.values()).unwrap();
    let rest: Vec<f64> = product.iter().zip(&side).map(|(a, b)| a - b).collect();
    assert_close(&label, &found, &rest, 1e-13);
    side
}
