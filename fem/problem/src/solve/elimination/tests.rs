//! Eliminated unknowns on a line between two ends: solutions, transposed problems, prescriptions that are refused.

use super::*;
use crate::solve::{TangentSolver, solve_linear, solve_linear_transposed};

/// Rows of −u'' on 0..=n with unit spacing (the end rows as they come), plus an unsymmetric entry.
fn line(n: usize, extra: f64) -> BlockMatrix {
    let mut triplets = Vec::new();
    for i in 0..n {
        triplets.extend([(i, i, 1.0), (i + 1, i + 1, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0)]);
    }
    triplets.push((1, 2, extra));
    CsrMatrix::from_triplets(n + 1, n + 1, &triplets).unwrap().into()
}

#[test]
fn a_line_between_two_prescribed_ends() {
    let prescribed = BTreeMap::from([(0, 3.0), (10, 8.0)]);
    let mut elimination = Elimination::new(11, &prescribed).unwrap();
    let mut solver = TangentSolver::default();
    let found = solve_linear(&line(10, 0.0), &[0.0; 11], &mut elimination, &mut solver).unwrap();
    for (i, value) in found.solution.iter().enumerate() {
        assert!((value - (3.0 + 0.5 * i as f64)).abs() < 1e-13);
    }
}

#[test]
fn the_transposed_problem_is_the_problem_of_the_transposed_matrix() {
    let prescribed = BTreeMap::from([(0, 1.0), (5, -2.0)]);
    let mut elimination = Elimination::new(11, &prescribed).unwrap();
    let mut solver = TangentSolver::default();
    let b: Vec<f64> = (0..11).map(|i| f64::from(i) * 0.1).collect();
    let matrix = line(10, 0.4);
    let one = solve_linear_transposed(&matrix, &b, &mut elimination, &mut solver).unwrap().solution;
    let residual = matrix.multiply_transposed(&one).unwrap();
    for i in 0..11 {
        if let Some(value) = prescribed.get(&i) {
            assert_eq!(one[i], *value);
        } else {
            assert!((residual[i] - b[i]).abs() < 1e-12);
        }
    }
    let transposed = matrix.to_csr().transpose().into();
    let two = solve_linear(&transposed, &b, &mut elimination, &mut solver).unwrap().solution;
    assert!(one.iter().zip(&two).all(|(a, b)| (a - b).abs() < 1e-11));
}

#[test]
fn bad_prescriptions_are_refused() {
    assert!(matches!(
        Elimination::new(3, &BTreeMap::from([(3, 0.0)])),
        Err(LinearAlgebraError::IndexOutOfRange { index: 3, .. })
    ));
    assert!(matches!(
        Elimination::new(3, &BTreeMap::from([(1, f64::NAN)])),
        Err(LinearAlgebraError::VectorNotFinite { index: 1, .. })
    ));
    let elimination = Elimination::new(3, &BTreeMap::from([(1, 4.0)])).unwrap();
    assert_eq!(elimination.free(), [0, 2]);
    assert!(elimination.reduce(&[1.0]).is_err());
    assert_eq!(elimination.extend_by_zero(&[5.0, 6.0]).unwrap(), [5.0, 0.0, 6.0]);
}
