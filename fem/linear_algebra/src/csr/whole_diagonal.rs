//! Zeros on the diagonal that are not stored, as those of multipliers.

use std::sync::Arc;

use super::CsrMatrix;
use crate::error::{LinearAlgebraError, check_size};
use crate::pattern::SparsityPattern;

impl CsrMatrix {
    /// The matrix with all entries of its diagonal stored, on the same shared pattern if that has them.
    ///
    /// # Errors
    /// If the matrix is not square.
    #[doc(hidden)]
    pub fn with_whole_diagonal(self) -> Result<Self, LinearAlgebraError> {
        check_size("the set of columns of a square matrix", self.rows(), self.columns())?;
        let size = self.rows();
        let is_missing = |row: &usize| self.pattern.find(*row, *row).is_none();
        let missing = (0..size).filter(is_missing).count();
        if missing == 0 {
            return Ok(self);
        }
        let entries = self.values.len() + missing;
        let (mut pointers, mut indices) = (vec![0], Vec::with_capacity(entries));
        let mut all = Vec::with_capacity(entries);
        for row in 0..size {
            let (columns, values) = self.row(row);
            let before = columns.partition_point(|column| (*column as usize) < row);
            indices.extend_from_slice(&columns[..before]);
            all.extend_from_slice(&values[..before]);
            if columns.get(before).is_none_or(|column| *column as usize != row) {
                indices.push(row as u32);
                all.push(0.0);
            }
            indices.extend_from_slice(&columns[before..]);
            all.extend_from_slice(&values[before..]);
            pointers.push(indices.len());
        }
        let pattern = SparsityPattern::new(size, size, pointers, indices)?;
        let pattern = pattern.with_cells(self.pattern.cells().cloned())?;
        Self::from_pattern(&Arc::new(pattern), all)
    }
}
