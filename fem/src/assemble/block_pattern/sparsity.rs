//! Sparsity from cliques: the blocks of sets of coupled nodes, and their slots in the rows.
//!
//! Row by row: the columns of all cliques around a node, each once, in ascending order; and, while they are at hand, the
//! places of these columns for the cells whose places are kept.

// Closures and iterator adaptors do not inherit a caller's target features: loops that are to be vectorised are plain.
#![allow(clippy::needless_range_loop)]

use super::block_index::{Slot, Slots};
use crate::lanes::{InstructionSet, LaneWork, SimdLane};
use crate::linear_algebra::BlockRows;

/// Sets of test and trial nodes that are all coupled with each other.
pub(in crate::assemble) struct Cliques<'a> {
    /// Test nodes, set after set.
    pub rows: Vec<&'a [u32]>,
    /// Trial nodes of each set.
    pub columns: Vec<&'a [u32]>,
}

/// The cliques of each row node, with the node's place in them.
struct Around {
    starts: Vec<usize>,
    members: Vec<(u32, u32)>,
}

impl Around {
    fn new(cliques: &Cliques, nodes: usize) -> Self {
        let mut starts = vec![0_usize; nodes + 1];
        for &node in cliques.rows.iter().flat_map(|nodes| *nodes) {
            starts[node as usize + 1] += 1;
        }
        for node in 0..nodes {
            starts[node + 1] += starts[node];
        }
        let mut members = vec![(0_u32, 0_u32); starts[nodes]];
        for (clique, nodes) in cliques.rows.iter().enumerate() {
            for (place, &node) in nodes.iter().enumerate() {
                let next = &mut starts[node as usize];
                members[*next] = (clique as u32, place as u32);
                *next += 1;
            }
        }
        Around { starts, members }
    }

    /// Each start has moved to its successor.
    #[inline(always)]
    fn node(&self, node: usize) -> &[(u32, u32)] {
        let start = if node == 0 { 0 } else { self.starts[node - 1] };
        &self.members[start..self.starts[node]]
    }
}

/// The blocks of the pairs in the cliques; and for the first `mapped` cliques the places of their pairs, clique after
/// clique.
pub(in crate::assemble) fn couple(
    cliques: &Cliques,
    (row_nodes, column_nodes): (usize, usize),
    mapped: usize,
) -> (BlockRows, Slots) {
    if cliques.rows.is_empty() {
        return (BlockRows::default(), Slots::new(0));
    }
    // Where the places of each clique begin.
    let mut begins = Vec::with_capacity(mapped + 1);
    begins.push(0);
    for (rows, columns) in cliques.rows.iter().zip(&cliques.columns).take(mapped) {
        begins.push(begins[begins.len() - 1] + rows.len() * columns.len());
    }
    let mut places = Slots::new(begins[mapped]);
    let mut pointers = Vec::with_capacity(row_nodes + 1);
    pointers.push(0);
    let mut rows = Rows {
        cliques,
        around: Around::new(cliques, row_nodes),
        begins,
        pointers,
        columns: vec![],
        seen: vec![(u32::MAX, 0); column_nodes],
    };
    let set = InstructionSet::best().checked();
    loop {
        let rows = &mut rows;
        let finished = match &mut places {
            Slots::Bytes(places) => set.run_without_kernel(Fill { rows, places }),
            Slots::Words(places) => set.run_without_kernel(Fill { rows, places }),
            Slots::Long(places) => set.run_without_kernel(Fill { rows, places }),
        };
        if finished {
            break;
        }
        places = places.widened();
    }
    let Rows { pointers, mut columns, .. } = rows;
    columns.shrink_to_fit();
    (BlockRows::new(pointers, columns), places)
}

/// The rows so far.
struct Rows<'a> {
    cliques: &'a Cliques<'a>,
    around: Around,
    /// Starts of the places of each clique that is mapped, and their end.
    begins: Vec<usize>,
    pointers: Vec<usize>,
    columns: Vec<u32>,
    /// Of each column node, the last row that has it, and its place there.
    seen: Vec<(u32, u32)>,
}

/// Makes rows to the last one, or to one that is too long for the places' type: whether all are made.
struct Fill<'r, 'a, P> {
    rows: &'r mut Rows<'a>,
    places: &'r mut [P],
}

impl<P: Slot> LaneWork for Fill<'_, '_, P> {
    type Output = bool;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> bool {
        let Fill { rows: Rows { cliques, around, begins, pointers, columns, seen }, places } = self;
        let (mapped, seen) = (begins.len() - 1, &mut seen[..]);
        let mut row = vec![0; 64];
        for node in pointers.len() - 1..around.starts.len() - 1 {
            let around = around.node(node);
            let mut count = 0;
            for &(clique, _) in around {
                let own = cliques.columns[clique as usize];
                if row.len() < count + own.len() {
                    row.resize(2 * (count + own.len()), 0);
                }
                // Each is written behind the row, which grows only by those that are new: no branch to mispredict.
                let behind = &mut row[count..][..own.len()];
                let mut new = 0;
                for k in 0..own.len() {
                    let last = &mut seen[own[k] as usize].0;
                    behind[new] = own[k];
                    new += usize::from(*last != node as u32);
                    *last = node as u32;
                }
                count += new;
            }
            if count > P::LONGEST_ROW {
                // No row has been seen: this one is made again.
                seen.fill((u32::MAX, 0));
                return false;
            }
            let start = columns.len();
            columns.resize(start + count, 0);
            sort(&mut row, count, &mut columns[start..], seen);
            for &(clique, i) in around {
                if (clique as usize) < mapped {
                    let columns = cliques.columns[clique as usize];
                    let first = begins[clique as usize] + i as usize * columns.len();
                    let places = &mut places[first..][..columns.len()];
                    for k in 0..columns.len() {
                        places[k] = P::new(seen[columns[k] as usize].1);
                    }
                }
            }
            pointers.push(start + count);
        }
        true
    }
}

/// Sorts the first `count` numbers, all different, and notes the place of each. There are 64 at least.
#[inline(always)]
fn sort(numbers: &mut [u32], count: usize, sorted: &mut [u32], places: &mut [(u32, u32)]) {
    match count {
        0..=16 => sort_by_rank::<16>(numbers, count, sorted, places),
        17..=32 => sort_by_rank::<32>(numbers, count, sorted, places),
        33..=64 => sort_by_rank::<64>(numbers, count, sorted, places),
        _ => {
            numbers[..count].sort_unstable();
            sorted.copy_from_slice(&numbers[..count]);
            for place in 0..count {
                places[sorted[place] as usize].1 = place as u32;
            }
        }
    }
}

/// Sorts at most LENGTH different numbers: the place of each is how many are smaller. That is many comparisons, but without
/// a branch to mispredict, and several at a time.
#[inline(always)]
fn sort_by_rank<const LENGTH: usize>(
    numbers: &[u32],
    count: usize,
    sorted: &mut [u32],
    places: &mut [(u32, u32)],
) {
    let numbers = &numbers[..LENGTH];
    let mut ranks = [0_u32; LENGTH];
    for k in 0..count {
        let number = numbers[k];
        // What stands behind the numbers gets a rank, too, which nothing reads.
        for other in 0..LENGTH {
            ranks[other] += u32::from(number < numbers[other]);
        }
    }
    for k in 0..count {
        sorted[ranks[k] as usize] = numbers[k];
        places[numbers[k] as usize].1 = ranks[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_every_length_are_sorted() {
        for length in 0..100_usize {
            let mut row: Vec<u32> = (0..length as u32).map(|k| k * 7_919 % 65_521).collect();
            let mut expected = row.clone();
            expected.sort_unstable();
            row.resize(length.max(64), 7);
            let (mut sorted, mut places) = (vec![0; length], vec![(0, u32::MAX); 65_521]);
            sort(&mut row, length, &mut sorted, &mut places);
            assert_eq!(sorted, expected);
            for (place, number) in expected.iter().enumerate() {
                assert_eq!(places[*number as usize].1 as usize, place);
            }
        }
    }

    #[test]
    fn places_widen_where_a_row_is_long() {
        // A chain of pairs, then a clique whose rows have 300 columns.
        let chain: Vec<[u32; 2]> = (0..400).map(|k| [k, k + 1]).collect();
        let wide: Vec<u32> = (50..350).rev().collect();
        let sets: Vec<&[u32]> = chain.iter().map(|pair| &pair[..]).chain([&wide[..]]).collect();
        let cliques = Cliques { rows: sets.clone(), columns: sets.clone() };
        let (blocks, places) = couple(&cliques, (401, 401), sets.len());
        let Slots::Words(places) = places else { panic!("300 columns need two bytes") };
        let mut start = 0;
        for set in &sets {
            for (i, row) in set.iter().enumerate() {
                for (j, column) in set.iter().enumerate() {
                    let place = usize::from(places[start + i * set.len() + j]);
                    assert_eq!(blocks.row(*row as usize)[place], *column);
                }
            }
            start += set.len() * set.len();
        }
        assert_eq!(blocks.row(0), [0, 1]);
        assert_eq!(blocks.row(50).len(), 301);
    }
}
