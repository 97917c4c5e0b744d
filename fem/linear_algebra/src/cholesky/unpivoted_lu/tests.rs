//! LU without exchanges of rows, by known solutions and against what partial pivoting judges.

use super::*;
use crate::cholesky::tests::{error, grid, of_all_shapes};
use crate::{LuFactor, Ordering, SharedWork};

/// A matrix with a skew part of half of its entries off the diagonal.
fn skewed(mut matrix: CsrMatrix) -> CsrMatrix {
    let pattern = matrix.pattern().clone();
    for row in 0..matrix.rows() {
        let (range, columns) = (pattern.row_range(row), pattern.row(row));
        for (value, column) in matrix.values_mut()[range].iter_mut().zip(columns) {
            let column = *column as usize;
            if column != row {
                *value += 0.5 * value.abs() * if column > row { 1.0 } else { -1.0 };
            }
        }
    }
    matrix
}

fn solution(size: usize) -> Vec<f64> {
    (0..size).map(|k| (k as f64 * 0.37).sin() - 0.2).collect()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn a_system_and_its_transposed_are_solved_on_supernodes_of_all_shapes() {
    for (matrix, ordering) in of_all_shapes() {
        let matrix = skewed(matrix);
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
        let exact = solution(matrix.rows());
        let sides = [
            (Transpose::No, matrix.multiply(&exact).unwrap()),
            (Transpose::Yes, matrix.multiply_transposed(&exact).unwrap()),
        ];
        // Storage that is reused need not be zero.
        let storage = vec![f64::NAN; 2 * analysis.factor_entries()];
        let one = UnpivotedLu::new_on(Threads::ONE, &analysis, &matrix, storage).unwrap();
        for (transpose, b) in &sides {
            let mut x = b.clone();
            one.solve_in_place(&mut x, *transpose).unwrap();
            assert!(error(&x, &exact) < 1e-13, "{} unknowns: {}", x.len(), error(&x, &exact));
        }
        for threads in [2, 3, 7, 16].map(Threads::new) {
            let other = UnpivotedLu::new_on(threads, &analysis, &matrix, vec![]).unwrap();
            assert!(bits(&other.values) == bits(&one.values), "{} unknowns, {threads:?}", exact.len());
            for (transpose, b) in &sides {
                let [mut x, mut y] = [b.clone(), b.clone()];
                one.solve_in_place(&mut x, *transpose).unwrap();
                other.solve_in_place(&mut y, *transpose).unwrap();
                assert!(bits(&x) == bits(&y), "{} unknowns, {threads:?}", exact.len());
            }
        }
    }
}

#[test]
fn many_units_are_shared_with_the_same_bits() {
    let matrix = skewed(grid(160, [[3.0, 1.0], [1.0, 2.0]], 0.0));
    let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::NestedDissection).unwrap());
    assert!(analysis.elimination().units.iter().any(|unit| unit.panels > 1));
    let exact = solution(matrix.rows());
    let b = matrix.multiply(&exact).unwrap();
    let found = |threads: usize| {
        let factor = UnpivotedLu::new_on(Threads::new(threads), &analysis, &matrix, vec![]).unwrap();
        let mut x = b.clone();
        factor.solve_in_place(&mut x, Transpose::No).unwrap();
        assert!(error(&x, &exact) < 1e-13, "{threads} threads: {}", error(&x, &exact));
        (bits(&factor.into_storage()), bits(&x))
    };
    let one = found(1);
    for threads in [2, 3, 7, 16] {
        assert!(found(threads) == one, "{threads} threads");
    }
    let counted = analysis.factorisation_work();
    let speed_ups = SharedWork::THREADS.map(|threads| counted.speed_up(threads).unwrap());
    assert!(speed_ups[0] > 1.9 && speed_ups[3] > 5.0, "{speed_ups:?}");
}

/// Of a symmetric matrix U = D Lᵀ, so that the diagonal of U is that of the squares of a Cholesky factor.
#[test]
fn pivots_of_a_symmetric_matrix_are_those_of_cholesky() {
    for (matrix, ordering) in of_all_shapes() {
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
        let lu = UnpivotedLu::new_on(Threads::ONE, &analysis, &matrix, vec![]).unwrap();
        let cholesky = super::super::SymmetricFactor::cholesky(&analysis, &matrix, vec![]).unwrap();
        let b = solution(matrix.rows());
        let [mut x, mut y, mut z] = [b.clone(), b.clone(), b];
        lu.solve_in_place(&mut x, Transpose::No).unwrap();
        lu.solve_in_place(&mut y, Transpose::Yes).unwrap();
        cholesky.solve_in_place(&mut z).unwrap();
        assert!(error(&x, &z) < 1e-13 && error(&y, &z) < 1e-13, "{} unknowns", x.len());
    }
}

#[test]
fn pivots_that_are_too_small_are_noticed() {
    let of = |entries: &[(usize, usize, f64)], size: usize| {
        let matrix = CsrMatrix::from_triplets(size, size, entries).unwrap();
        let order = (0..size as u32).collect();
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::Given(order)).unwrap());
        (UnpivotedLu::new_on(Threads::ONE, &analysis, &matrix, vec![]), LuFactor::new(&matrix, None))
    };
    // A tiny pivot next to ones: regular, but not for this order.
    let (found, pivoted) = of(&[(0, 0, 1e-18), (0, 1, 1.0), (1, 0, -1.0), (1, 1, 1.0)], 2);
    assert!(matches!(found, Err(LinearAlgebraError::Inaccurate { .. })), "{found:?}");
    assert!(pivoted.is_ok());
    // A pivot that becomes zero.
    let singular = [(0, 0, 1.0), (0, 1, 2.0), (1, 0, 3.0), (1, 1, 6.0)];
    let (found, pivoted) = of(&singular, 2);
    assert!(matches!(found, Err(LinearAlgebraError::Singular { unknown: 1, .. })), "{found:?}");
    assert!(matches!(pivoted, Err(LinearAlgebraError::Singular { .. })));
    // A zero on the diagonal, which a rotation would need as a pivot.
    let (found, pivoted) = of(&[(0, 0, 0.0), (0, 1, 2.0), (1, 0, -2.0), (1, 1, 0.0)], 2);
    assert!(matches!(found, Err(LinearAlgebraError::Singular { .. })), "{found:?}");
    assert!(pivoted.is_ok());
    // A ring of springs that nothing holds: rounding hides the zero pivot.
    let mut ring = vec![];
    for i in 0..300 {
        let j = (i + 1) % 300;
        ring.extend([(i, i, 0.1), (j, j, 0.1), (i, j, -0.1), (j, i, -0.1)]);
    }
    let (found, pivoted) = of(&ring, 300);
    assert!(found.is_err() && pivoted.is_err(), "{found:?}");
    // A number that is none.
    let (found, _) = of(&[(0, 0, f64::NAN)], 1);
    assert!(matches!(found, Err(LinearAlgebraError::EntryNotFinite { .. })), "{found:?}");
}
