//! Block matrices against the same matrices entry by entry.

use super::*;
use crate::CsrMatrix;

/// Two row sets (2 nodes of 2 components, 3 of 1) and two column sets (3 nodes of 1, 2 of 2); one pair is empty.
fn sample() -> BlockMatrix {
    let rows = NodeSet::in_a_row([(2, 2), (3, 1)]);
    let columns = NodeSet::in_a_row([(3, 1), (2, 2)]);
    let pairs = vec![
        vec![BlockRows::new(vec![0, 2, 3], vec![0, 2, 1]), BlockRows::new(vec![0, 1, 3], vec![1, 0, 1])],
        vec![BlockRows::default(), BlockRows::new(vec![0, 0, 1, 3], vec![0, 0, 1])],
    ];
    let sparsity = Arc::new(BlockSparsity::new(rows, columns, pairs).unwrap());
    let mut matrix = BlockMatrix::zero(&sparsity);
    for (place, value) in matrix.values_mut().iter_mut().enumerate() {
        *value = (place as f64 + 1.0).sqrt();
    }
    matrix
}

#[test]
fn blocks_and_entries_are_the_same_matrix() {
    let matrix = sample();
    assert_eq!((matrix.rows(), matrix.columns()), (7, 7));
    assert_eq!(matrix.values().len(), 3 * 2 + 3 * 4 + 3 * 2);
    let scalar = matrix.to_csr();
    assert_eq!(scalar.values().len(), matrix.values().len());
    for row in 0..7 {
        for column in 0..7 {
            assert_eq!(matrix.get(row, column), scalar.get(row, column), "({row}, {column})");
        }
        let (columns, values) = scalar.row(row);
        let entries: Vec<_> = matrix.row(row).collect();
        let expected: Vec<_> = columns.iter().map(|c| *c as usize).zip(values.iter().copied()).collect();
        assert_eq!(entries, expected);
    }
    // The second component of node 0 of the first set; blocks are row-major.
    assert_eq!(matrix.get(1, 2), 4.0_f64.sqrt());
    assert_eq!(matrix.get(9, 9), 0.0);
    assert_eq!(matrix.diagonal(), scalar.diagonal());
    let x: Vec<f64> = (0..7).map(|k| f64::from(k).cos()).collect();
    assert_eq!(matrix.multiply(&x).unwrap(), scalar.multiply(&x).unwrap());
    let (ours, theirs) = (matrix.multiply_transposed(&x).unwrap(), scalar.multiply_transposed(&x).unwrap());
    assert!(ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() < 1e-14));
    assert_eq!(matrix.asymmetry().unwrap(), scalar.asymmetry().unwrap());
    assert!(matrix.multiply(&x[1..]).is_err() && matrix.multiply_transposed(&x[1..]).is_err());
    assert_eq!(matrix.into_csr(), scalar);
}

#[test]
fn a_matrix_of_single_entries_goes_to_and_fro() {
    let scalar = CsrMatrix::from_triplets(3, 2, &[(0, 1, 2.0), (2, 0, -1.0), (2, 1, 4.0)]).unwrap();
    let blocks = BlockMatrix::from(scalar.clone());
    assert_eq!(blocks.to_csr(), scalar);
    assert_eq!(blocks.into_csr(), scalar);
}

/// A product is the same for each number of threads, also where rows are cut unevenly.
#[test]
fn products_do_not_depend_on_threads() {
    for size in [1, 2, 3] {
        let nodes = 20_011;
        let row = |node: usize| [node, (node * 7 + 3) % nodes, (node * 11 + 5) % nodes];
        let mut columns = Vec::new();
        let mut pointers = vec![0];
        for node in 0..nodes {
            let mut row = row(node).map(|node| node as u32).to_vec();
            row.sort_unstable();
            row.dedup();
            columns.extend(row);
            pointers.push(columns.len());
        }
        let sets = NodeSet::in_a_row([(nodes, size)]);
        let pairs = vec![vec![BlockRows::new(pointers, columns)]];
        let sparsity = Arc::new(BlockSparsity::new(sets.clone(), sets, pairs).unwrap());
        let mut matrix = BlockMatrix::zero(&sparsity);
        for (place, value) in matrix.values_mut().iter_mut().enumerate() {
            *value = (place as f64).sin();
        }
        let x: Vec<f64> = (0..matrix.columns()).map(|k| (k as f64 * 0.3).cos()).collect();
        let alone = matrix.multiply(&x).unwrap();
        for threads in [2, 3, 7, 16] {
            let mut product = vec![f64::NAN; alone.len()];
            matrix.multiply_on(Threads::new(threads), &x, &mut product).unwrap();
            assert!(product == alone);
        }
        // The second component of the first row, by hand.
        let by_hand: f64 = matrix.row(size - 1).map(|(column, value)| value * x[column]).sum();
        assert!((alone[size - 1] - by_hand).abs() < 1e-14);
    }
}

#[test]
fn positions_that_do_not_fit_are_refused() {
    let sets = || NodeSet::in_a_row([(2, 1)]);
    let refused = |pointers: Vec<usize>, columns: Vec<u32>| {
        BlockSparsity::new(sets(), sets(), vec![vec![BlockRows::new(pointers, columns)]]).err()
    };
    use LinearAlgebraError::{IndexOutOfRange, NotAscending, SizeMismatch};
    assert!(matches!(refused(vec![0, 1], vec![0]), Some(SizeMismatch { .. })));
    assert!(matches!(refused(vec![], vec![0]), Some(SizeMismatch { .. })));
    assert!(matches!(refused(vec![0, 2, 2], vec![1, 1]), Some(NotAscending { position: 1, .. })));
    assert!(matches!(refused(vec![0, 2, 1], vec![0]), Some(NotAscending { .. })));
    assert!(matches!(refused(vec![0, 0, 1], vec![2]), Some(IndexOutOfRange { index: 2, size: 2, .. })));
    assert_eq!(refused(vec![0, 1, 2], vec![1, 0]), None);
}

/// Two sets, of two and of one component: places and values of a symmetric matrix, and of three that differ in one of them.
#[test]
fn a_matrix_is_compared_with_its_transposed() {
    let sets = NodeSet::in_a_row([(3, 2), (2, 1)]);
    let rows = |rows: &[&[u32]]| {
        let ends = rows.iter().scan(0, |end, row| {
            *end += row.len();
            Some(*end)
        });
        BlockRows::new([0].into_iter().chain(ends).collect(), rows.concat())
    };
    let matrix = |first: &[&[u32]], lower: &[&[u32]]| {
        let pairs =
            vec![vec![rows(first), rows(&[&[0], &[], &[0, 1]])], vec![rows(lower), BlockRows::default()]];
        let sparsity = Arc::new(BlockSparsity::new(sets.clone(), sets.clone(), pairs).unwrap());
        let mut matrix = BlockMatrix::zero(&sparsity);
        for row in 0..8 {
            for column in 0..8 {
                if let Some(place) = sparsity.find(row, column) {
                    matrix.values_mut()[place] = (row + column) as f64 + (row * column) as f64 / 7.0;
                }
            }
        }
        matrix
    };
    let (coupled, lower): ([&[u32]; 3], [&[u32]; 2]) = ([&[0, 2], &[1], &[0, 2]], [&[0, 2], &[2]]);
    let symmetric = matrix(&coupled, &lower);
    assert!(symmetric.equals_transposed() && symmetric.asymmetry().unwrap() == 0.0);
    for place in 0..symmetric.values().len() {
        let mut other = symmetric.clone();
        other.values_mut()[place] += 1e-15 + 1e-14 * other.values()[place].abs();
        assert_eq!(other.equals_transposed(), other.asymmetry().unwrap() == 0.0, "place {place}");
    }
    // (0, 2) without (2, 0), in the first set; the other way round; another place in the second one.
    for (first, lower) in [
        ([&[0, 2][..], &[1], &[2]], lower),
        ([&[0], &[1], &[0, 2]], lower),
        (coupled, [&[0, 1], &[2]]),
        (coupled, [&[0, 2], &[]]),
    ] {
        assert!(!matrix(&first, &lower).equals_transposed(), "{first:?} {lower:?}");
    }
}
