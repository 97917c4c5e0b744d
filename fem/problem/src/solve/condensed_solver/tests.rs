//! Condensed solutions by their residuals.

use super::*;
use crate::linear_algebra::backward_error::Residual;
use crate::linear_algebra::vector::norm;
use crate::solve::solver_report::SolverPath;
use crate::threads::Threads;

const SIDE: usize = 12;

/// A five-point Laplacian on SIDE × SIDE nodes plus given entries on its pattern.
fn laplacian(changes: &[(usize, usize, f64)], shift: f64) -> CsrMatrix {
    let mut triplets = Vec::new();
    for i in 0..SIDE {
        for j in 0..SIDE {
            let row = i * SIDE + j;
            triplets.push((row, row, 4.0 + shift));
            let neighbours = [(i > 0, row.wrapping_sub(SIDE)), (i + 1 < SIDE, row + SIDE)];
            let beside = [(j > 0, row.wrapping_sub(1)), (j + 1 < SIDE, row + 1)];
            for (exists, column) in neighbours.into_iter().chain(beside) {
                if exists {
                    triplets.push((row, column, -1.0));
                }
            }
        }
    }
    triplets.extend_from_slice(changes);
    CsrMatrix::from_triplets(SIDE * SIDE, SIDE * SIDE, &triplets).unwrap()
}

fn load() -> Vec<f64> {
    (0..SIDE * SIDE).map(|k| (k as f64 * 0.7).sin()).collect()
}

fn rest(sum: &Sum, x: &[f64], b: &[f64], transpose: Transpose) -> Vec<f64> {
    Residual::of(&sum.side(transpose), Threads::new(3), x, b).unwrap().rest
}

fn check(solver: &mut CondensedSolver, matrix: &CsrMatrix) {
    let b = load();
    solver.set_matrix(matrix.clone()).unwrap();
    for transpose in [Transpose::No, Transpose::Yes] {
        let found = solver.solve_with(&b, 0.0, transpose).unwrap();
        let matrix = Sum::of(matrix.clone());
        let rest = rest(&matrix, &found.solution, &b, transpose);
        assert!(norm(&rest) <= 1e-13 * norm(&b), "residual {:e}", norm(&rest));
    }
}

#[test]
fn unsymmetric_changes_on_few_unknowns_need_one_factor_as_long_as_they_stay() {
    let mut solver = CondensedSolver::default();
    solver.set_linear_part(&Arc::new(laplacian(&[], 0.0))).unwrap();
    check(&mut solver, &laplacian(&[(3, 4, 20.0), (4, 3, -7.0), (4, 4, 50.0), (5, 4, 1.0)], 0.0));
    assert_eq!((solver.report().factorisations, solver.report().condensed_unknowns), (1, Some(3)));
    assert_eq!(solver.report().path, Some(SolverPath::Condensed));
    // A subset: the same factor. Another place: a new one that holds both.
    check(&mut solver, &laplacian(&[(4, 4, 30.0), (3, 4, 2.0)], 0.0));
    assert_eq!(solver.report().factorisations, 1);
    check(&mut solver, &laplacian(&[(100, 101, 9.0)], 0.0));
    assert_eq!((solver.report().factorisations, solver.report().condensed_unknowns), (2, Some(5)));
    check(&mut solver, &laplacian(&[], 0.0));
    assert_eq!(solver.report().factorisations, 2);
    assert!(solver.report().iterations.iter().all(|iterations| *iterations == 0));
}

#[test]
fn it_falls_back_where_condensing_does_not_serve() {
    // No linear part: the fallback factors the matrix itself.
    let mut solver = CondensedSolver::default();
    check(&mut solver, &laplacian(&[(3, 4, 2.0)], 0.0));
    assert_eq!((solver.report().condensed_unknowns, solver.report().path), (None, Some(SolverPath::Gmres)));
    // A linear part that is not positive definite.
    solver.set_linear_part(&Arc::new(laplacian(&[], -3.3))).unwrap();
    check(&mut solver, &laplacian(&[(4, 4, 2.0)], -3.3));
    assert_eq!(solver.report().condensed_unknowns, None);
    // Changes everywhere: the dense block would cost more than the sparse factor.
    let everywhere: Vec<_> = (0..SIDE * SIDE).map(|k| (k, k, 1.0 + k as f64)).collect();
    solver.set_linear_part(&Arc::new(laplacian(&[], 0.0))).unwrap();
    check(&mut solver, &laplacian(&everywhere, 0.0));
    assert_eq!(solver.report().condensed_unknowns, None);
    assert!(solver.solve(&load()[1..], 0.0).is_err());
}

/// A matrix given by its changed entries is solved as the whole one is.
#[test]
fn changed_entries_make_the_same_matrix() {
    let linear_part = Arc::new(laplacian(&[], 0.0));
    let changes = [(3, 4, 20.0), (4, 3, -7.0), (4, 4, 50.0), (5, 4, 1.0)];
    let whole = laplacian(&changes, 0.0);
    let entries: Vec<Entry> = changes
        .iter()
        .map(|&(row, column, _)| Entry {
            row: row as u32,
            column: column as u32,
            value: whole.get(row, column),
        })
        .collect();
    let b = load();
    // Condensed, and where condensing is refused.
    let mut condensed = CondensedSolver::default();
    condensed.set_linear_part(&linear_part).unwrap();
    let mut refused = CondensedSolver::default();
    let indefinite = Arc::new(laplacian(&[], -3.3));
    refused.set_linear_part(&indefinite).unwrap();
    let shifted = laplacian(&changes, -3.3);
    let shifted_entries: Vec<Entry> = entries
        .iter()
        .map(|entry| Entry { value: shifted.get(entry.row as usize, entry.column as usize), ..*entry })
        .collect();
    let solvers: [(&mut CondensedSolver, _, _, _); 2] = [
        (&mut condensed, &linear_part, &entries, &whole),
        (&mut refused, &indefinite, &shifted_entries, &shifted),
    ];
    for (solver, linear_part, entries, whole) in solvers {
        solver.set_changed(linear_part, entries).unwrap();
        for transpose in [Transpose::No, Transpose::Yes] {
            let found = solver.solve_with(&b, 0.0, transpose).unwrap();
            let whole = Sum::of(whole.clone());
            let rest = rest(&whole, &found.solution, &b, transpose);
            assert!(norm(&rest) <= 1e-12 * norm(&b), "residual {:e}", norm(&rest));
        }
        let missing = [Entry { row: 0, column: 100, value: 1.0 }];
        assert!(solver.set_changed(linear_part, &missing).is_err());
        let bad = [Entry { row: 0, column: 0, value: f64::NAN }];
        assert!(solver.set_changed(linear_part, &bad).is_err());
    }
    assert_eq!((condensed.report().factorisations, condensed.report().condensed_unknowns), (1, Some(3)));
}

/// The part of a larger matrix that an elimination leaves is solved as it would be if it were given by itself: as additions to the
/// linear part where it differs in few entries, else stored.
#[test]
fn a_part_of_a_larger_matrix_is_compared_with_the_linear_part() {
    let prescribed = std::collections::BTreeMap::from([(0, 1.0), (70, -1.0)]);
    let mut elimination = Elimination::new(SIDE * SIDE, &prescribed).unwrap();
    let linear_part = Arc::new(elimination.reduce_matrix(&laplacian(&[], 0.0).into()).unwrap());
    let mut solver = CondensedSolver::default();
    solver.set_linear_part(&linear_part).unwrap();
    let b = load()[2..].to_vec();
    let few = [(3, 4, 20.0), (4, 3, -7.0), (4, 4, 50.0), (5, 4, 1.0)];
    let rounding: Vec<_> = (0..SIDE * SIDE).map(|k| (k, k, 4e-15)).collect();
    for changes in [&few[..], &few[..], &[(4, 4, 1.0)], &rounding] {
        let mut whole = BlockMatrix::from(laplacian(changes, 0.0));
        solver.set_reduced(&whole, &mut elimination).unwrap();
        let adds = matches!(&solver.current, Some(Current::Condensed(Condensed { matrix, .. })) if Arc::ptr_eq(&matrix.base, &linear_part));
        assert_eq!(adds, changes.len() < 5);
        let reduced = elimination.reduce_matrix(&whole).unwrap();
        for transpose in [Transpose::No, Transpose::Yes] {
            let found = solver.solve_with(&b, 0.0, transpose).unwrap();
            let rest = rest(&Sum::of(reduced.clone()), &found.solution, &b, transpose);
            assert!(norm(&rest) <= 1e-13 * norm(&b), "residual {:e}", norm(&rest));
        }
        let place = whole.sparsity().find(5, 5).unwrap();
        whole.values_mut()[place] = f64::INFINITY;
        let error = solver.set_reduced(&whole, &mut elimination).unwrap_err();
        assert!(
            matches!(
                error,
                SolverError::LinearAlgebra(LinearAlgebraError::EntryNotFinite { row: 4, column: 4, .. })
            ),
            "{error}"
        );
    }
    assert_eq!((solver.report().factorisations, solver.report().condensed_unknowns), (1, Some(3)));
}

/// Systems that are kept have the bits that each has by itself, whatever else is kept, also where the factor is made again in between, or a system goes to
/// the fallback.
#[test]
fn systems_that_are_kept_are_solved_together() {
    let mut elimination = Elimination::new(SIDE * SIDE, &std::collections::BTreeMap::new()).unwrap();
    let linear_part = Arc::new(elimination.reduce_matrix(&laplacian(&[], 0.0).into()).unwrap());
    let begun = || {
        let mut solver = CondensedSolver::default();
        solver.set_linear_part(&linear_part).unwrap();
        assert!(!solver.keep(&load().into()).unwrap(), "no matrix yet");
        solver
    };
    let (mut together, mut alone) = (begun(), begun());
    let loads: Vec<Vec<f64>> =
        (1..6).map(|k| load().iter().map(|b| (k as f64 * b).cos()).collect()).collect();
    let matrices = [
        laplacian(&[(3, 4, 20.0), (4, 3, -7.0), (4, 4, 50.0)], 0.0),
        laplacian(&[(4, 4, 30.0), (3, 4, 2.0)], 0.0),
        laplacian(&[(4, 4, 30.0), (3, 4, 2.0)], 0.0),
        // Other unknowns: another factor.
        laplacian(&[(100, 101, 9.0)], 0.0),
        laplacian(&[], 0.0),
    ];
    let mut expected = vec![];
    for (matrix, b) in matrices.iter().zip(&loads) {
        together.set_reduced(&matrix.clone().into(), &mut elimination).unwrap();
        assert!(together.keep(&b[..].into()).unwrap());
        assert!(together.keep(&b[1..].into()).is_err());
        alone.set_reduced(&matrix.clone().into(), &mut elimination).unwrap();
        expected.push(alone.solve(b, 0.0).unwrap());
    }
    let found = together.take_kept();
    assert!(together.take_kept().is_empty());
    assert_eq!(found.len(), matrices.len());
    for ((found, expected), (matrix, b)) in found.into_iter().zip(&expected).zip(matrices.iter().zip(&loads))
    {
        let found = found.unwrap();
        assert_eq!(found.found, *expected);
        let own = rest(&Sum::of(matrix.clone()), &found.found.solution, b, Transpose::No);
        let difference: Vec<f64> = own.iter().zip(&found.rest).map(|(a, b)| a - b).collect();
        assert!(norm(&difference) <= 1e-14 * norm(b));
    }
    let [together_report, alone_report] = [&together, &alone].map(|solver| solver.report());
    assert_eq!((together_report.factorisations, together_report.solves), (2, 5));
    assert_eq!((alone_report.factorisations, alone_report.solves), (2, 5));
    // What is forgotten is not solved, and a matrix that is stored as a whole is not kept.
    together.set_reduced(&matrices[0].clone().into(), &mut elimination).unwrap();
    assert!(together.keep(&loads[0][..].into()).unwrap());
    together.forget_kept();
    assert!(together.take_kept().is_empty());
    together.set_matrix(matrices[0].clone()).unwrap();
    assert!(!together.keep(&loads[0][..].into()).unwrap());
}
