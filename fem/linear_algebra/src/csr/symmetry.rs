//! Symmetry of a matrix: its symmetric part, and how far it is from that.

use std::ops::Range;
use std::sync::Arc;

use super::CsrMatrix;
use crate::asymmetry::{Asymmetry, sizes_of_unknowns};
use crate::error::{LinearAlgebraError, check_size};
use crate::pattern::SparsityPattern;
use crate::threads::Threads;

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
        self.asymmetry_on(Threads::ONE)
    }

    /// [`CsrMatrix::asymmetry`] on some threads.
    ///
    /// # Errors
    /// As there.
    pub fn asymmetry_on(&self, threads: Threads) -> Result<f64, LinearAlgebraError> {
        check_size("the set of columns of a square matrix", self.rows(), self.columns())?;
        let sizes = self.sizes_of_unknowns();
        if sizes.iter().any(|size| size.is_nan()) {
            return Ok(f64::NAN);
        }
        let count = threads.for_work(self.values.len());
        let start = |part: usize| match part == count {
            true => self.rows(),
            false => self.row_pointers().partition_point(|first| *first < part * self.values.len() / count),
        };
        let ranges = (0..count).map(|part| start(part).min(self.rows())..start(part + 1).min(self.rows()));
        let parts = threads.run(ranges.collect(), |rows| self.asymmetry_of_rows(&sizes, rows));
        let entries_match = parts.iter().try_fold(0, |sum, part| Some(sum + part.as_ref()?.1));
        if entries_match == Some(0) {
            let larger = |most: f64, part: f64| if part > most || part.is_nan() { part } else { most };
            let worst = parts.into_iter().flatten().map(|(most, _)| most);
            return Ok(worst.fold(0.0, |most, part| if most.is_nan() { most } else { larger(most, part) }));
        }
        let mut asymmetry = Asymmetry { sizes: &sizes, most: 0.0 };
        for row in 0..self.rows() {
            let (columns, values) = self.row(row);
            for (&column, value) in columns.iter().zip(values) {
                asymmetry.visit((row, column as usize), *value, self.get(column as usize, row));
            }
        }
        Ok(asymmetry.most)
    }

    /// Of the entries right of the diagonal in some rows the asymmetry, and the number of these entries less that of those left of it;
    /// none if one has no partner. Where the numbers of all rows add up to zero the pattern is symmetric.
    fn asymmetry_of_rows(&self, sizes: &[f64], rows: Range<usize>) -> Option<(f64, i64)> {
        let (pointers, columns, first) = (self.row_pointers(), self.column_indices(), rows.start);
        let (mut asymmetry, mut surplus) = (Asymmetry { sizes, most: 0.0 }, 0);
        // Rows come in ascending order, so the partner of (i, j) is the entry of row j after the last one that was a partner. One more than
        // its place in the row; zero where there was none.
        let mut next = vec![0_u32; self.rows()];
        for row in rows {
            let own = &columns[pointers[row]..pointers[row + 1]];
            let left = own.partition_point(|column| (*column as usize) < row);
            let right = left + usize::from(own.get(left) == Some(&(row as u32)));
            surplus += (own.len() - right) as i64 - left as i64;
            for (place, column) in (pointers[row]..).zip(own).skip(right) {
                let column = *column as usize;
                let others = &columns[pointers[column]..pointers[column + 1]];
                let found = match next[column] {
                    0 => others.partition_point(|other| (*other as usize) < first),
                    known => known as usize - 1,
                };
                if others.get(found) != Some(&(row as u32)) {
                    return None;
                }
                next[column] = found as u32 + 2;
                let partner = self.values[pointers[column] + found];
                asymmetry.visit((row, column), self.values[place], partner);
            }
        }
        Some((asymmetry.most, surplus))
    }

    /// √|a_ii|; where the diagonal is zero, as that of a multiplier, the largest |a_ij| / √|a_jj|.
    #[doc(hidden)]
    pub fn sizes_of_unknowns(&self) -> Vec<f64> {
        self.sizes_by_diagonal(self.diagonal())
    }

    /// [`CsrMatrix::sizes_of_unknowns`] by a diagonal with more zeros.
    pub(crate) fn sizes_by_diagonal(&self, diagonal: Vec<f64>) -> Vec<f64> {
        sizes_of_unknowns(diagonal, |row, visit| {
            let (columns, values) = self.row(row);
            columns.iter().zip(values).for_each(|(column, value)| visit(*column as usize, *value));
        })
    }

    /// Whether [`CsrMatrix::asymmetry`] is at most `tolerance`.
    ///
    /// # Errors
    /// If the matrix is not square.
    pub fn is_symmetric(&self, tolerance: f64) -> Result<bool, LinearAlgebraError> {
        self.is_symmetric_on(Threads::ONE, tolerance)
    }

    /// [`CsrMatrix::is_symmetric`] on some threads.
    ///
    /// # Errors
    /// As there.
    pub fn is_symmetric_on(&self, threads: Threads, tolerance: f64) -> Result<bool, LinearAlgebraError> {
        Ok(self.asymmetry_on(threads)? <= tolerance)
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
