//! Taking chosen rows and columns out of matrices of one structure.

mod weighted;

use std::ops::Range;
use std::sync::Arc;

use super::block_matrix::BlockMatrix;
use super::block_sparsity::BlockSparsity;
use super::csr::{CsrMatrix, Entry};
use super::error::LinearAlgebraError;
use super::large_pages::Filling;
use super::pattern::SparsityPattern;
use super::threads::Threads;
pub use weighted::{WeightedRestriction, Weights};

/// Marks a column that is not kept.
const DROPPED: u32 = u32::MAX;

/// The map from matrices of one structure to their submatrices on chosen rows and columns. It is computed
/// once; applying it copies values only, and all submatrices share one pattern.
#[derive(Clone, Debug)]
pub struct Restriction {
    source: Arc<BlockSparsity>,
    target: Arc<SparsityPattern>,
    /// Rows and columns of the submatrix, or [`DROPPED`].
    new_rows: Vec<u32>,
    new_columns: Vec<u32>,
    /// Rows of the submatrix that are whole rows of the matrix.
    whole: Vec<bool>,
}

impl Restriction {
    /// The restriction to `rows` and `columns`, both strictly ascending.
    ///
    /// # Errors
    /// If a list is not strictly ascending or leaves the matrix.
    pub fn new(
        source: &Arc<BlockSparsity>,
        rows: &[usize],
        columns: &[usize],
    ) -> Result<Self, LinearAlgebraError> {
        Self::sharing(source, rows, columns, None)
    }

    /// This restriction with a pattern of the submatrices that is known from elsewhere, which is shared if it is theirs.
    ///
    /// # Errors
    /// As [`Restriction::new`].
    pub fn sharing(
        source: &Arc<BlockSparsity>,
        rows: &[usize],
        columns: &[usize],
        known: Option<&Arc<SparsityPattern>>,
    ) -> Result<Self, LinearAlgebraError> {
        check_list("row", "the list of rows", rows, source.row_count())?;
        check_list("column", "the list of columns", columns, source.column_count())?;
        let renumbered = |kept: &[usize], count: usize| {
            let mut new = vec![DROPPED; count];
            for (number, &old) in kept.iter().enumerate() {
                new[old] = number as u32;
            }
            new
        };
        let new_rows = renumbered(rows, source.row_count());
        let new_columns = renumbered(columns, source.column_count());
        let is_theirs = |known: &&Arc<SparsityPattern>| {
            (known.rows(), known.columns()) == (rows.len(), columns.len())
                && rows.iter().enumerate().all(|(number, &row)| {
                    let (mut rest, mut is_same) = (known.row(number).iter(), true);
                    source.visit_row(row, |first, _, width| {
                        let mut kept = kept(&new_columns[first..first + width]);
                        is_same &= kept.all(|column| rest.next() == Some(column));
                    });
                    is_same && rest.next().is_none()
                })
        };
        if let Some(known) = known.filter(is_theirs) {
            return Ok(Self::of(source, known.clone(), rows, (new_rows, new_columns)));
        }
        let mut row_pointers = Vec::with_capacity(rows.len() + 1);
        row_pointers.push(0);
        let mut filling = Filling::with_room(source.entries());
        for (number, &row) in rows.iter().enumerate() {
            let column_indices = filling.before_adding(source.row_length(row));
            if number > 0 && source.are_of_one_node(rows[number - 1], row) {
                column_indices.extend_from_within(row_pointers[number - 1]..);
            } else {
                source.visit_row(row, |first, _, width| {
                    for column in kept(&new_columns[first..first + width]) {
                        column_indices.push(*column);
                    }
                });
            }
            row_pointers.push(column_indices.len());
        }
        let mut column_indices = filling.into_list();
        column_indices.shrink_to_fit();
        // Rows and columns that are numbered alike have cells.
        let cells = source.cells().filter(|_| rows == columns).map(|cells| {
            let numbers = |unknown: u32, visit: &mut dyn FnMut(u32)| match new_rows[unknown as usize] {
                DROPPED => (),
                number => visit(number),
            };
            Arc::new(cells.renumbered(numbers))
        });
        let (height, width) = (rows.len(), columns.len());
        let target = SparsityPattern::of_checked(height, width, row_pointers, column_indices, cells);
        Ok(Self::of(source, Arc::new(target), rows, (new_rows, new_columns)))
    }

    fn of(
        source: &Arc<BlockSparsity>,
        target: Arc<SparsityPattern>,
        rows: &[usize],
        (new_rows, new_columns): (Vec<u32>, Vec<u32>),
    ) -> Self {
        let is_whole = |(number, row): (usize, &usize)| target.row(number).len() == source.row_length(*row);
        let whole = rows.iter().enumerate().map(is_whole).collect();
        Self { source: source.clone(), target, new_rows, new_columns, whole }
    }

    /// Pattern of the submatrices.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.target
    }

    /// Whether a matrix has the structure that the restriction was made for.
    pub fn fits(&self, matrix: &BlockMatrix) -> bool {
        Arc::ptr_eq(matrix.sparsity(), &self.source) || **matrix.sparsity() == *self.source
    }

    /// Whether these are the rows and columns that are kept, both strictly ascending.
    pub fn keeps(&self, rows: &[usize], columns: &[usize]) -> bool {
        let kept = |new: &[u32], list: &[usize], count: usize| {
            let in_place = |(number, &old): (usize, &usize)| new.get(old) == Some(&(number as u32));
            list.len() == count && list.iter().enumerate().all(in_place)
        };
        kept(&self.new_rows, rows, self.target.rows())
            && kept(&self.new_columns, columns, self.target.columns())
    }

    fn check(&self, matrix: &BlockMatrix) -> Result<(), LinearAlgebraError> {
        match self.fits(matrix) {
            true => Ok(()),
            false => Err(LinearAlgebraError::PatternMismatch { what: "taking a submatrix" }),
        }
    }

    /// The submatrix.
    ///
    /// # Errors
    /// If the matrix does not have the structure that the restriction was made for.
    pub fn apply(&self, matrix: &BlockMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        self.check(matrix)?;
        let mut filling = Filling::with_room(self.target.entries());
        let kept = self.new_rows.iter().enumerate().filter(|(_, new)| **new != DROPPED);
        for (row, new) in kept {
            let values = filling.before_adding(self.target.row(*new as usize).len());
            if self.whole[*new as usize] {
                let source = matrix.values();
                // Of so few numbers a copy is quicker where the compiler knows how many.
                self.source.visit_pieces(row, |place, count| match count {
                    2 => values.extend_from_slice(&source[place..place + 2]),
                    3 => values.extend_from_slice(&source[place..place + 3]),
                    _ => values.extend_from_slice(&source[place..place + count]),
                });
                continue;
            }
            self.source.visit_row(row, |column, place, width| {
                let columns = self.new_columns[column..column + width].iter();
                for (column, value) in columns.zip(&matrix.values()[place..place + width]) {
                    if *column != DROPPED {
                        values.push(*value);
                    }
                }
            });
        }
        Ok(CsrMatrix::of_checked(&self.target, filling.into_list()))
    }

    /// The entries by which the submatrix differs from another matrix on its pattern: what is added to them there. None if there are
    /// more than `most`. Nothing of the submatrix is stored. The same entries come from any number of threads.
    ///
    /// # Errors
    /// As [`Restriction::apply`], also if the other matrix is on another pattern; an entry that is not finite.
    pub fn differences(
        &self,
        threads: Threads,
        matrix: &BlockMatrix,
        base: &CsrMatrix,
        most: usize,
    ) -> Result<Option<Vec<Entry>>, LinearAlgebraError> {
        self.check(matrix)?;
        if !Arc::ptr_eq(base.pattern(), &self.target) && **base.pattern() != *self.target {
            return Err(LinearAlgebraError::PatternMismatch { what: "comparing a submatrix" });
        }
        let rows = self.new_rows.len().div_ceil(threads.for_work(base.values().len())).max(1);
        let pieces = (0..self.new_rows.len()).step_by(rows);
        let pieces = pieces.map(|first| first..(first + rows).min(self.new_rows.len())).collect();
        let found = threads.run(pieces, |rows| self.differences_in(rows, matrix.values(), base, most));
        if found.iter().map(Vec::len).sum::<usize>() > most {
            return Ok(None);
        }
        let found = found.concat();
        match found.iter().find(|entry| !entry.value.is_finite()) {
            None => Ok(Some(found)),
            Some(&Entry { row, column, value }) => {
                Err(LinearAlgebraError::EntryNotFinite { row: row as usize, column: column as usize, value })
            }
        }
    }

    /// The differences in some rows of the matrix; once there are more than `most`, those of the rows so far.
    fn differences_in(
        &self,
        rows: Range<usize>,
        source: &[f64],
        base: &CsrMatrix,
        most: usize,
    ) -> Vec<Entry> {
        let mut found = Vec::new();
        for old in rows.filter(|old| self.new_rows[*old] != DROPPED) {
            let row = self.new_rows[old];
            let (columns, known) = base.row(row as usize);
            let mut place = 0;
            let mut compare = |values: &[f64]| {
                let known = &known[place..place + values.len()];
                // A number that is none differs from every other.
                for (k, (value, base)) in values.iter().zip(known).enumerate() {
                    if *value != *base {
                        found.push(Entry { row, column: columns[place + k], value: value - base });
                    }
                }
                place += values.len();
            };
            if self.whole[row as usize] {
                self.source.visit_pieces(old, |place, count| compare(&source[place..place + count]));
            } else {
                self.source.visit_row(old, |column, place, width| {
                    let columns = self.new_columns[column..column + width].iter();
                    let values = columns.zip(source[place..place + width].chunks_exact(1));
                    values.filter(|(column, _)| **column != DROPPED).for_each(|(_, value)| compare(value));
                });
            }
            if found.len() > most {
                break;
            }
        }
        found
    }

    /// The entries of the submatrix whose values are at some places of the matrix, as ranges of whole blocks.
    ///
    /// # Errors
    /// As [`Restriction::apply`].
    pub fn apply_to_places(
        &self,
        matrix: &BlockMatrix,
        places: &[Range<usize>],
    ) -> Result<Vec<Entry>, LinearAlgebraError> {
        self.check(matrix)?;
        let mut entries = Vec::new();
        self.source.visit_places(places, |row, column, place| {
            let (row, column) = (self.new_rows[row], self.new_columns[column]);
            if row != DROPPED && column != DROPPED {
                entries.push(Entry { row, column, value: matrix.values()[place] });
            }
        });
        Ok(entries)
    }
}

/// The columns that are kept, of the new numbers of some columns.
fn kept(new: &[u32]) -> impl Iterator<Item = &u32> {
    new.iter().filter(|column| **column != DROPPED)
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
    use crate::{BlockRows, NodeSet};

    /// The dense 4 × 4 matrix with a_ij = 10 i + j.
    fn dense() -> BlockMatrix {
        let triplets: Vec<_> = (0..16).map(|k| (k / 4, k % 4, (10 * (k / 4) + k % 4) as f64)).collect();
        CsrMatrix::from_triplets(4, 4, &triplets).unwrap().into()
    }

    #[test]
    fn rows_and_columns_are_taken_out() {
        let matrix = dense();
        let restriction = Restriction::new(matrix.sparsity(), &[1, 3], &[0, 2, 3]).unwrap();
        let part = restriction.apply(&matrix).unwrap();
        assert_eq!((part.rows(), part.columns()), (2, 3));
        assert_eq!(part.values(), [10.0, 12.0, 13.0, 30.0, 32.0, 33.0]);
        let again = restriction.apply(&matrix).unwrap();
        assert!(Arc::ptr_eq(again.pattern(), part.pattern()));
        let other = dense();
        let sharing = |columns: &[usize]| {
            let known = Some(part.pattern());
            let restriction = Restriction::sharing(other.sparsity(), &[1, 3], columns, known).unwrap();
            Arc::ptr_eq(restriction.pattern(), part.pattern())
        };
        assert!(sharing(&[0, 2, 3]) && sharing(&[1, 2, 3]) && !sharing(&[0, 2]) && !sharing(&[0, 1, 2, 3]));
        let sparse = BlockMatrix::from(CsrMatrix::from_triplets(4, 4, &[(1, 0, 1.0), (3, 2, 1.0)]).unwrap());
        let known = Some(part.pattern());
        let restriction = Restriction::sharing(sparse.sparsity(), &[1, 3], &[0, 2, 3], known).unwrap();
        assert_eq!(restriction.pattern().column_indices(), [0, 1]);
        assert!(restriction.keeps(&[1, 3], &[0, 2, 3]));
        for (rows, columns) in
            [([1, 2], &[0, 2, 3][..]), ([1, 3], &[0, 2]), ([1, 3], &[0, 1, 3]), ([1, 9], &[0, 2, 3])]
        {
            assert!(!restriction.keeps(&rows, columns), "{rows:?} {columns:?}");
        }
    }

    #[test]
    fn differences_are_what_is_added() {
        let matrix = dense();
        let other_pattern = &CsrMatrix::from_triplets(2, 2, &[(0, 0, 1.0)]).unwrap();
        let all = [0, 1, 2, 3];
        for (rows, columns) in [(&all[1..], &all[..]), (&[1, 3][..], &[0, 2, 3][..])] {
            let restriction = Restriction::new(matrix.sparsity(), rows, columns).unwrap();
            let base = restriction.apply(&matrix).unwrap();
            assert_eq!(restriction.differences(Threads::ONE, &matrix, &base, 0).unwrap(), Some(vec![]));
            let added = Entry { row: 1, column: 1, value: 0.5 };
            let other = base.plus(&[Entry { value: -0.5, ..added }, Entry { row: 0, ..added }]).unwrap();
            let expected = vec![Entry { row: 0, value: -0.5, ..added }, added];
            assert_eq!(restriction.differences(Threads::ONE, &matrix, &other, 2).unwrap(), Some(expected));
            assert_eq!(restriction.differences(Threads::ONE, &matrix, &other, 1).unwrap(), None);
            let mut wrong = dense();
            let place = wrong.sparsity().find(rows[1], columns[2]).unwrap();
            wrong.values_mut()[place] = f64::NAN;
            let error = restriction.differences(Threads::ONE, &wrong, &base, 9).unwrap_err();
            assert!(
                matches!(error, LinearAlgebraError::EntryNotFinite { row: 1, column: 2, .. }),
                "{error:?}"
            );
            assert!(restriction.differences(Threads::ONE, &matrix, other_pattern, 9).is_err());
        }
    }

    #[test]
    fn entries_at_some_places() {
        let sets = NodeSet::in_a_row([(2, 2)]);
        let full = BlockRows::new(vec![0, 2, 4], vec![0, 1, 0, 1]);
        let sparsity = Arc::new(BlockSparsity::new(sets.clone(), sets, vec![vec![full]]).unwrap());
        let mut matrix = BlockMatrix::zero(&sparsity);
        for row in 0..4 {
            for column in 0..4 {
                matrix.values_mut()[sparsity.find(row, column).unwrap()] = (10 * row + column) as f64;
            }
        }
        let restriction = Restriction::new(&sparsity, &[1, 2, 3], &[0, 1, 3]).unwrap();
        assert_eq!(
            restriction.apply(&matrix).unwrap().values(),
            [10.0, 11.0, 13.0, 20.0, 21.0, 23.0, 30.0, 31.0, 33.0]
        );
        // The blocks of the node pairs (0, 1) and (1, 0), which follow each other.
        let entries = restriction.apply_to_places(&matrix, &[4..8, 8..12]).unwrap();
        let together = restriction.apply_to_places(&matrix, std::slice::from_ref(&(4..12))).unwrap();
        assert_eq!(entries, together);
        let found: Vec<_> = entries.iter().map(|entry| (entry.row, entry.column, entry.value)).collect();
        let expected = [(0, 2, 13.0), (1, 0, 20.0), (1, 1, 21.0), (2, 0, 30.0), (2, 1, 31.0)];
        assert_eq!(found, expected);
    }

    #[test]
    fn bad_lists_and_patterns_are_refused() {
        let matrix = dense();
        assert!(matches!(
            Restriction::new(matrix.sparsity(), &[1, 1], &[0]),
            Err(LinearAlgebraError::NotAscending { position: 1, .. })
        ));
        assert!(matches!(
            Restriction::new(matrix.sparsity(), &[0], &[4]),
            Err(LinearAlgebraError::IndexOutOfRange { what: "column", index: 4, size: 4 })
        ));
        let restriction = Restriction::new(matrix.sparsity(), &[0], &[0]).unwrap();
        let other = BlockMatrix::from(CsrMatrix::from_triplets(4, 4, &[(0, 0, 1.0)]).unwrap());
        assert!(restriction.apply(&other).is_err() && restriction.apply_to_places(&other, &[]).is_err());
    }
}
