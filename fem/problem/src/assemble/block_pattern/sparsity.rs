//! Sparsity from cliques: the blocks of sets of coupled nodes, and their slots in the rows.
//!
//! Each thread makes a run of rows, those that its run of cliques touches first (as in `scatter/partition.rs`), and writes the places
//! for its cliques. Places that it finds for cliques of later threads are written afterwards. A row does not depend on who makes it.

use std::ops::Range;

use super::block_index::{Slot, Slots};
use super::rows::{MadeRows, RowsOfThread};
use crate::assemble::scatter::partition::Partition;
use crate::lanes::InstructionSet;
use crate::linear_algebra::BlockRows;
use crate::linear_algebra::large_pages::{room, zeros};
use crate::threads::Threads;

/// Sets of test and trial nodes that are all coupled with each other.
pub(in crate::assemble) struct Cliques<'a> {
    /// Test nodes, set after set.
    pub rows: Vec<&'a [u32]>,
    /// Trial nodes of each set.
    pub columns: Vec<&'a [u32]>,
}

/// The blocks of the pairs in the cliques; and for the first `mapped` cliques the places of their pairs, clique after
/// clique.
pub(in crate::assemble) fn couple(
    cliques: &Cliques,
    (row_nodes, column_nodes): (usize, usize),
    mapped: usize,
    threads: Threads,
) -> (BlockRows, Slots) {
    if cliques.rows.is_empty() {
        return (BlockRows::default(), Slots::Bytes(vec![]));
    }
    // Where the places of each clique begin.
    let mut begins = Vec::with_capacity(mapped + 1);
    begins.push(0);
    for (rows, columns) in cliques.rows.iter().zip(&cliques.columns).take(mapped) {
        begins.push(begins[begins.len() - 1] + rows.len() * columns.len());
    }
    let partition = Partition::new(mapped, threads, row_nodes, |clique| cliques.rows[clique]);
    let coupling = Coupling { cliques, begins, partition, column_nodes, threads };
    // Nearly always bytes suffice.
    if let Some((rows, places)) = coupling.make() {
        return (rows, Slots::Bytes(places));
    }
    if let Some((rows, places)) = coupling.make() {
        return (rows, Slots::Words(places));
    }
    let (rows, places) = coupling.make().unwrap_or_default();
    (rows, Slots::Long(places))
}

/// All that rows are made from.
struct Coupling<'a> {
    cliques: &'a Cliques<'a>,
    /// Starts of the places of each clique that is mapped, and their end.
    begins: Vec<usize>,
    /// Cliques that are mapped, and rows, of each thread.
    partition: Partition,
    column_nodes: usize,
    threads: Threads,
}

impl Coupling<'_> {
    /// Rows and places; none if a row is too long for the places' type, as none is for 32 bits.
    fn make<P: Slot + Default>(&self) -> Option<(BlockRows, Vec<P>)> {
        let (cliques, begins) = (self.cliques, &self.begins[..]);
        let mut places: Vec<P> = zeros(begins[begins.len() - 1]);
        let (mut rest, mut parts) = (&mut places[..], Vec::new());
        for (own, rows) in self.partition.entities.iter().zip(&self.partition.rows) {
            let (of_thread, later) = rest.split_at_mut(begins[own.end] - begins[own.start]);
            rest = later;
            let (own, rows): (Range<usize>, Range<usize>) = (own.clone(), rows.clone());
            let column_nodes = self.column_nodes;
            parts.push(RowsOfThread { cliques, rows, own, begins, places: of_thread, column_nodes });
        }
        let set = InstructionSet::best().checked();
        let made = self.threads.run(parts, |part| set.run_without_kernel(part));
        let made: Vec<MadeRows<P>> = made.into_iter().collect::<Option<_>>()?;
        let mut pointers = room(self.partition.rows.iter().map(Range::len).sum::<usize>() + 1);
        pointers.push(0);
        let mut columns: Vec<u32> = Vec::new();
        for MadeRows { ends, columns: of_thread, elsewhere, places_elsewhere } in made {
            let before = columns.len();
            pointers.extend(ends.into_iter().map(|end| before + end));
            if before == 0 {
                columns = of_thread;
            } else {
                columns.extend_from_slice(&of_thread);
            }
            let mut found = &places_elsewhere[..];
            for (start, count) in elsewhere {
                let (of_row, later) = found.split_at(count);
                places[start..start + count].copy_from_slice(of_row);
                found = later;
            }
        }
        columns.shrink_to_fit();
        Some((BlockRows::new(pointers, columns), places))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of pairs, then a clique whose rows have 300 columns.
    fn chain_and_wide() -> (Vec<[u32; 2]>, Vec<u32>) {
        ((0..2_000).map(|k| [k, k + 1]).collect(), (50..350).rev().collect())
    }

    #[test]
    fn places_widen_where_a_row_is_long() {
        let (chain, wide) = chain_and_wide();
        let sets: Vec<&[u32]> = chain.iter().map(|pair| &pair[..]).chain([&wide[..]]).collect();
        let cliques = Cliques { rows: sets.clone(), columns: sets.clone() };
        let (blocks, places) = couple(&cliques, (2_001, 2_001), sets.len(), Threads::ONE);
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

    #[test]
    fn threads_make_the_same_rows_and_places() {
        let (chain, wide) = chain_and_wide();
        // Rows and columns differ; the wide one comes first, in the middle, last among the mapped, and behind them.
        for position in [0, 700, 2_000] {
            let mut rows: Vec<&[u32]> = chain.iter().map(|pair| &pair[..]).collect();
            rows.insert(position, &wide);
            let columns: Vec<&[u32]> = rows.iter().map(|row| &row[1..]).collect();
            let cliques = Cliques { rows, columns };
            for mapped in [0, 900, 2_000, 2_001] {
                let (alone, places) = couple(&cliques, (2_005, 2_001), mapped, Threads::ONE);
                for threads in [2, 3, 5] {
                    let (found, known) = couple(&cliques, (2_005, 2_001), mapped, Threads::new(threads));
                    assert_eq!(found, alone);
                    assert!(known == places, "{mapped} mapped, {threads} threads, wide at {position}");
                }
            }
        }
    }
}
