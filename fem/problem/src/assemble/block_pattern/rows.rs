//! Rows of blocks from cliques, made one by one: the columns of all cliques around a node, each once, in ascending order; and,
//! while they are at hand, the places of these columns for the cliques whose places are kept.
//!
//! No step has a branch that depends on the numbers: what mispredicted ones take is more than what is computed.

// Closures and iterator adaptors do not inherit a caller's target features: loops that are to be vectorised are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::block_index::Slot;
use super::short_rows::{LONGEST, ShortRow};
use super::sparsity::Cliques;
use crate::lanes::{LaneWork, SimdLane};
use crate::linear_algebra::large_pages::{room, zeros};

/// The rows that a thread makes, and where it may write places.
pub(super) struct RowsOfThread<'a, 'p, P> {
    pub cliques: &'a Cliques<'a>,
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

/// Rows, and places in cliques of other threads.
pub(super) struct MadeRows<P> {
    /// End of each row's columns.
    pub ends: Vec<usize>,
    pub columns: Vec<u32>,
    /// Start and number of the places for each row of a clique that is another thread's, with the places.
    pub elsewhere: Vec<(usize, usize)>,
    pub places_elsewhere: Vec<P>,
}

/// The cliques of each of some row nodes, with the node's place in them.
struct Around {
    starts: Vec<usize>,
    members: Vec<(u32, u32)>,
}

impl Around {
    /// Cliques before the first have no node among the rows.
    fn new(cliques: &Cliques, first: usize, rows: &Range<usize>) -> Self {
        let mut starts: Vec<usize> = zeros(rows.len() + 1);
        let within = |node: u32| (node as usize).wrapping_sub(rows.start);
        for &node in cliques.rows[first..].iter().flat_map(|nodes| *nodes) {
            if let Some(next) = starts[1..].get_mut(within(node)) {
                *next += 1;
            }
        }
        for node in 0..rows.len() {
            starts[node + 1] += starts[node];
        }
        let mut members: Vec<(u32, u32)> = zeros(starts[rows.len()]);
        let starts_of_rows = &mut starts[..rows.len()];
        for (clique, nodes) in cliques.rows.iter().enumerate().skip(first) {
            for (place, &node) in nodes.iter().enumerate() {
                if let Some(next) = starts_of_rows.get_mut(within(node)) {
                    members[*next] = (clique as u32, place as u32);
                    *next += 1;
                }
            }
        }
        Around { starts, members }
    }

    /// Those of the k-th row; each start has moved to its successor.
    #[inline(always)]
    fn row(&self, k: usize) -> &[(u32, u32)] {
        let start = if k == 0 { 0 } else { self.starts[k - 1] };
        &self.members[start..self.starts[k]]
    }
}

impl<P: Slot> LaneWork for RowsOfThread<'_, '_, P> {
    /// None if a row is too long for the places' type.
    type Output = Option<MadeRows<P>>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Option<MadeRows<P>> {
        let RowsOfThread { cliques, rows, own, begins, places, column_nodes } = self;
        let (first_place, mapped) = (begins[own.start], begins.len() - 1);
        let around = Around::new(cliques, own.start, &rows);
        let longest = cliques.columns[own.start..].iter().map(|columns| columns.len()).max().unwrap_or(0);
        let mut row = Row { columns: vec![], places: vec![], ranks: vec![], seen: zeros(column_nodes) };
        let mut short = ShortRow::default();
        // Room for all columns with their repetitions; what is not written to costs nothing.
        let sizes = cliques.rows.iter().zip(&cliques.columns).skip(own.start);
        let most: usize = sizes.map(|(rows, columns)| rows.len() * columns.len()).sum();
        let mut columns: Vec<u32> = zeros(most + LONGEST);
        let (mut ends, mut start) = (room(rows.len()), 0);
        let (mut elsewhere, mut places_elsewhere) = (vec![], vec![]);
        for k in 0..rows.len() {
            let (around, node) = (around.row(k), (rows.start + k) as u32);
            row.make_room(around.len() * longest);
            let gathered = short.gather(cliques, around, node);
            let count = match (gathered, columns[start..].first_chunk_mut()) {
                (Some(gathered), Some(sorted)) => short.sort(gathered, sorted, &mut row.places),
                _ => row.make(cliques, around, node, &mut columns[start..]),
            };
            if count > P::LONGEST_ROW {
                return None;
            }
            start += count;
            ends.push(start);
            let mut of_row = &row.places[..];
            for &(clique, i) in around {
                let (clique, i) = (clique as usize, i as usize);
                let width = cliques.columns[clique].len();
                let (of_clique, later) = of_row.split_at(width);
                of_row = later;
                if own.contains(&clique) {
                    let first = begins[clique] - first_place + i * width;
                    let places = &mut places[first..][..width];
                    for k in 0..width {
                        places[k] = P::new(of_clique[k]);
                    }
                } else if clique < mapped {
                    elsewhere.push((begins[clique] + i * width, width));
                    places_elsewhere.extend(of_clique.iter().map(|place| P::new(*place)));
                }
            }
        }
        columns.truncate(start);
        columns.shrink_to_fit();
        Some(MadeRows { ends, columns, elsewhere, places_elsewhere })
    }
}

/// A row that is being made.
struct Row {
    /// Its columns in the order in which they were met, each once; what stands behind them means nothing.
    columns: Vec<u32>,
    /// Of each column of each clique around the node, its slot among `columns`, and in the end its place in the row.
    places: Vec<u32>,
    /// Of each slot, the column's place in ascending order.
    ranks: Vec<u32>,
    /// Of each column node, the last row that has it, counted from one, in the upper half, and its slot there.
    seen: Vec<u64>,
}

impl Row {
    /// The longest rows whose columns are sorted by counting.
    const COUNTED: usize = 128;

    fn make_room(&mut self, columns: usize) {
        if self.places.len() < columns || self.columns.is_empty() {
            self.places.resize(2 * columns, 0);
            self.columns.resize(2 * columns + Row::COUNTED, 0);
            self.ranks.resize(2 * columns + Row::COUNTED, 0);
        }
    }

    /// Writes the columns of the cliques around a node, ascending, and gives their number.
    #[inline(always)]
    fn make(&mut self, cliques: &Cliques, around: &[(u32, u32)], node: u32, sorted: &mut [u32]) -> usize {
        let count = self.gather(cliques, around, node);
        self.sort(count, sorted);
        let met = around.iter().map(|(clique, _)| cliques.columns[*clique as usize].len()).sum();
        for place in &mut self.places[..met] {
            *place = self.ranks[*place as usize];
        }
        count
    }

    /// Collects the columns of the cliques around a node; gives their number.
    #[inline(never)]
    fn gather(&mut self, cliques: &Cliques, around: &[(u32, u32)], node: u32) -> usize {
        let (row, seen) = (&mut self.columns[..], &mut self.seen[..]);
        let mut slots = &mut self.places[..];
        let mark = (u64::from(node) + 1) << 32;
        let mut count = 0;
        for &(clique, _) in around {
            let columns = cliques.columns[clique as usize];
            let (of_clique, later) = slots.split_at_mut(columns.len());
            slots = later;
            for k in 0..columns.len() {
                let last = &mut seen[columns[k] as usize];
                // Each is written behind the row, which grows only by those that are new.
                row[count] = columns[k];
                let new = (*last ^ mark) >> 32 != 0;
                *last = if new { mark | count as u64 } else { *last };
                of_clique[k] = *last as u32;
                count += usize::from(new);
            }
        }
        count
    }

    /// Sorts the columns and notes their ranks.
    #[inline(always)]
    fn sort(&mut self, count: usize, sorted: &mut [u32]) {
        match count {
            0..=32 => self.count_smaller::<32>(count, sorted),
            33..=64 => self.count_smaller::<64>(count, sorted),
            65..=Row::COUNTED => self.count_smaller::<{ Row::COUNTED }>(count, sorted),
            _ => self.sort_long(count, sorted),
        }
    }

    /// Sorts at most LENGTH columns: the place of each is how many are smaller. That is many comparisons, but several at a time.
    #[inline(always)]
    fn count_smaller<const LENGTH: usize>(&mut self, count: usize, sorted: &mut [u32]) {
        let columns = &self.columns[..LENGTH];
        // Machines compare numbers with signs in fewer instructions.
        let mut signed = [0_i32; LENGTH];
        for k in 0..LENGTH {
            signed[k] = (columns[k] ^ 1 << 31) as i32;
        }
        let mut ranks = [0_u32; LENGTH];
        for k in 0..count {
            let column = signed[k];
            // What stands behind the columns gets a rank, too, which nothing reads.
            for other in 0..LENGTH {
                ranks[other] += u32::from(column < signed[other]);
            }
        }
        for k in 0..count {
            sorted[ranks[k] as usize] = columns[k];
        }
        self.ranks[..LENGTH].copy_from_slice(&ranks);
    }

    #[inline(never)]
    fn sort_long(&mut self, count: usize, sorted: &mut [u32]) {
        let with_slot = |(slot, column): (usize, &u32)| u64::from(*column) << 32 | slot as u64;
        let mut keys: Vec<u64> = self.columns[..count].iter().enumerate().map(with_slot).collect();
        keys.sort_unstable();
        for (rank, key) in keys.into_iter().enumerate() {
            sorted[rank] = (key >> 32) as u32;
            self.ranks[key as u32 as usize] = rank as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_every_length_are_sorted() {
        for length in 0..200_usize {
            let columns: Vec<u32> =
                (0..length as u32).map(|k| (k * 7_919 % 65_521).wrapping_sub(30_000)).collect();
            let mut expected = columns.clone();
            expected.sort_unstable();
            let mut row = Row { columns: vec![], places: vec![], ranks: vec![], seen: vec![] };
            row.make_room(length);
            row.columns.fill(7);
            row.columns[..length].copy_from_slice(&columns);
            let mut sorted = vec![0; length];
            row.sort(length, &mut sorted);
            assert_eq!(sorted, expected);
            for (slot, column) in columns.iter().enumerate() {
                assert_eq!(sorted[row.ranks[slot] as usize], *column);
            }
        }
    }
}
