//! Conjugate gradients against known spectra.

use std::f64::consts::PI;

use super::*;
use crate::operator::{Identity, OperatorError};
use crate::threads::Threads;
use crate::vector::add_scaled;
use crate::{Analysis, CsrMatrix, LinearAlgebraError, Ordering, SymmetricFactor};

/// −u'' on n inner points of unit spacing: eigenvalues 2 − 2 cos(kπ/(n + 1)), eigenvectors sin(kπi/(n + 1)).
fn laplacian(n: usize) -> CsrMatrix {
    let mut triplets = vec![(0, 0, 2.0)];
    for i in 1..n {
        triplets.extend([(i, i, 2.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
    }
    CsrMatrix::from_triplets(n, n, &triplets).unwrap()
}

fn eigenvalue(n: usize, k: usize) -> f64 {
    2.0 - 2.0 * (k as f64 * PI / (n as f64 + 1.0)).cos()
}

fn mode(n: usize, k: usize) -> Vec<f64> {
    (1..=n).map(|i| ((i * k) as f64 * PI / (n as f64 + 1.0)).sin()).collect()
}

fn options(tolerance: f64, max_iterations: usize) -> KrylovOptions {
    KrylovOptions { tolerance, max_iterations, ..KrylovOptions::default() }
}

#[test]
fn as_many_iterations_as_modes() {
    let n = 200;
    let mut b = vec![0.0; n];
    let mut exact = vec![0.0; n];
    for (count, k) in [3, 50, 117, 180].into_iter().enumerate() {
        add_scaled(&mut b, 1.0, &mode(n, k));
        add_scaled(&mut exact, 1.0 / eigenvalue(n, k), &mode(n, k));
        let mut x = vec![0.0; n];
        let report = cg(&laplacian(n), &mut Identity, &b, &mut x, &options(1e-8, 50)).unwrap();
        assert_eq!(report.iterations, count + 1);
        assert!(x.iter().zip(&exact).all(|(a, b)| (a - b).abs() < 1e-8 / eigenvalue(n, 3)));
    }
}

#[test]
fn the_energy_of_the_error_falls_as_the_condition_says() {
    let n = 60;
    let matrix = laplacian(n);
    let exact: Vec<f64> = (0..n).map(|i| f64::from(i as u32 * 7 % 11) - 5.0).collect();
    let b = matrix.multiply(&exact).unwrap();
    let energy = |x: &[f64]| {
        let error: Vec<f64> = x.iter().zip(&exact).map(|(a, b)| a - b).collect();
        dot_on(Threads::ONE, &error, &matrix.multiply(&error).unwrap()).sqrt()
    };
    let root = (eigenvalue(n, n) / eigenvalue(n, 1)).sqrt();
    let factor = (root - 1.0) / (root + 1.0);
    let start = energy(&vec![0.0; n]);
    for k in [5, 15, 30, 45] {
        let mut x = vec![0.0; n];
        let found = cg(&matrix, &mut Identity, &b, &mut x, &options(0.0, k));
        assert!(matches!(found, Err(KrylovError::NotConverged(report)) if report.iterations == k));
        assert!(energy(&x) <= 2.0 * factor.powi(k as i32) * start * (1.0 + 1e-10));
    }
}

#[test]
fn a_factor_as_preconditioner_needs_one_iteration_and_threads_change_nothing() {
    let matrix = laplacian(90);
    let analysis = std::sync::Arc::new(Analysis::new(matrix.pattern(), &Ordering::default()).unwrap());
    let factor = SymmetricFactor::cholesky(&analysis, &matrix, Vec::new()).unwrap();
    let b = vec![1.0; 90];
    let mut x = vec![0.0; 90];
    let report = cg(&matrix, &mut &factor, &b, &mut x, &options(1e-11, 5)).unwrap();
    assert_eq!(report.iterations, 1);
    assert!(x.iter().enumerate().all(|(i, x)| (x - 0.5 * ((i + 1) * (90 - i)) as f64).abs() < 1e-8));
    let solve = |threads| {
        let mut x = vec![0.0; 50_000];
        let few = KrylovOptions { threads: Threads::new(threads), ..options(0.0, 5) };
        let found = cg(&laplacian(50_000), &mut Identity, &vec![1.0; 50_000], &mut x, &few);
        assert!(found.is_err());
        x
    };
    for threads in [2, 3, 7, 16] {
        assert_eq!(solve(1), solve(threads), "{threads}");
    }
}

/// A preconditioner that changes signs.
struct Negative;

impl Preconditioner for Negative {
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
        z.iter_mut().zip(r).for_each(|(z, r)| *z = -r);
        Ok(())
    }
}

#[test]
fn failures_have_a_reason() {
    let mut matrix = laplacian(5);
    let solve = |matrix: &CsrMatrix, b: &[f64]| {
        cg(matrix, &mut Identity, b, &mut vec![0.0; b.len()], &options(1e-10, 50))
    };
    assert_eq!(solve(&matrix, &[0.0; 5]).unwrap().iterations, 0);
    let nan = solve(&matrix, &[1.0, f64::NAN, 0.0, 0.0, 0.0]);
    assert!(matches!(
        nan,
        Err(KrylovError::BadArguments(LinearAlgebraError::VectorNotFinite { index: 1, .. }))
    ));
    assert!(matches!(solve(&matrix, &[1.0; 4]), Err(KrylovError::BadArguments(_))));
    let found = cg(&matrix, &mut Negative, &[1.0; 5], &mut [0.0; 5], &options(1e-10, 50));
    assert!(matches!(found, Err(KrylovError::IndefinitePreconditioner { product, .. }) if product < 0.0));
    matrix.values_mut().iter_mut().for_each(|value| *value = -*value);
    let found = solve(&matrix, &[1.0; 5]).unwrap_err();
    assert!(matches!(&found, KrylovError::NotPositiveDefinite { curvature, .. } if *curvature < 0.0));
    assert_eq!(found.report().unwrap().history, [1.0]);
    matrix.values_mut()[0] = f64::NAN;
    assert!(matches!(solve(&matrix, &[1.0; 5]), Err(KrylovError::NotFinite(_))));
}
