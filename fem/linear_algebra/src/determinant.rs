//! Sign of the determinant of a sparse matrix, by LU with partial pivoting.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::simplicial::{
    SimplicialLu, factorize_simplicial_numeric_lu, factorize_simplicial_numeric_lu_scratch,
};
use faer::sparse::linalg::lu::{LuSymbolicParams, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

use super::csr::CsrMatrix;
use super::error::{LinearAlgebraError, check_size};
use super::lu::scale;

const NO_MEMORY: LinearAlgebraError = LinearAlgebraError::OutOfMemory { what: "the factor" };

/// The sign of a number that is not zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Above zero.
    Positive,
    /// Below zero.
    Negative,
}

/// The sign of the determinant of a square matrix.
///
/// # Errors
/// [`LinearAlgebraError::Singular`] where a pivot is zero; if the matrix is not square, has an entry that is not finite, or memory is too
/// small.
pub fn determinant_sign(matrix: &CsrMatrix) -> Result<Sign, LinearAlgebraError> {
    let size = matrix.rows();
    check_size("the set of columns of a square matrix", size, matrix.columns())?;
    matrix.check_finite()?;
    if size == 0 {
        return Ok(Sign::Positive);
    }
    // Factors of the scaling are positive.
    let (rows, columns) = scale(matrix)?;
    let indices: Vec<usize> = matrix.column_indices().iter().map(|column| *column as usize).collect();
    let mut values = matrix.values().to_vec();
    for (range, row) in matrix.row_pointers().windows(2).zip(&rows) {
        for position in range[0]..range[1] {
            values[position] *= row * columns[indices[position]];
        }
    }
    // Compressed rows of A are compressed columns of Aᵀ, which has the same determinant.
    let pattern = SymbolicSparseColMatRef::new_checked(size, size, matrix.row_pointers(), None, &indices);
    let parameters = LuSymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
        ..Default::default()
    };
    let symbolic = factorize_symbolic_lu(pattern, parameters).map_err(|_| NO_MEMORY)?;
    let (mut pivots, mut places) = (vec![0_usize; size], vec![0_usize; size]);
    let mut factor = SimplicialLu::<usize, f64>::new();
    let room = factorize_simplicial_numeric_lu_scratch::<usize, f64>(size, size);
    let mut room = MemBuffer::try_new(room).map_err(|_| NO_MEMORY)?;
    let transposed = SparseColMatRef::new(pattern, &values[..]);
    let order = symbolic.col_perm();
    let stack = MemStack::new(&mut room);
    factorize_simplicial_numeric_lu(&mut pivots, &mut places, &mut factor, transposed, order, stack)
        .map_err(|_| LinearAlgebraError::Singular { unknown: 0, ratio: 0.0 })?;
    let mut is_negative = is_odd(&pivots) != is_odd(order.arrays().0);
    let upper = factor.u_factor_unsorted();
    for column in 0..size {
        let entries = upper.row_idx_of_col(column).zip(upper.val_of_col(column));
        let pivot = entries.filter(|(row, _)| *row == column).map(|(_, value)| *value).sum::<f64>();
        if pivot == 0.0 || !pivot.is_finite() {
            return Err(LinearAlgebraError::Singular { unknown: order.arrays().0[column], ratio: 0.0 });
        }
        is_negative ^= pivot < 0.0;
    }
    Ok(if is_negative { Sign::Negative } else { Sign::Positive })
}

/// Whether a permutation is an odd one: it is even, less one transposition per further member of each cycle.
fn is_odd(permutation: &[usize]) -> bool {
    let mut seen = vec![false; permutation.len()];
    let mut odd = false;
    for first in 0..permutation.len() {
        let mut place = first;
        let mut length = 0_usize;
        while !seen[place] {
            seen[place] = true;
            place = permutation[place];
            length += 1;
        }
        odd ^= length > 1 && length.is_multiple_of(2);
    }
    odd
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> CsrMatrix {
        let mut entries = vec![];
        for (i, row) in rows.iter().enumerate() {
            entries
                .extend(row.iter().enumerate().filter(|(_, value)| **value != 0.0).map(|(j, v)| (i, j, *v)));
        }
        CsrMatrix::from_triplets(rows.len(), rows.len(), &entries).unwrap()
    }

    /// By Leibniz' formula, over all permutations.
    fn by_permutations(rows: &[Vec<f64>]) -> f64 {
        match rows {
            [] => 1.0,
            [first, rest @ ..] => (0..first.len())
                .map(|column| {
                    let minor: Vec<Vec<f64>> = rest
                        .iter()
                        .map(|row| {
                            let mut row = row.clone();
                            row.remove(column);
                            row
                        })
                        .collect();
                    let sign = if column % 2 == 0 { 1.0 } else { -1.0 };
                    sign * first[column] * by_permutations(&minor)
                })
                .sum(),
        }
    }

    #[test]
    fn signs_of_small_matrices() {
        let sign = |rows: &[&[f64]]| determinant_sign(&matrix(rows));
        assert_eq!(sign(&[&[2.0]]), Ok(Sign::Positive));
        assert_eq!(sign(&[&[0.0, 1.0], &[1.0, 0.0]]), Ok(Sign::Negative));
        assert_eq!(sign(&[&[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0], &[1.0, 0.0, 0.0]]), Ok(Sign::Positive));
        assert_eq!(sign(&[&[1e-9, 3.0], &[1e9, -4.0]]), Ok(Sign::Negative));
        assert!(matches!(sign(&[&[1.0, 2.0], &[2.0, 4.0]]), Err(LinearAlgebraError::Singular { .. })));
    }

    #[test]
    fn signs_of_irregular_matrices() {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let mut negative = 0;
        for size in [2, 3, 4, 5, 6, 7, 7, 7, 7] {
            // A third of the entries is zero; the diagonal keeps a matrix regular.
            let mut dense = vec![vec![0.0; size]; size];
            for (i, row) in dense.iter_mut().enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    let (is_stored, drawn) = (next() > -0.17, next());
                    *value = if is_stored || i == j { drawn } else { 0.0 };
                }
            }
            let rows: Vec<&[f64]> = dense.iter().map(|row| &row[..]).collect();
            let exact = by_permutations(&dense);
            let expected = if exact < 0.0 { Sign::Negative } else { Sign::Positive };
            assert_eq!(determinant_sign(&matrix(&rows)), Ok(expected), "{exact}");
            negative += usize::from(exact < 0.0);
        }
        assert!((1..9).contains(&negative));
    }
}
