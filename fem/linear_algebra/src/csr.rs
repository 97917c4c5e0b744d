//! Sparse matrices in compressed rows, on a shared sparsity pattern.

mod symmetry;
mod vanishing_diagonal;
mod whole_diagonal;

use std::sync::Arc;

use super::error::{LinearAlgebraError, check_size};
use super::large_pages::zeros;
use super::pattern::SparsityPattern;
use super::vector::first_not_finite;
use crate::threads::Threads;

/// A real sparse matrix: values on a [`SparsityPattern`] that other matrices may share, so that the
/// matrices of successive Newton steps cost their values alone.
#[derive(Clone, Debug, PartialEq)]
pub struct CsrMatrix {
    pattern: Arc<SparsityPattern>,
    values: Vec<f64>,
}

impl CsrMatrix {
    /// The zero matrix on a pattern.
    pub fn zero(pattern: &Arc<SparsityPattern>) -> Self {
        Self { pattern: pattern.clone(), values: zeros(pattern.entries()) }
    }

    /// A matrix from a pattern and one value per stored entry.
    ///
    /// # Errors
    /// If the number of values is not the number of entries.
    pub fn from_pattern(
        pattern: &Arc<SparsityPattern>,
        values: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        check_size("the list of matrix values", pattern.entries(), values.len())?;
        Ok(Self { pattern: pattern.clone(), values })
    }

    /// A matrix from a pattern and as many values as it has entries.
    pub(super) fn of_checked(pattern: &Arc<SparsityPattern>, values: Vec<f64>) -> Self {
        Self { pattern: pattern.clone(), values }
    }

    /// A matrix from (row, column, value) triplets in any order; duplicates are summed in their order.
    ///
    /// # Errors
    /// If a row or column lies outside the matrix.
    pub fn from_triplets(
        rows: usize,
        columns: usize,
        triplets: &[(usize, usize, f64)],
    ) -> Result<Self, LinearAlgebraError> {
        let mut begin = vec![0_usize; rows + 1];
        for &(row, column, _) in triplets {
            if row >= rows {
                return Err(LinearAlgebraError::IndexOutOfRange { what: "row", index: row, size: rows });
            }
            if column >= columns {
                return Err(LinearAlgebraError::IndexOutOfRange {
                    what: "column",
                    index: column,
                    size: columns,
                });
            }
            begin[row + 1] += 1;
        }
        for row in 0..rows {
            begin[row + 1] += begin[row];
        }
        let mut next = begin.clone();
        let mut sorted = vec![(0_usize, 0.0); triplets.len()];
        for &(row, column, value) in triplets {
            sorted[next[row]] = (column, value);
            next[row] += 1;
        }
        let mut row_pointers = Vec::with_capacity(rows + 1);
        row_pointers.push(0);
        let mut column_indices: Vec<u32> = Vec::with_capacity(triplets.len());
        let mut values: Vec<f64> = Vec::with_capacity(triplets.len());
        for row in 0..rows {
            let entries = &mut sorted[begin[row]..begin[row + 1]];
            entries.sort_by_key(|&(column, _)| column); // stable: duplicates keep their order
            let first = column_indices.len();
            for &(column, value) in entries.iter() {
                let column = column as u32;
                match values.last_mut() {
                    Some(last) if column_indices.len() > first && column_indices.last() == Some(&column) => {
                        *last += value;
                    }
                    _ => {
                        column_indices.push(column);
                        values.push(value);
                    }
                }
            }
            row_pointers.push(column_indices.len());
        }
        let pattern = SparsityPattern::new(rows, columns, row_pointers, column_indices)?;
        Ok(Self { pattern: Arc::new(pattern), values })
    }

    /// Number of rows.
    #[inline]
    pub fn rows(&self) -> usize {
        self.pattern.rows()
    }

    /// Number of columns.
    #[inline]
    pub fn columns(&self) -> usize {
        self.pattern.columns()
    }

    /// Starts of the rows in the list of entries; `rows + 1` numbers.
    #[inline]
    pub fn row_pointers(&self) -> &[usize] {
        self.pattern.row_pointers()
    }

    /// Column of each stored entry, ascending in each row.
    #[inline]
    pub fn column_indices(&self) -> &[u32] {
        self.pattern.column_indices()
    }

    /// Value of each stored entry.
    #[inline]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Value of each stored entry, to be overwritten.
    #[inline]
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The values without the pattern, for example to reuse their memory.
    pub fn into_values(self) -> Vec<f64> {
        self.values
    }

    /// The shared pattern.
    #[inline]
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.pattern
    }

    /// Columns and values of a row. Panics if `row >= rows`, as indexing does.
    #[inline]
    pub fn row(&self, row: usize) -> (&[u32], &[f64]) {
        let range = self.pattern.row_range(row);
        (&self.column_indices()[range.clone()], &self.values[range])
    }

    /// Entry (row, column); zero where nothing is stored.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.pattern.find(row, column).map_or(0.0, |position| self.values[position])
    }

    /// The place of an entry in the list of values.
    ///
    /// # Errors
    /// [`LinearAlgebraError::PatternMismatch`] if the entry is not stored.
    #[doc(hidden)]
    pub fn find_stored(&self, row: u32, column: u32) -> Result<usize, LinearAlgebraError> {
        let place = self.pattern.find(row as usize, column as usize);
        place.ok_or(LinearAlgebraError::PatternMismatch { what: "finding an entry that is not stored" })
    }

    /// A copy with other values of some entries.
    ///
    /// # Errors
    /// If an entry is not stored.
    pub fn with_entries(&self, entries: &[Entry]) -> Result<Self, LinearAlgebraError> {
        let mut values = self.values.clone();
        for Entry { row, column, value } in entries {
            values[self.find_stored(*row, *column)?] = *value;
        }
        Ok(Self { pattern: self.pattern.clone(), values })
    }

    /// The sum with some entries, which need not be stored here.
    ///
    /// # Errors
    /// An entry outside of the matrix.
    #[doc(hidden)]
    pub fn plus(&self, additions: &[Entry]) -> Result<Self, LinearAlgebraError> {
        let stored = additions.iter().map(|entry| self.find_stored(entry.row, entry.column));
        if let Ok(places) = stored.collect::<Result<Vec<usize>, _>>() {
            let mut values = self.values.clone();
            places.into_iter().zip(additions).for_each(|(place, entry)| values[place] += entry.value);
            return Ok(Self { pattern: self.pattern.clone(), values });
        }
        let mut triplets = Vec::with_capacity(self.values.len() + additions.len());
        for row in 0..self.rows() {
            let (columns, values) = self.row(row);
            triplets
                .extend(columns.iter().zip(values).map(|(column, value)| (row, *column as usize, *value)));
        }
        triplets
            .extend(additions.iter().map(|entry| (entry.row as usize, entry.column as usize, entry.value)));
        Self::from_triplets(self.rows(), self.columns(), &triplets)
    }

    /// The diagonal, `min(rows, columns)` values.
    pub fn diagonal(&self) -> Vec<f64> {
        let value = |place: &usize| self.values.get(*place).copied().unwrap_or(0.0);
        self.pattern.diagonal().iter().map(value).collect()
    }

    /// A x.
    ///
    /// # Errors
    /// If `x` does not have one entry per column.
    pub fn multiply(&self, x: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        let mut y = vec![0.0; self.rows()];
        self.multiply_into(x, &mut y)?;
        Ok(y)
    }

    /// y = A x, without allocating.
    ///
    /// # Errors
    /// If the sizes of `x` and `y` are not the numbers of columns and rows.
    pub fn multiply_into(&self, x: &[f64], y: &mut [f64]) -> Result<(), LinearAlgebraError> {
        self.multiply_on(Threads::ONE, x, y)
    }

    /// [`CsrMatrix::multiply_into`] on some threads: the same numbers for each number of threads.
    ///
    /// # Errors
    /// As there.
    pub fn multiply_on(&self, threads: Threads, x: &[f64], y: &mut [f64]) -> Result<(), LinearAlgebraError> {
        check_size("the vector to multiply", self.columns(), x.len())?;
        check_size("the product", self.rows(), y.len())?;
        let length = self.rows().div_ceil(threads.for_work(self.values.len())).max(1);
        let parts = y.chunks_mut(length).enumerate().collect();
        threads.run(parts, |(part, y): (usize, &mut [f64])| {
            for (row, target) in y.iter_mut().enumerate() {
                let (columns, values) = self.row(part * length + row);
                let mut sum = 0.0;
                for (&column, value) in columns.iter().zip(values) {
                    sum += value * x[column as usize];
                }
                *target = sum;
            }
        });
        Ok(())
    }

    /// Aᵀ x.
    ///
    /// # Errors
    /// If `x` does not have one entry per row.
    pub fn multiply_transposed(&self, x: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        let mut y = vec![0.0; self.columns()];
        self.multiply_transposed_into(x, &mut y)?;
        Ok(y)
    }

    /// y = Aᵀ x, without allocating.
    ///
    /// # Errors
    /// If the sizes of `x` and `y` are not the numbers of rows and columns.
    pub fn multiply_transposed_into(&self, x: &[f64], y: &mut [f64]) -> Result<(), LinearAlgebraError> {
        check_size("the vector to multiply", self.rows(), x.len())?;
        check_size("the product", self.columns(), y.len())?;
        y.fill(0.0);
        for (row, &factor) in x.iter().enumerate() {
            let (columns, values) = self.row(row);
            for (&column, value) in columns.iter().zip(values) {
                y[column as usize] += value * factor;
            }
        }
        Ok(())
    }

    /// The transposed matrix.
    pub fn transpose(&self) -> Self {
        let pattern = self.pattern.transpose();
        let mut next = pattern.row_pointers().to_vec();
        let mut values = vec![0.0; self.values.len()];
        for row in 0..self.rows() {
            let (columns, row_values) = self.row(row);
            for (&column, &value) in columns.iter().zip(row_values) {
                values[next[column as usize]] = value;
                next[column as usize] += 1;
            }
        }
        Self { pattern: Arc::new(pattern), values }
    }

    /// self += factor * other, for matrices of the same pattern.
    ///
    /// # Errors
    /// If the patterns differ.
    pub fn add_scaled(&mut self, factor: f64, other: &Self) -> Result<(), LinearAlgebraError> {
        if !self.same_pattern(other) {
            return Err(LinearAlgebraError::PatternMismatch { what: "adding a scaled matrix" });
        }
        super::vector::add_scaled(&mut self.values, factor, &other.values);
        Ok(())
    }

    /// Whether both matrices store the same positions (they need not share the pattern's memory).
    pub fn same_pattern(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.pattern, &other.pattern) || self.pattern == other.pattern
    }

    /// Largest sum of absolute values in a row, ‖A‖∞.
    pub fn row_sum_norm(&self) -> f64 {
        let of_row = |row: usize| self.row(row).1.iter().map(|value| value.abs()).sum::<f64>();
        let largest = |most: f64, sum: f64| if sum > most || sum.is_nan() { sum } else { most };
        (0..self.rows()).map(of_row).fold(0.0, largest)
    }

    /// Largest sum of absolute values in a column, ‖A‖₁ = ‖Aᵀ‖∞.
    pub fn column_sum_norm(&self) -> f64 {
        let mut sums = vec![0.0; self.columns()];
        for (&column, value) in self.column_indices().iter().zip(&self.values) {
            sums[column as usize] += value.abs();
        }
        super::vector::largest(&sums)
    }

    /// Check for an entry that is NaN or infinite.
    ///
    /// # Errors
    /// [`LinearAlgebraError::EntryNotFinite`] with the entry's row and column.
    pub fn check_finite(&self) -> Result<(), LinearAlgebraError> {
        self.check_finite_on(Threads::ONE)
    }

    /// [`CsrMatrix::check_finite`] on some threads.
    ///
    /// # Errors
    /// As there.
    pub fn check_finite_on(&self, threads: Threads) -> Result<(), LinearAlgebraError> {
        let length = self.values.len().div_ceil(threads.for_work(self.values.len())).max(1);
        let parts = self.values.chunks(length).enumerate().collect();
        let found = threads.run(parts, |(part, values): (usize, &[f64])| {
            first_not_finite(values).map(|place| part * length + place)
        });
        let Some(position) = found.into_iter().flatten().next() else {
            return Ok(());
        };
        let row = self.row_pointers().partition_point(|&begin| begin <= position) - 1;
        Err(LinearAlgebraError::EntryNotFinite {
            row,
            column: self.column_indices()[position] as usize,
            value: self.values[position],
        })
    }
}

/// An entry of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Row.
    pub row: u32,
    /// Column.
    pub column: u32,
    /// Value.
    pub value: f64,
}

#[cfg(test)]
mod tests;
