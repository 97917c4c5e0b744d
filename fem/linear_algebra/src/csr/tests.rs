//! Sparse matrices against dense arithmetic.

use super::*;
use crate::BlockMatrix;

fn example() -> CsrMatrix {
    // [1 2 0; 0 3 4], the 3 as a sum of duplicates given out of order.
    CsrMatrix::from_triplets(2, 3, &[(1, 2, 4.0), (1, 1, 1.0), (0, 1, 2.0), (0, 0, 1.0), (1, 1, 2.0)])
        .unwrap()
}

#[test]
fn triplets_are_sorted_and_summed() {
    let matrix = example();
    assert_eq!(matrix.row_pointers(), [0, 2, 4]);
    assert_eq!(matrix.column_indices(), [0, 1, 1, 2]);
    assert_eq!(matrix.values(), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(matrix.get(1, 0), 0.0);
    assert_eq!(matrix.diagonal(), [1.0, 3.0]);
    let empty_row = CsrMatrix::from_triplets(3, 3, &[(0, 2, 1.0), (2, 2, 5.0)]).unwrap();
    assert_eq!(empty_row.row_pointers(), [0, 1, 1, 2]);
    assert_eq!(empty_row.get(2, 2), 5.0);
}

#[test]
fn products_with_the_matrix_and_its_transpose() {
    let matrix = example();
    assert_eq!(matrix.multiply(&[1.0, 10.0, 100.0]).unwrap(), [21.0, 430.0]);
    assert_eq!(matrix.multiply_transposed(&[1.0, 10.0]).unwrap(), [1.0, 32.0, 40.0]);
    assert_eq!(matrix.transpose().multiply(&[1.0, 10.0]).unwrap(), [1.0, 32.0, 40.0]);
    assert_eq!(matrix.transpose().transpose(), matrix);
    assert_eq!((matrix.row_sum_norm(), matrix.column_sum_norm()), (7.0, 5.0));
}

#[test]
fn wrong_sizes_and_indices_are_errors() {
    let matrix = example();
    assert!(matches!(
        matrix.multiply(&[1.0; 2]),
        Err(LinearAlgebraError::SizeMismatch { expected: 3, found: 2, .. })
    ));
    assert!(matrix.multiply_transposed(&[1.0; 3]).is_err());
    assert!(matrix.asymmetry().is_err() && matrix.symmetric_part().is_err());
    let error = CsrMatrix::from_triplets(2, 2, &[(0, 2, 1.0)]).unwrap_err();
    assert_eq!(error, LinearAlgebraError::IndexOutOfRange { what: "column", index: 2, size: 2 });
    assert!(CsrMatrix::from_triplets(2, 2, &[(2, 0, 1.0)]).is_err());
}

#[test]
fn symmetric_part_and_asymmetry() {
    let matrix =
        CsrMatrix::from_triplets(2, 2, &[(0, 0, 8.0), (0, 1, 3.0), (1, 0, 1.0), (1, 1, 5.0)]).unwrap();
    assert!((matrix.asymmetry().unwrap() - 2.0 / 40.0_f64.sqrt()).abs() < 1e-15);
    let part = matrix.symmetric_part().unwrap();
    assert!(Arc::ptr_eq(part.pattern(), matrix.pattern()));
    assert_eq!(part.values(), [8.0, 2.0, 2.0, 5.0]);
    assert!(part.is_symmetric(0.0).unwrap());
    // An unsymmetric pattern.
    let upper = CsrMatrix::from_triplets(2, 2, &[(0, 0, 8.0), (0, 1, 3.0), (1, 1, 5.0)]).unwrap();
    assert!((upper.asymmetry().unwrap() - 3.0 / 40.0_f64.sqrt()).abs() < 1e-15);
    let part = upper.symmetric_part().unwrap();
    assert_eq!(part.values(), [8.0, 1.5, 1.5, 5.0]);
    let lower = upper.transpose();
    assert_eq!(lower.asymmetry().unwrap(), upper.asymmetry().unwrap());
    // A soft part next to a stiff one, and multipliers: each pair in its own unit.
    let entries =
        [(0, 0, 1e12), (1, 1, 2.0), (1, 2, 1.0), (2, 1, -1.0), (2, 2, 2.0), (0, 3, 1e6), (3, 0, 1e6)];
    let soft = CsrMatrix::from_triplets(4, 4, &entries).unwrap();
    assert!((soft.asymmetry().unwrap() - 1.0).abs() < 1e-15);
    assert_eq!(BlockMatrix::from(soft.clone()).asymmetry().unwrap(), soft.asymmetry().unwrap());
    for place in 0..soft.values().len() {
        let mut bad = soft.clone();
        bad.values_mut()[place] = f64::NAN;
        assert!(bad.asymmetry().unwrap().is_nan(), "{place}");
    }
    assert_eq!(lower.symmetric_part().unwrap().values(), part.values());
}

#[test]
fn asymmetry_does_not_depend_on_threads() {
    // Rows of 3 to 40 entries, so that threads get different numbers of rows.
    let size = 3000_usize;
    let mut triplets = Vec::new();
    for row in 0..size {
        triplets.push((row, row, 2.0 + (row % 7) as f64));
        for step in 1..=(2 + row % 20) {
            let value = ((row * step) as f64).sin();
            if row + 3 * step < size {
                triplets.extend([(row, row + 3 * step, value), (row + 3 * step, row, value)]);
            }
        }
    }
    let symmetric = CsrMatrix::from_triplets(size, size, &triplets).unwrap();
    let with = |row: usize, column: usize, value: f64| {
        let mut changed = triplets.clone();
        changed.push((row, column, value));
        CsrMatrix::from_triplets(size, size, &changed).unwrap()
    };
    // A value and a place without a partner, on either side of the diagonal, and no number.
    let cases = [
        with(2000, 2003, 0.1),
        with(2003, 2000, 0.1),
        with(1500, 1501, 0.3),
        with(1501, 1500, 0.3),
        with(7, 10, f64::NAN),
    ];
    for threads in [1, 2, 3, 7, 16].map(Threads::new) {
        assert_eq!(symmetric.asymmetry_on(threads).unwrap(), 0.0);
        assert!(symmetric.is_symmetric_on(threads, 0.0).unwrap());
        for case in &cases[..4] {
            let (found, expected) = (case.asymmetry_on(threads).unwrap(), case.asymmetry().unwrap());
            assert!(found > 0.0 && found == expected, "{found} {expected}");
        }
        assert!(cases[4].asymmetry_on(threads).unwrap().is_nan());
        assert!(matches!(
            cases[4].check_finite_on(threads),
            Err(LinearAlgebraError::EntryNotFinite { row: 7, column: 10, .. })
        ));
        symmetric.check_finite_on(threads).unwrap();
    }
    let turned = |row, column| with(row, column, 0.3).asymmetry_on(Threads::new(3)).unwrap();
    assert_eq!(turned(1500, 1501), turned(1501, 1500));
}

#[test]
fn adding_asks_for_the_same_pattern() {
    let mut matrix = example();
    let copy = matrix.clone();
    matrix.add_scaled(-0.5, &copy).unwrap();
    assert_eq!(matrix.values(), [0.5, 1.0, 1.5, 2.0]);
    let other = CsrMatrix::from_triplets(2, 3, &[(0, 0, 1.0)]).unwrap();
    assert!(matches!(matrix.add_scaled(1.0, &other), Err(LinearAlgebraError::PatternMismatch { .. })));
}

#[test]
fn a_nan_is_named_with_its_place() {
    let mut matrix = example();
    assert!(matrix.check_finite().is_ok());
    matrix.values_mut()[2] = f64::NAN;
    assert!(matches!(
        matrix.check_finite(),
        Err(LinearAlgebraError::EntryNotFinite { row: 1, column: 1, .. })
    ));
}

#[test]
fn products_do_not_depend_on_threads() {
    let size = 20_011;
    let entries = |row: usize| [(row, row, 2.0), (row, row * 7 % size, 0.3 * row as f64)];
    let matrix =
        CsrMatrix::from_triplets(size, size, &(0..size).flat_map(entries).collect::<Vec<_>>()).unwrap();
    let x: Vec<f64> = (0..size).map(|k| (k as f64).sin()).collect();
    let alone = matrix.multiply(&x).unwrap();
    for threads in [2, 3, 7, 16] {
        let mut product = vec![f64::NAN; size];
        matrix.multiply_on(Threads::new(threads), &x, &mut product).unwrap();
        assert!(product == alone);
    }
}

#[test]
fn rounding_on_a_diagonal_is_zero_in_any_unit() {
    // A spring with a multiplier, which has what rounding leaves on its diagonal, and with a soft part.
    let matrix = |rest: f64, unit: f64| {
        let multiplier = [(0, 1, 3.0 * unit), (1, 0, -3.0 * unit), (1, 1, rest * unit * unit)];
        let soft = [(0, 2, 1e-11), (2, 0, 1e-11), (2, 2, 1e-20)];
        CsrMatrix::from_triplets(3, 3, &[&[(0, 0, 2.0)], &multiplier[..], &soft].concat()).unwrap()
    };
    for unit in [1.0, 1e6, 1e-6] {
        for rest in [0.0, 1e-16, -1e-16, 4e-15] {
            assert_eq!(matrix(rest, unit).diagonal_above_rounding(), [2.0, 0.0, 1e-20], "{rest} {unit}");
        }
        for rest in [6e-15, -1e-13, 1.0] {
            let matrix = matrix(rest, unit);
            assert_eq!(matrix.diagonal_above_rounding(), matrix.diagonal(), "{rest} {unit}");
        }
    }
    // An entry without a partner adds nothing to the diagonal.
    let one_sided = CsrMatrix::from_triplets(2, 2, &[(0, 0, 1e-30), (0, 1, 1.0), (1, 1, 1.0)]).unwrap();
    assert_eq!(one_sided.diagonal_above_rounding(), [1e-30, 1.0]);
    let wide = CsrMatrix::from_triplets(1, 2, &[(0, 0, 1e-30), (0, 1, 1.0)]).unwrap();
    assert_eq!(wide.diagonal_above_rounding(), [1e-30]);
}
