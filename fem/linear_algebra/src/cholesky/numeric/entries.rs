//! The entries of the matrix, from which a supernode's columns begin.

use std::ops::Range;

use super::Numeric;
use crate::ahead::ask_for;

/// Columns for whose rows memory is asked ahead: rows follow each other in the order of elimination, not in memory.
const COLUMNS_AHEAD: usize = 6;

impl<P> Numeric<'_, P> {
    /// Copies the entries of some columns from the diagonal on into a panel of zeros. `places` has the panel's row for each row, and `read`
    /// gives the number for an entry of the matrix's row.
    pub(super) fn copy_entries(
        &self,
        columns: Range<usize>,
        panel: &mut [f64],
        places: &[u32],
        read: impl Fn(usize) -> f64,
    ) {
        let height = panel.len() / columns.len().max(1);
        let (mut column, mut rest) = (columns.start, panel);
        while column < columns.end {
            self.ask_for_rows(column + COLUMNS_AHEAD);
            // The entries of a row are neighbours in memory, those of a triangle's column are not.
            let unknown = self.order[column] as usize;
            let (pattern, entries) = (self.matrix.pattern(), self.matrix.pattern().row_range(unknown));
            let unknowns = &pattern.column_indices()[entries.clone()];
            let (own, later) = rest.split_at_mut(height);
            // Rows of one pattern, as those of a node, have their entries in the same places.
            let is_pair = columns.contains(&(column + 1))
                && self.order[column + 1] as usize == unknown + 1
                && self.is_like_last[unknown + 1];
            if is_pair {
                let (next, later) = later.split_at_mut(height);
                let others = pattern.row_range(unknown + 1);
                for ((unknown, entry), other) in unknowns.iter().zip(entries).zip(others) {
                    let row = self.places[*unknown as usize] as usize;
                    if row >= column {
                        let place = places[row] as usize;
                        (own[place], next[place]) = (read(entry), read(other));
                    }
                }
                // Above the diagonal.
                next[places[column] as usize] = 0.0;
                (column, rest) = (column + 2, later);
                continue;
            }
            for (unknown, entry) in unknowns.iter().zip(entries) {
                let row = self.places[*unknown as usize] as usize;
                if row >= column {
                    own[places[row] as usize] = read(entry);
                }
            }
            (column, rest) = (column + 1, later);
        }
    }

    /// Asks for the memory of the rows of a column and of the next one.
    fn ask_for_rows(&self, column: usize) {
        if let Some(&[unknown, next]) = self.order.get(column..column + 2) {
            let (unknowns, values) = self.matrix.row(unknown as usize);
            ask_for(unknowns);
            ask_for(values);
            ask_for(self.matrix.row(next as usize).1);
        }
    }
}
