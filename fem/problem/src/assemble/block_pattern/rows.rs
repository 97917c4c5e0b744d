//! Builds block rows column by column, so that columns are sorted without comparisons; records each element block's slot.
//!
//! Example: three cells in a row with the nodes (0, 1), (1, 2), (2, 3). Column 0 is appended to the rows of its cell, 0 and 1. Column 1 is
//! appended to the rows 0, 1 and 2, column 2 to 1, 2 and 3, column 3 to 2 and 3. Row 1 is then (0, 1, 2), in ascending order. The cell
//! (1, 2) finds the block of row 1 and column 2 in slot 2 of that row.
//!
//! No step has a branch that depends on the numbers: what mispredicted ones take is more than what is computed.

use std::ops::Range;

use super::block_index::Slot;
use super::element_nodes::ElementNodes;
use crate::linear_algebra::large_pages::{room, zeros};

/// The rows that a thread makes, and where it may write places.
pub(super) struct RowsOfThread<'a, 'p, P> {
    pub cliques: &'a ElementNodes<'a>,
    /// The rows. No clique before its own has a node among them.
    pub rows: Range<usize>,
    /// The thread's own cliques among those whose places are kept.
    pub own: Range<usize>,
    /// Starts of the places of each clique that is mapped, and their end.
    pub begins: &'a [usize],
    /// Places of the thread's own cliques.
    pub places: &'p mut [P],
    pub column_nodes: usize,
}

/// Rows, and places in cliques that are not the thread's own.
pub(super) struct MadeRows<P> {
    /// Start of each row's columns, and the end of all.
    pub pointers: Vec<usize>,
    pub columns: Vec<u32>,
    /// Elements of later threads, and those without a map, that have nodes among the rows.
    pub later: Vec<u32>,
    /// The places of each of them; those of other threads' rows mean nothing.
    pub places_of_later: Vec<P>,
}

impl<P: Slot + Default> RowsOfThread<'_, '_, P> {
    /// None if a row is too long for the places' type.
    pub fn make(self) -> Option<MadeRows<P>> {
        let RowsOfThread { cliques, rows, own, begins, places, column_nodes } = self;
        let near = NearbyElements::new(cliques, &rows, own);
        // Where the places of each clique begin among those of the thread's own, and among the others.
        let begins = &begins[near.own.start..];
        let mut places_of_later: Vec<P> = zeros(near.later_begins[near.later.len()]);
        let around = ElementsOfColumn::new(&near, column_nodes);
        // Per row, packed: (last column + 1) << 32 | its index in the row; a row without a column has the index before the first.
        let mut last: Vec<u64> = room(rows.len());
        last.resize(rows.len(), u64::from(u32::MAX));
        let mut start = 0;
        for (column, &end) in around.ends.iter().enumerate() {
            let column = (column as u64 + 1) << 32;
            for &(clique, j) in &around.members[start..end] {
                let (test_nodes, trial_nodes) = near.nodes(clique as usize);
                let (places, begin) = match near.later_place(clique as usize) {
                    None => (&mut *places, begins[clique as usize] - begins[0]),
                    Some(begin) => (&mut places_of_later[..], begin),
                };
                let mut next = begin + j as usize;
                for &row in test_nodes {
                    let place = next;
                    next += trial_nodes.len();
                    // Rows of other threads are left out.
                    let Some(last) = last.get_mut((row as usize).wrapping_sub(rows.start)) else { continue };
                    let behind = column | u64::from((*last as u32).wrapping_add(1));
                    // Another clique may have brought the column already.
                    *last = if *last < column { behind } else { *last };
                    // What the type cannot hold is cut off here, and the row refused below.
                    places[place] = P::new(*last as u32);
                }
            }
            start = end;
        }
        let mut pointers = room(rows.len() + 1);
        pointers.push(0);
        let (mut end, mut longest) = (0, 0);
        for last in last {
            let count = (last as u32).wrapping_add(1) as usize;
            longest = longest.max(count);
            end += count;
            pointers.push(end);
        }
        if longest > P::LONGEST_ROW {
            return None;
        }
        // Its memory is that of the columns.
        drop(around);
        let mut columns: Vec<u32> = zeros(end);
        for clique in 0..near.count() {
            let (test_nodes, trial_nodes) = near.nodes(clique);
            let (places, mut next) = match near.later_place(clique) {
                None => (&*places, begins[clique] - begins[0]),
                Some(begin) => (&places_of_later[..], begin),
            };
            for &row in test_nodes {
                let places = &places[next..next + trial_nodes.len()];
                next += trial_nodes.len();
                let ends = pointers.get((row as usize).wrapping_sub(rows.start)..).unwrap_or_default();
                let &[start, end, ..] = ends else { continue };
                let of_row = &mut columns[start..end];
                for (place, &column) in places.iter().zip(trial_nodes) {
                    of_row[place.index()] = column;
                }
            }
        }
        Some(MadeRows { pointers, columns, later: near.later, places_of_later })
    }
}

/// The cliques that may have nodes among some rows: a thread's own, then others of later ones and without a map.
struct NearbyElements<'a> {
    cliques: &'a ElementNodes<'a>,
    own: Range<usize>,
    later: Vec<u32>,
    /// Starts of the places of the later ones, and their end.
    later_begins: Vec<usize>,
}

impl<'a> NearbyElements<'a> {
    fn new(cliques: &'a ElementNodes<'a>, rows: &Range<usize>, own: Range<usize>) -> Self {
        let (mut later, mut later_begins, mut begin) = (vec![], vec![0], 0);
        for clique in own.end..cliques.rows.len() {
            let nodes = cliques.rows[clique];
            if nodes.iter().any(|node| rows.contains(&(*node as usize))) {
                later.push(clique as u32);
                begin += nodes.len() * cliques.columns[clique].len();
                later_begins.push(begin);
            }
        }
        NearbyElements { cliques, own, later, later_begins }
    }

    fn count(&self) -> usize {
        self.own.len() + self.later.len()
    }

    /// Test and trial nodes of one of them.
    #[inline(always)]
    fn nodes(&self, clique: usize) -> (&'a [u32], &'a [u32]) {
        let own = self.own.len();
        let clique = if clique < own { self.own.start + clique } else { self.later[clique - own] as usize };
        (self.cliques.rows[clique], self.cliques.columns[clique])
    }

    /// The start of the places of one that is not the thread's own.
    #[inline(always)]
    fn later_place(&self, clique: usize) -> Option<usize> {
        clique.checked_sub(self.own.len()).map(|later| self.later_begins[later])
    }
}

/// The cliques around each column, with the column's place in them.
struct ElementsOfColumn {
    /// The end of each column's cliques.
    ends: Vec<usize>,
    members: Vec<(u32, u32)>,
}

impl ElementsOfColumn {
    fn new(near: &NearbyElements, column_nodes: usize) -> Self {
        let mut ends: Vec<usize> = zeros(column_nodes + 1);
        for clique in 0..near.count() {
            for &column in near.nodes(clique).1 {
                ends[column as usize + 1] += 1;
            }
        }
        for column in 0..column_nodes {
            ends[column + 1] += ends[column];
        }
        let mut members: Vec<(u32, u32)> = zeros(ends[column_nodes]);
        for clique in 0..near.count() {
            for (j, &column) in near.nodes(clique).1.iter().enumerate() {
                let next = &mut ends[column as usize];
                members[*next] = (clique as u32, j as u32);
                *next += 1;
            }
        }
        // Each start has moved to where the cliques of its column end.
        ends.pop();
        ElementsOfColumn { ends, members }
    }
}
