//! Taking chosen rows and columns out of matrices of one structure.

mod weighted;

use std::ops::Range;
use std::sync::Arc;

use super::block_matrix::BlockMatrix;
use super::block_sparsity::BlockSparsity;
use super::csr::{CsrMatrix, Entry};
use super::error::LinearAlgebraError;
use super::large_pages::PrefaultedSlice;
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
        Self::sharing(Threads::ONE, source, rows, columns, None)
    }

    /// This restriction, made on some threads, with a pattern of the submatrices that is known from elsewhere, which is shared if it is theirs.
    ///
    /// # Errors
    /// As [`Restriction::new`].
    pub fn sharing(
        threads: Threads,
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
        let pieces = pieces(threads, rows.len(), source.entries());
        let is_theirs = |known: &&Arc<SparsityPattern>| {
            let is_theirs = |numbers: Range<usize>| {
                numbers.clone().zip(&rows[numbers]).all(|(number, &row)| {
                    let (mut rest, mut is_same) = (known.row(number).iter(), true);
                    source.visit_row(row, |first, _, width| {
                        let mut kept = kept(&new_columns[first..first + width]);
                        is_same &= kept.all(|column| rest.next() == Some(column));
                    });
                    is_same && rest.next().is_none()
                })
            };
            (known.rows(), known.columns()) == (rows.len(), columns.len())
                && threads.run(pieces.clone(), is_theirs).into_iter().all(|same| same)
        };
        if let Some(known) = known.filter(is_theirs) {
            return Ok(Self::of(threads, source, known.clone(), rows, (new_rows, new_columns)));
        }
        let is_as_before = |numbers: &Range<usize>, number: usize| {
            number > numbers.start && source.are_of_one_node(rows[number - 1], rows[number])
        };
        let lengths = threads.run(pieces.clone(), |numbers: Range<usize>| {
            let mut lengths: Vec<usize> = Vec::with_capacity(numbers.len());
            for number in numbers.clone() {
                let mut length = 0;
                match lengths.last().filter(|_| is_as_before(&numbers, number)) {
                    Some(before) => length = *before,
                    None => source.visit_row(rows[number], |first, _, width| {
                        length += kept(&new_columns[first..first + width]).count();
                    }),
                }
                lengths.push(length);
            }
            lengths
        });
        let mut row_pointers = Vec::with_capacity(rows.len() + 1);
        row_pointers.push(0);
        let mut end = 0;
        row_pointers.extend(lengths.into_iter().flatten().map(|length| {
            end += length;
            end
        }));
        let mut column_indices = vec![0_u32; end];
        let slices = slices_of(&mut column_indices, &pieces, &row_pointers);
        threads.run(slices, |(numbers, mut slice): (Range<usize>, PrefaultedSlice<'_, u32>)| {
            let begin = row_pointers[numbers.start];
            for number in numbers.clone() {
                let own = row_pointers[number] - begin..row_pointers[number + 1] - begin;
                let columns = slice.written_up_to(own.end);
                if is_as_before(&numbers, number) {
                    columns.copy_within(own.start - own.len()..own.start, own.start);
                    continue;
                }
                let mut places = columns[own].iter_mut();
                source.visit_row(rows[number], |first, _, width| {
                    let kept = kept(&new_columns[first..first + width]);
                    kept.zip(&mut places).for_each(|(column, place)| *place = *column);
                });
            }
        });
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
        Ok(Self::of(threads, source, Arc::new(target), rows, (new_rows, new_columns)))
    }

    fn of(
        threads: Threads,
        source: &Arc<BlockSparsity>,
        target: Arc<SparsityPattern>,
        rows: &[usize],
        (new_rows, new_columns): (Vec<u32>, Vec<u32>),
    ) -> Self {
        let is_whole = |number: usize| target.row(number).len() == source.row_length(rows[number]);
        let pieces = pieces(threads, rows.len(), source.entries());
        let whole = threads.run(pieces, |numbers| numbers.map(is_whole).collect::<Vec<_>>()).concat();
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

    /// The submatrix. The same numbers come from any number of threads.
    ///
    /// # Errors
    /// If the matrix does not have the structure that the restriction was made for.
    pub fn apply(&self, threads: Threads, matrix: &BlockMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        self.check(matrix)?;
        let pointers = self.target.row_pointers();
        let pieces = pieces(threads, self.target.rows(), self.target.entries());
        // The row of the matrix that each row of the submatrix is.
        let mut old_rows = Vec::with_capacity(self.target.rows());
        old_rows.extend((0..self.new_rows.len()).filter(|old| self.new_rows[*old] != DROPPED));
        let mut values = vec![0.0; self.target.entries()];
        let slices = slices_of(&mut values, &pieces, pointers);
        threads.run(slices, |(numbers, mut slice): (Range<usize>, PrefaultedSlice<'_, f64>)| {
            let begin = pointers[numbers.start];
            for new in numbers {
                let own = pointers[new] - begin..pointers[new + 1] - begin;
                let values = &mut slice.written_up_to(own.end)[own];
                self.copy_row(old_rows[new], new, matrix.values(), values);
            }
        });
        Ok(CsrMatrix::of_checked(&self.target, values))
    }

    /// Copies the values of a row that are kept.
    fn copy_row(&self, old: usize, new: usize, source: &[f64], values: &mut [f64]) {
        let mut rest = values;
        if self.whole[new] {
            // Of so few numbers a copy is quicker where the compiler knows how many.
            self.source.visit_pieces(old, |place, count| {
                let (piece, after) = std::mem::take(&mut rest).split_at_mut(count);
                match count {
                    2 => piece.copy_from_slice(&source[place..place + 2]),
                    3 => piece.copy_from_slice(&source[place..place + 3]),
                    _ => piece.copy_from_slice(&source[place..place + count]),
                }
                rest = after;
            });
            return;
        }
        let mut places = rest.iter_mut();
        self.source.visit_row(old, |column, place, width| {
            let columns = self.new_columns[column..column + width].iter();
            for (column, value) in columns.zip(&source[place..place + width]) {
                if *column != DROPPED {
                    places.by_ref().take(1).for_each(|place| *place = *value);
                }
            }
        });
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
        let pieces = pieces(threads, self.new_rows.len(), base.values().len());
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

/// Ranges of rows for some threads to share, of a matrix with the given number of entries.
fn pieces(threads: Threads, rows: usize, entries: usize) -> Vec<Range<usize>> {
    let length = rows.div_ceil(threads.for_work(entries)).max(1);
    (0..rows).step_by(length).map(|first| first..(first + length).min(rows)).collect()
}

/// The part of an array that has the entries of each range of rows.
fn slices_of<'a, T>(
    array: &'a mut [T],
    pieces: &[Range<usize>],
    row_pointers: &[usize],
) -> Vec<(Range<usize>, PrefaultedSlice<'a, T>)> {
    let mut rest = array;
    let slice = |rows: &Range<usize>| {
        let count = row_pointers[rows.end] - row_pointers[rows.start];
        let (own, after) = std::mem::take(&mut rest).split_at_mut(count);
        rest = after;
        (rows.clone(), PrefaultedSlice::new(own))
    };
    pieces.iter().map(slice).collect()
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
        let part = restriction.apply(Threads::ONE, &matrix).unwrap();
        assert_eq!((part.rows(), part.columns()), (2, 3));
        assert_eq!(part.values(), [10.0, 12.0, 13.0, 30.0, 32.0, 33.0]);
        let again = restriction.apply(Threads::ONE, &matrix).unwrap();
        assert!(Arc::ptr_eq(again.pattern(), part.pattern()));
        let other = dense();
        let sharing = |columns: &[usize]| {
            let known = Some(part.pattern());
            let restriction =
                Restriction::sharing(Threads::ONE, other.sparsity(), &[1, 3], columns, known).unwrap();
            Arc::ptr_eq(restriction.pattern(), part.pattern())
        };
        assert!(sharing(&[0, 2, 3]) && sharing(&[1, 2, 3]) && !sharing(&[0, 2]) && !sharing(&[0, 1, 2, 3]));
        let sparse = BlockMatrix::from(CsrMatrix::from_triplets(4, 4, &[(1, 0, 1.0), (3, 2, 1.0)]).unwrap());
        let known = Some(part.pattern());
        let restriction =
            Restriction::sharing(Threads::ONE, sparse.sparsity(), &[1, 3], &[0, 2, 3], known).unwrap();
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
            let base = restriction.apply(Threads::ONE, &matrix).unwrap();
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
    fn submatrices_are_the_same_on_any_number_of_threads() {
        // A chain of nodes with three unknowns each, 80,982 entries.
        let nodes = 3_000;
        let near = |node: usize| node.saturating_sub(1) as u32..(node + 2).min(nodes) as u32;
        let columns: Vec<u32> = (0..nodes).flat_map(near).collect();
        let ends = (0..nodes).scan(0, |end, node| {
            *end += near(node).len();
            Some(*end)
        });
        let pointers: Vec<usize> = std::iter::once(0).chain(ends).collect();
        let sets = NodeSet::in_a_row([(nodes, 3)]);
        let rows = vec![vec![BlockRows::new(pointers, columns)]];
        let sparsity = Arc::new(BlockSparsity::new(sets.clone(), sets, rows).unwrap());
        let mut matrix = BlockMatrix::zero(&sparsity);
        (1..).zip(matrix.values_mut()).for_each(|(number, value)| *value = f64::from(number));
        let kept: Vec<usize> = (0..3 * nodes).filter(|unknown| unknown % 7 > 0 || unknown % 3 == 1).collect();
        let on = |threads: usize| {
            let threads = Threads::new(threads);
            let made = Restriction::sharing(threads, &sparsity, &kept, &kept, None).unwrap();
            let part = made.apply(threads, &matrix).unwrap();
            let again = Restriction::sharing(threads, &sparsity, &kept, &kept, Some(part.pattern())).unwrap();
            assert!(Arc::ptr_eq(again.pattern(), part.pattern()));
            assert_eq!(again.apply(threads, &matrix).unwrap().values(), part.values());
            part
        };
        let part = on(1);
        for (new, old) in kept.iter().enumerate() {
            let kept = |(column, place): (usize, usize)| {
                kept.binary_search(&column).ok().map(|column| (column as u32, matrix.values()[place]))
            };
            let (columns, values) = part.row(new);
            let found = columns.iter().copied().zip(values.iter().copied());
            assert!(found.eq(sparsity.row(*old).filter_map(kept)), "row {old}");
        }
        for threads in [2, 3, 7, 16] {
            let other = on(threads);
            assert!(**other.pattern() == **part.pattern() && other.values() == part.values(), "{threads}");
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
            restriction.apply(Threads::ONE, &matrix).unwrap().values(),
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
        assert!(
            restriction.apply(Threads::ONE, &other).is_err()
                && restriction.apply_to_places(&other, &[]).is_err()
        );
    }
}
