//! Symmetric and unsymmetric tangents by their residuals.

mod saddle_points;

use super::*;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::solver_report::SolverPath;

/// A chain of n springs of stiffness 1, clamped at both ends, whose last two unknowns are coupled by an
/// extra block [0 s; −s p].
fn chain(n: usize, s: f64, p: f64) -> CsrMatrix {
    let mut triplets = vec![(0, 0, 2.0)];
    for i in 1..n {
        triplets.extend([(i, i, 2.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
    }
    triplets.extend([(n - 2, n - 1, s), (n - 1, n - 2, -s), (n - 1, n - 1, p)]);
    CsrMatrix::from_triplets(n, n, &triplets).unwrap()
}

fn error(found: &[f64], expected: &[f64]) -> f64 {
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn parabola(n: usize) -> Vec<f64> {
    (1..=n).map(|i| 0.5 * (i * (n + 1 - i)) as f64).collect()
}

#[test]
fn a_symmetric_chain_is_solved_directly() {
    let mut solver = TangentSolver::default();
    assert_eq!(solver.solve(&[1.0], 0.0).unwrap_err(), SolverError::NoMatrix);
    solver.set_matrix(chain(50, 0.0, 0.0)).unwrap();
    let found = solver.solve(&[1.0; 50], 0.0).unwrap();
    assert!(error(&found.solution, &parabola(50)) < 1e-10);
    assert_eq!(found.iterations, 0);
    solver.set_matrix(chain(50, 0.0, 0.0)).unwrap();
    assert_eq!(solver.report().factorisations, 1);
    assert_eq!(solver.is_positive_definite(), Some(true));
    assert!(solver.solve(&[1.0; 3], 0.0).is_err());
}

#[test]
fn one_factor_serves_unsymmetric_matrices_and_their_transposes() {
    let options = TangentSolverOptions { refresh_after: Some(10), ..TangentSolverOptions::default() };
    let mut solver = TangentSolver::new(options);
    let exact: Vec<f64> = (0..50).map(|i| (0.2 * f64::from(i)).cos()).collect();
    for (s, p) in [(0.0, 0.0), (0.7, 1.0), (0.9, 1.5), (0.9, 1.5)] {
        let matrix = chain(50, s, p);
        solver.set_matrix(matrix.clone()).unwrap();
        let found = solver.solve(&matrix.multiply(&exact).unwrap(), 0.0).unwrap();
        assert!(error(&found.solution, &exact) < 1e-11);
        let found = solver.solve_transposed(&matrix.multiply_transposed(&exact).unwrap(), 0.0).unwrap();
        assert!(error(&found.solution, &exact) < 1e-11);
        assert!(found.iterations <= 4, "a change of rank 2 took {} iterations", found.iterations);
    }
    let report = solver.report();
    assert_eq!((report.analyses, report.factorisations, report.solves), (1, 1, 8));
    assert!(report.largest_residual <= 1e-13);
}

#[test]
fn an_indefinite_symmetric_part_is_factored_all_the_same() {
    let mut solver = TangentSolver::default();
    let exact: Vec<f64> = (0..30).map(|i| f64::from(i % 7) - 3.0).collect();
    for s in [0.0, 0.5] {
        let matrix = chain(30, s, -9.0);
        solver.set_matrix(matrix.clone()).unwrap();
        let found = solver.solve_transposed(&matrix.multiply_transposed(&exact).unwrap(), 0.0).unwrap();
        assert!(error(&found.solution, &exact) < 1e-11);
        assert_eq!(solver.is_positive_definite(), Some(false));
    }
    assert_eq!(solver.report().indefinite_factorisations, 1);
}

#[test]
fn a_poor_factor_is_refreshed() {
    let options = TangentSolverOptions { refresh_after: Some(2), ..TangentSolverOptions::default() };
    let mut solver = TangentSolver::new(options);
    let n = 60;
    solver.set_matrix(chain(n, 0.1, 0.0)).unwrap();
    solver.solve(&vec![1.0; n], 0.0).unwrap();
    // Different everywhere: the old factor is a poor preconditioner.
    let mut other = chain(n, 0.1, 0.0);
    let pattern = other.pattern().clone();
    for row in 0..n {
        let position = pattern.find(row, row).unwrap();
        other.values_mut()[position] += (1.0 + (row as f64).sin()) * 3.0;
    }
    let b = other.multiply(&vec![2.0; n]).unwrap();
    for expected_factorisations in [1, 2, 2] {
        solver.set_matrix(other.clone()).unwrap();
        assert!(error(&solver.solve(&b, 0.0).unwrap().solution, &vec![2.0; n]) < 1e-11);
        assert_eq!(solver.report().factorisations, expected_factorisations);
    }
}

#[test]
fn singular_and_nan_matrices_are_errors_and_leave_no_matrix() {
    let mut solver = TangentSolver::default();
    let mut matrix = chain(5, 0.0, 0.0);
    matrix.values_mut()[3] = f64::NAN;
    assert!(matches!(
        solver.set_matrix(matrix),
        Err(SolverError::LinearAlgebra(LinearAlgebraError::EntryNotFinite { .. }))
    ));
    let zero = CsrMatrix::zero(chain(5, 0.0, 0.0).pattern());
    assert!(matches!(
        solver.set_matrix(zero),
        Err(SolverError::LinearAlgebra(LinearAlgebraError::Singular { .. }))
    ));
    assert_eq!(solver.solve(&[1.0; 5], 0.0).unwrap_err(), SolverError::NoMatrix);
    solver.set_matrix(chain(5, 0.3, 0.0)).unwrap();
    assert!(solver.solve(&[f64::NAN, 0.0, 0.0, 0.0, 0.0], 0.0).is_err());
}

#[test]
fn each_path_is_taken_and_named() {
    let mut saddle = chain(6, 0.0, 0.0);
    let place = saddle.pattern().find(5, 5).unwrap();
    saddle.values_mut()[place] = 0.0;
    let cases = [
        (chain(40, 0.0, 0.0), SolverPath::Cholesky),
        (chain(40, 0.0, -9.0), SolverPath::SignedCholesky),
        (chain(40, 0.0, -1.9), SolverPath::Indefinite),
        (chain(40, 0.4, 0.0), SolverPath::Gmres),
        (saddle, SolverPath::SignedCholesky),
        (chain(40, 0.4, -2.0), SolverPath::Lu),
    ];
    for (matrix, path) in cases {
        let mut solver = TangentSolver::default();
        assert_eq!(solver.report().path, None);
        solver.set_matrix(matrix.clone()).unwrap();
        let found = solver.solve(&vec![1.0; matrix.rows()], 0.0).unwrap().solution;
        assert!(error(&matrix.multiply(&found).unwrap(), &vec![1.0; matrix.rows()]) < 1e-10);
        assert_eq!(solver.report().path, Some(path));
    }
}

#[test]
fn lu_follows_where_gmres_takes_longer() {
    let exact: Vec<f64> = (0..600).map(|i| (0.2 * f64::from(i)).cos()).collect();
    for (lu_after, path) in [(Some(0), SolverPath::Lu), (None, SolverPath::Gmres)] {
        let mut solver = TangentSolver::new(TangentSolverOptions { lu_after, ..Default::default() });
        for (s, expected) in [(0.7, SolverPath::Gmres), (0.8, path), (0.9, path)] {
            let matrix = chain(600, s, 1.0);
            solver.set_matrix(matrix.clone()).unwrap();
            let found = solver.solve(&matrix.multiply(&exact).unwrap(), 0.0).unwrap();
            assert!(error(&found.solution, &exact) < 1e-9, "{}", error(&found.solution, &exact));
            let found = solver.solve_transposed(&matrix.multiply_transposed(&exact).unwrap(), 0.0).unwrap();
            assert!(error(&found.solution, &exact) < 1e-9, "{}", error(&found.solution, &exact));
            assert_eq!(solver.report().path, Some(expected));
        }
        let report = solver.report();
        assert_eq!(report.lu_factorisations, if path == SolverPath::Lu { 2 } else { 0 });
        assert_eq!(report.analyses, 1);
        // A symmetric matrix has its own factor again.
        solver.set_matrix(chain(600, 0.0, 0.0)).unwrap();
        solver.solve(&exact, 0.0).unwrap();
        assert_eq!(solver.report().path, Some(SolverPath::Cholesky));
    }
}

#[test]
fn orderings_and_condition_are_reported() {
    let mut solver = TangentSolver::default();
    assert_eq!(solver.estimate_condition().unwrap_err(), SolverError::NoMatrix);
    solver.set_matrix(chain(99, 0.0, 0.0)).unwrap();
    // ‖A‖₁ = 4 and ‖A⁻¹‖₁ = (n + 1)² / 8.
    assert!((solver.estimate_condition().unwrap().condition - 5000.0).abs() < 1e-6);
    assert!((solver.report().condition.unwrap() - 5000.0).abs() < 1e-6);
    let names: Vec<_> = solver.report().orderings.iter().map(|candidate| candidate.name).collect();
    assert_eq!(names, ["minimum degree"]);
    let fill = solver.report().orderings[0].fill.unwrap();
    assert!(fill.entries >= 197.0 && fill.entries <= 99.0 * 3.0, "{fill:?}");
}

#[test]
fn a_solver_that_cannot_converge_tells_its_history() {
    // One iteration is not enough, and LU takes over: the answer is right all the same.
    let options = TangentSolverOptions { max_iterations: 1, ..TangentSolverOptions::default() };
    let mut solver = TangentSolver::new(options);
    let matrix = chain(40, 0.4, 0.0);
    solver.set_matrix(matrix.clone()).unwrap();
    let found = solver.solve(&[1.0; 40], 0.0).unwrap().solution;
    assert!(error(&matrix.multiply(&found).unwrap(), &[1.0; 40]) < 1e-10);
    assert_eq!((solver.report().path, solver.report().lu_factorisations), (Some(SolverPath::Lu), 1));
}

/// A chain of springs that a multiplier holds in its middle, with an entry on the multiplier's diagonal.
fn held_chain(n: usize, sign: f64, rest: f64) -> CsrMatrix {
    let mut triplets = vec![(n / 2, n, 1.0), (n, n / 2, sign), (n, n, rest)];
    for i in 0..n {
        triplets.push((i, i, 2.0));
        if i > 0 {
            triplets.extend([(i, i - 1, -1.0), (i - 1, i, -1.0)]);
        }
    }
    CsrMatrix::from_triplets(n + 1, n + 1, &triplets).unwrap()
}

#[test]
fn rounding_on_the_diagonal_of_a_saddle_point_is_zero() {
    for n in [50, 700] {
        let exact: Vec<f64> = (0..=n).map(|i| (0.2 * i as f64).cos()).collect();
        for rest in [0.0, 1e-19, -1e-19] {
            for (sign, path) in [(1.0, SolverPath::SignedCholesky), (-1.0, SolverPath::Lu)] {
                let matrix = held_chain(n, sign, rest);
                assert!(!LuSolver::may_be_unpivoted(&matrix));
                let mut solver = TangentSolver::default();
                solver.set_matrix(matrix.clone()).unwrap();
                let found = solver.solve(&matrix.multiply(&exact).unwrap(), 0.0).unwrap();
                assert!(error(&found.solution, &exact) < 1e-9, "{n} {rest} {sign}");
                assert_eq!(solver.report().path, Some(path), "{n} {rest} {sign}");
                assert_eq!(solver.report().factorisations, usize::from(sign > 0.0));
            }
        }
        assert_eq!(LuSolver::may_be_unpivoted(&held_chain(n, -1.0, 1e-3)), n > 500);
    }
}
