//! The sparsity pattern of a compressed-row matrix, shared between matrices.

use std::sync::{Arc, OnceLock};

use super::cells::Cells;
use super::error::{LinearAlgebraError, check_size};

/// Positions of the stored entries, row after row, with strictly ascending columns in each row. It may know the cells that
/// they come from, which an [`Ordering`](super::Ordering) gains from; they make no difference between patterns.
#[derive(Clone, Debug)]
pub struct SparsityPattern {
    rows: usize,
    columns: usize,
    row_pointers: Vec<usize>,
    column_indices: Vec<u32>,
    cells: Option<Arc<Cells>>,
    /// The places of the diagonal's entries; `usize::MAX` where none is stored.
    diagonal: OnceLock<Vec<usize>>,
}

impl PartialEq for SparsityPattern {
    fn eq(&self, other: &Self) -> bool {
        (self.rows, self.columns) == (other.rows, other.columns)
            && self.row_pointers == other.row_pointers
            && self.column_indices == other.column_indices
    }
}

impl Eq for SparsityPattern {}

impl SparsityPattern {
    /// A pattern from its parts: `row_pointers` has `rows + 1` entries, row i owns
    /// `column_indices[row_pointers[i]..row_pointers[i + 1]]`.
    ///
    /// # Errors
    /// If sizes disagree or pass 32 bits, a column lies outside the matrix, or a row is not strictly ascending.
    pub fn new(
        rows: usize,
        columns: usize,
        row_pointers: Vec<usize>,
        column_indices: Vec<u32>,
    ) -> Result<Self, LinearAlgebraError> {
        check_size("the list of row pointers", rows + 1, row_pointers.len())?;
        check_size("the first row pointer", 0, row_pointers[0])?;
        check_size("the list of column indices", row_pointers[rows], column_indices.len())?;
        if u32::try_from(rows.max(columns)).is_err() {
            return Err(LinearAlgebraError::TooLarge { what: "the set of rows or columns" });
        }
        for row in 0..rows {
            let (begin, end) = (row_pointers[row], row_pointers[row + 1]);
            if end < begin || end > column_indices.len() {
                return Err(LinearAlgebraError::NotAscending {
                    what: "the list of row pointers",
                    position: row + 1,
                });
            }
            let entries = &column_indices[begin..end];
            if let Some(k) = (1..entries.len()).find(|&k| entries[k] <= entries[k - 1]) {
                return Err(LinearAlgebraError::NotAscending {
                    what: "the column indices of a row",
                    position: begin + k,
                });
            }
            if let Some(&last) = entries.last()
                && last as usize >= columns
            {
                return Err(LinearAlgebraError::IndexOutOfRange {
                    what: "column",
                    index: last as usize,
                    size: columns,
                });
            }
        }
        Ok(Self::of_checked(rows, columns, row_pointers, column_indices, None))
    }

    /// This pattern with the cells whose unknowns it couples; none where they are not known.
    ///
    /// # Errors
    /// If a cell has an unknown that is none of the rows or columns.
    pub fn with_cells(self, cells: Option<Arc<Cells>>) -> Result<Self, LinearAlgebraError> {
        if let Some(cells) = &cells {
            cells.check(self.rows.min(self.columns))?;
        }
        Ok(Self { cells, ..self })
    }

    /// The cells whose unknowns the pattern couples, where they are known. It may couple others as well.
    pub fn cells(&self) -> Option<&Arc<Cells>> {
        self.cells.as_ref()
    }

    /// A pattern from parts that are known to fit.
    pub(super) fn of_checked(
        rows: usize,
        columns: usize,
        row_pointers: Vec<usize>,
        column_indices: Vec<u32>,
        cells: Option<Arc<Cells>>,
    ) -> Self {
        let diagonal = OnceLock::new();
        SparsityPattern { rows, columns, row_pointers, column_indices, cells, diagonal }
    }

    /// Number of rows.
    #[inline]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The places of the diagonal's entries among all, `usize::MAX` where none is stored. Found at the first call.
    pub(crate) fn diagonal(&self) -> &[usize] {
        let places = || (0..self.rows.min(self.columns)).map(|row| self.find(row, row).unwrap_or(usize::MAX));
        self.diagonal.get_or_init(|| places().collect())
    }

    /// Number of stored entries.
    #[inline]
    pub fn entries(&self) -> usize {
        self.column_indices.len()
    }

    /// Starts of the rows; `rows + 1` numbers.
    #[inline]
    pub fn row_pointers(&self) -> &[usize] {
        &self.row_pointers
    }

    /// Column of each stored entry.
    #[inline]
    pub fn column_indices(&self) -> &[u32] {
        &self.column_indices
    }

    /// Columns stored in a row. Panics if `row >= rows`, as indexing does.
    #[inline]
    pub fn row(&self, row: usize) -> &[u32] {
        &self.column_indices[self.row_range(row)]
    }

    /// Positions of a row's entries in the list of all entries.
    #[inline]
    pub(crate) fn row_range(&self, row: usize) -> std::ops::Range<usize> {
        self.row_pointers[row]..self.row_pointers[row + 1]
    }

    /// Position of an entry in the list of all entries, if it is stored.
    #[inline]
    pub fn find(&self, row: usize, column: usize) -> Option<usize> {
        if row >= self.rows {
            return None;
        }
        let range = self.row_range(row);
        let column = u32::try_from(column).ok()?;
        self.column_indices[range.clone()].binary_search(&column).ok().map(|k| range.start + k)
    }

    /// The transposed pattern.
    pub fn transpose(&self) -> Self {
        let mut row_pointers = vec![0; self.columns + 1];
        for &column in &self.column_indices {
            row_pointers[column as usize + 1] += 1;
        }
        for column in 0..self.columns {
            row_pointers[column + 1] += row_pointers[column];
        }
        let mut next = row_pointers.clone();
        let mut column_indices = vec![0; self.column_indices.len()];
        for row in 0..self.rows {
            for &column in self.row(row) {
                let slot = &mut next[column as usize];
                column_indices[*slot] = row as u32;
                *slot += 1;
            }
        }
        let cells = self.cells.clone();
        Self::of_checked(self.columns, self.rows, row_pointers, column_indices, cells)
    }

    /// Whether (j, i) is stored wherever (i, j) is.
    pub fn is_symmetric(&self) -> bool {
        if self.rows != self.columns {
            return false;
        }
        // Rows are visited in ascending order, so the partner (j, i) of (i, j) must be the next entry of row j.
        let mut next: Vec<usize> = self.row_pointers[..self.rows].to_vec();
        for row in 0..self.rows {
            for &column in self.row(row) {
                let partner = &mut next[column as usize];
                if *partner >= self.row_pointers[column as usize + 1]
                    || self.column_indices[*partner] as usize != row
                {
                    return false;
                }
                *partner += 1;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_parts_are_refused() {
        let size = |result| matches!(result, Err(LinearAlgebraError::SizeMismatch { .. }));
        assert!(size(SparsityPattern::new(2, 2, vec![0, 1], vec![0])));
        assert!(size(SparsityPattern::new(1, 2, vec![0, 2], vec![0])));
        assert!(matches!(
            SparsityPattern::new(1, 2, vec![0, 2], vec![1, 1]),
            Err(LinearAlgebraError::NotAscending { position: 1, .. })
        ));
        assert!(matches!(
            SparsityPattern::new(2, 2, vec![0, 2, 1], vec![0]),
            Err(LinearAlgebraError::NotAscending { .. })
        ));
        assert!(matches!(
            SparsityPattern::new(1, 2, vec![0, 1], vec![2]),
            Err(LinearAlgebraError::IndexOutOfRange { index: 2, size: 2, .. })
        ));
    }

    #[test]
    fn symmetry_and_transposition() {
        let full = SparsityPattern::new(2, 2, vec![0, 2, 4], vec![0, 1, 0, 1]).unwrap();
        assert!(full.is_symmetric());
        assert_eq!(full.transpose(), full);
        let upper = SparsityPattern::new(2, 2, vec![0, 2, 3], vec![0, 1, 1]).unwrap();
        assert!(!upper.is_symmetric());
        assert!(!upper.transpose().is_symmetric());
        assert_eq!(upper.transpose().transpose(), upper);
        assert_eq!(upper.find(0, 1), Some(1));
        assert_eq!(upper.find(1, 0), None);
        assert_eq!(upper.find(7, 0), None);
    }
}
