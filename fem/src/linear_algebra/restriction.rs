//! Taking chosen rows and columns out of matrices of one pattern.

use std::sync::Arc;

use super::csr::CsrMatrix;
use super::error::LinearAlgebraError;
use super::pattern::SparsityPattern;

/// Marks a column that is not kept.
const DROPPED: u32 = u32::MAX;

/// The map from matrices of one pattern to their submatrices on chosen rows and columns. It is computed
/// once; applying it copies values only, and all submatrices share one pattern.
#[derive(Clone, Debug)]
pub struct Restriction {
    source: Arc<SparsityPattern>,
    target: Arc<SparsityPattern>,
    rows: Vec<u32>,
    kept_column: Vec<bool>,
}

impl Restriction {
    /// The restriction to `rows` and `columns`, both strictly ascending.
    ///
    /// # Errors
    /// If a list is not strictly ascending or leaves the matrix.
    pub fn new(
        source: &Arc<SparsityPattern>,
        rows: &[usize],
        columns: &[usize],
    ) -> Result<Self, LinearAlgebraError> {
        check_list("row", "the list of rows", rows, source.rows())?;
        check_list("column", "the list of columns", columns, source.columns())?;
        let mut renumbered = vec![DROPPED; source.columns()];
        for (new, &old) in columns.iter().enumerate() {
            renumbered[old] = new as u32;
        }
        let mut row_pointers = Vec::with_capacity(rows.len() + 1);
        row_pointers.push(0);
        let mut column_indices = Vec::new();
        for &row in rows {
            let kept = source.row(row).iter().map(|&column| renumbered[column as usize]);
            column_indices.extend(kept.filter(|&column| column != DROPPED));
            row_pointers.push(column_indices.len());
        }
        column_indices.shrink_to_fit();
        let target = SparsityPattern::new(rows.len(), columns.len(), row_pointers, column_indices)?;
        Ok(Self {
            source: source.clone(),
            target: Arc::new(target),
            rows: rows.iter().map(|&row| row as u32).collect(),
            kept_column: renumbered.iter().map(|&column| column != DROPPED).collect(),
        })
    }

    /// Pattern of the submatrices.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.target
    }

    /// The submatrix.
    ///
    /// # Errors
    /// If the matrix does not have the pattern that the restriction was made for.
    pub fn apply(&self, matrix: &CsrMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        if !Arc::ptr_eq(matrix.pattern(), &self.source) && **matrix.pattern() != *self.source {
            return Err(LinearAlgebraError::PatternMismatch { what: "taking a submatrix" });
        }
        let mut values = Vec::with_capacity(self.target.entries());
        for &row in &self.rows {
            let (columns, row_values) = matrix.row(row as usize);
            for (&column, &value) in columns.iter().zip(row_values) {
                if self.kept_column[column as usize] {
                    values.push(value);
                }
            }
        }
        CsrMatrix::from_pattern(&self.target, values)
    }
}

fn check_list(
    what: &'static str,
    list_name: &'static str,
    list: &[usize],
    size: usize,
) -> Result<(), LinearAlgebraError> {
    if let Some(position) = (1..list.len()).find(|&k| list[k] <= list[k - 1]) {
        return Err(LinearAlgebraError::NotAscending { what: list_name, position });
    }
    match list.last() {
        Some(&index) if index >= size => Err(LinearAlgebraError::IndexOutOfRange { what, index, size }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The dense 4 × 4 matrix with a_ij = 10 i + j.
    fn dense() -> CsrMatrix {
        let triplets: Vec<_> = (0..16).map(|k| (k / 4, k % 4, (10 * (k / 4) + k % 4) as f64)).collect();
        CsrMatrix::from_triplets(4, 4, &triplets).unwrap()
    }

    #[test]
    fn rows_and_columns_are_taken_out() {
        let matrix = dense();
        let restriction = Restriction::new(matrix.pattern(), &[1, 3], &[0, 2, 3]).unwrap();
        let part = restriction.apply(&matrix).unwrap();
        assert_eq!((part.rows(), part.columns()), (2, 3));
        assert_eq!(part.values(), [10.0, 12.0, 13.0, 30.0, 32.0, 33.0]);
        let again = restriction.apply(&matrix).unwrap();
        assert!(Arc::ptr_eq(again.pattern(), part.pattern()));
    }

    #[test]
    fn bad_lists_and_patterns_are_refused() {
        let matrix = dense();
        assert!(matches!(
            Restriction::new(matrix.pattern(), &[1, 1], &[0]),
            Err(LinearAlgebraError::NotAscending { position: 1, .. })
        ));
        assert!(matches!(
            Restriction::new(matrix.pattern(), &[0], &[4]),
            Err(LinearAlgebraError::IndexOutOfRange { what: "column", index: 4, size: 4 })
        ));
        let restriction = Restriction::new(matrix.pattern(), &[0], &[0]).unwrap();
        let other = CsrMatrix::from_triplets(4, 4, &[(0, 0, 1.0)]).unwrap();
        assert!(restriction.apply(&other).is_err());
    }
}
