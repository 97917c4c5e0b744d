//! LU with pivoting and without it, by known solutions.

use super::*;

/// Convection and diffusion on an m × m grid, with two unknowns per node that rotate into each other.
fn rotating(m: usize) -> CsrMatrix {
    let mut triplets = vec![];
    for node in 0..m * m {
        let (x, y) = (node % m, node / m);
        let mut couple = |other: usize, value: f64| {
            triplets.extend([(2 * node, 2 * other, value), (2 * node + 1, 2 * other + 1, value)]);
        };
        couple(node, 4.0);
        for (step, inside, value) in [(1, x + 1 < m, -0.4), (m, y + 1 < m, -0.8)] {
            if inside {
                couple(node + step, value);
            }
        }
        for (step, inside, value) in [(1, x > 0, -1.6), (m, y > 0, -1.2)] {
            if inside {
                couple(node - step, value);
            }
        }
        triplets.extend([(2 * node, 2 * node + 1, 0.5), (2 * node + 1, 2 * node, -0.5)]);
    }
    CsrMatrix::from_triplets(2 * m * m, 2 * m * m, &triplets).unwrap()
}

fn solution(size: usize) -> Vec<f64> {
    (0..size).map(|k| (k as f64 * 0.61).cos() + 0.3).collect()
}

fn error(found: &[f64], exact: &[f64]) -> f64 {
    found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Solves with a matrix and its transposed for a known solution.
fn solved(solver: &mut LuSolver, matrix: &CsrMatrix) -> [Vec<f64>; 2] {
    let exact = solution(matrix.rows());
    solver.set_matrix(matrix.clone()).unwrap();
    let found = [
        solver.solve(&matrix.multiply(&exact).unwrap(), 0.0).unwrap().solution,
        solver.solve_transposed(&matrix.multiply_transposed(&exact).unwrap(), 0.0).unwrap().solution,
    ];
    for x in &found {
        assert!(error(x, &exact) < 1e-12, "{}", error(x, &exact));
    }
    found
}

#[test]
fn a_large_matrix_is_factored_without_pivoting_on_any_number_of_threads() {
    let matrix = rotating(40);
    let mut one = LuSolver::on(Threads::ONE);
    let expected = solved(&mut one, &matrix);
    assert!(one.is_unpivoted());
    for threads in [2, 3, 7, 16] {
        assert_eq!(solved(&mut LuSolver::on(Threads::new(threads)), &matrix), expected);
    }
    // The next matrix, with the same analysis and memory.
    let mut next = matrix.clone();
    next.add_scaled(0.5, &matrix).unwrap();
    solved(&mut one, &next);
    assert!(one.is_unpivoted() && one.factorisations() == 2);
}

#[test]
fn entries_on_one_side_of_the_diagonal_are_completed() {
    let whole = rotating(20);
    let triplets: Vec<_> = (0..800)
        .flat_map(|row| {
            let (columns, values) = whole.row(row);
            let entries =
                columns.iter().zip(values).map(move |(column, value)| (row, *column as usize, *value));
            entries.filter(|(row, column, _)| column <= row || (row + column) % 3 > 0).collect::<Vec<_>>()
        })
        .collect();
    let matrix = CsrMatrix::from_triplets(800, 800, &triplets).unwrap();
    assert!(matrix.values().len() < whole.values().len());
    let mut solver = LuSolver::default();
    for factor in [1.0, 3.0] {
        let mut scaled = matrix.clone();
        scaled.values_mut().iter_mut().for_each(|value| *value *= factor);
        solved(&mut solver, &scaled);
        assert!(solver.is_unpivoted());
    }
}

#[test]
fn pivots_are_exchanged_where_a_factor_needs_them() {
    // A tiny pivot in each pair of unknowns, whichever order they come in; zeros; few unknowns.
    let pairs = |tiny: f64, count: usize| {
        let mut triplets = vec![];
        for k in 0..count {
            let (a, b) = (2 * k, 2 * k + 1);
            triplets.extend([(a, a, tiny), (a, b, 1.0), (b, a, -2.0), (b, b, tiny)]);
            if k > 0 {
                triplets.extend([(a, a - 2, 0.25), (a - 2, a, 0.5)]);
            }
        }
        CsrMatrix::from_triplets(2 * count, 2 * count, &triplets).unwrap()
    };
    let mut solver = LuSolver::default();
    for matrix in [pairs(1e-18, 400), pairs(0.0, 400), pairs(2.0, 20)] {
        solved(&mut solver, &matrix);
        assert!(!solver.is_unpivoted());
    }
    solved(&mut solver, &pairs(2.0, 400));
    assert!(solver.is_unpivoted());
}

#[test]
fn a_singular_matrix_is_an_error_of_pivoting() {
    let mut triplets = vec![];
    for i in 0..600 {
        let j = (i + 1) % 600;
        triplets.extend([(i, i, 0.1), (j, j, 0.1), (i, j, -0.1), (j, i, -0.1)]);
    }
    let matrix = CsrMatrix::from_triplets(600, 600, &triplets).unwrap();
    let mut solver = LuSolver::default();
    let found = solver.set_matrix(matrix);
    assert!(
        matches!(found, Err(SolverError::LinearAlgebra(LinearAlgebraError::Singular { .. }))),
        "{found:?}"
    );
    assert_eq!(solver.solve(&[1.0; 600], 0.0).unwrap_err(), SolverError::NoMatrix);
}
