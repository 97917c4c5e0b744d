//! Symmetry of a matrix: its symmetric part, and how far it is from that.

use std::sync::Arc;

use super::CsrMatrix;
use crate::asymmetry::{Asymmetry, sizes_of_unknowns};
use crate::error::{LinearAlgebraError, check_size};
use crate::pattern::SparsityPattern;

impl CsrMatrix {
    /// (A + Aᵀ) / 2, on the same shared pattern if that is symmetric.
    ///
    /// # Errors
    /// If the matrix is not square.
    pub fn symmetric_part(&self) -> Result<Self, LinearAlgebraError> {
        check_size("the set of columns of a square matrix", self.rows(), self.columns())?;
        let mut values = self.values.clone();
        if self.for_each_pair(|k, l, _, _| {
            let mean = 0.5 * (self.values[k] + self.values[l]);
            values[k] = mean;
            values[l] = mean;
        }) {
            return Ok(Self { pattern: self.pattern.clone(), values });
        }
        let transposed = self.transpose();
        let mut triplets = Vec::with_capacity(2 * self.values.len());
        for row in 0..self.rows() {
            for matrix in [self, &transposed] {
                let (columns, values) = matrix.row(row);
                triplets.extend(columns.iter().zip(values).map(|(&c, v)| (row, c as usize, 0.5 * v)));
            }
        }
        Self::from_triplets(self.rows(), self.columns(), &triplets)
    }

    /// The matrix on a shared pattern that has all of its entries.
    ///
    /// # Errors
    /// If an entry is missing there.
    #[doc(hidden)]
    pub fn on_pattern(&self, pattern: &Arc<SparsityPattern>) -> Result<Self, LinearAlgebraError> {
        if Arc::ptr_eq(&self.pattern, pattern) {
            return Ok(self.clone());
        }
        let mut larger = Self::zero(pattern);
        for row in 0..self.rows() {
            let (columns, values) = self.row(row);
            for (column, value) in columns.iter().zip(values) {
                let place = larger.find_stored(row as u32, *column)?;
                larger.values[place] = *value;
            }
        }
        Ok(larger)
    }

    /// Largest |a_ij − a_ji| relative to the size of the entry, which is the largest of |a_ij|, |a_ji| and √|a_ii a_jj|: each
    /// pair in its own unit, so that a stiff part does not hide a soft one. 0 for the zero matrix, NaN if an entry is NaN.
    ///
    /// # Errors
    /// If the matrix is not square.
    pub fn asymmetry(&self) -> Result<f64, LinearAlgebraError> {
        check_size("the set of columns of a square matrix", self.rows(), self.columns())?;
        let sizes = self.sizes_of_unknowns();
        if sizes.iter().any(|size| size.is_nan()) {
            return Ok(f64::NAN);
        }
        let mut asymmetry = Asymmetry { sizes: &sizes, most: 0.0 };
        let of_pair = |k: usize, l: usize, row: usize, column: usize| {
            asymmetry.visit((row, column), self.values[k], self.values[l]);
        };
        if !self.for_each_pair(of_pair) {
            for row in 0..self.rows() {
                let (columns, values) = self.row(row);
                for (&column, value) in columns.iter().zip(values) {
                    asymmetry.visit((row, column as usize), *value, self.get(column as usize, row));
                }
            }
        }
        Ok(asymmetry.most)
    }

    /// √|a_ii|; where the diagonal is zero, as that of a multiplier, the largest |a_ij| / √|a_jj|.
    #[doc(hidden)]
    pub fn sizes_of_unknowns(&self) -> Vec<f64> {
        sizes_of_unknowns(self.diagonal(), |row, visit| {
            let (columns, values) = self.row(row);
            columns.iter().zip(values).for_each(|(column, value)| visit(*column as usize, *value));
        })
    }

    /// Whether [`CsrMatrix::asymmetry`] is at most `tolerance`.
    ///
    /// # Errors
    /// If the matrix is not square.
    pub fn is_symmetric(&self, tolerance: f64) -> Result<bool, LinearAlgebraError> {
        Ok(self.asymmetry()? <= tolerance)
    }

    /// Calls `visit` with the positions of (i, j) and (j, i), i and j for every stored j > i. Returns false, perhaps
    /// after some calls, if the pattern is not symmetric.
    fn for_each_pair(&self, mut visit: impl FnMut(usize, usize, usize, usize)) -> bool {
        let pointers = self.row_pointers();
        let columns = self.column_indices();
        // Rows come in ascending order, so the partner of (i, j) is the next unvisited entry of row j: where it comes to that row
        // itself, all before its diagonal have been met.
        let mut next: Vec<usize> = pointers[..self.rows()].to_vec();
        for row in 0..self.rows() {
            for position in next[row]..pointers[row + 1] {
                let column = columns[position] as usize;
                if column == row {
                    continue;
                }
                let partner = next[column];
                if column < row || partner >= pointers[column + 1] || columns[partner] as usize != row {
                    return false;
                }
                next[column] += 1;
                visit(position, partner, row, column);
            }
        }
        true
    }
}
