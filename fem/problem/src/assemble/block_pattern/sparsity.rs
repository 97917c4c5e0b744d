//! Sparsity from cliques: the blocks of sets of coupled nodes, and their slots in the rows.
//!
//! Each thread makes a run of rows, those that its run of cliques touches first (as in `scatter/partition.rs`), and writes the places
//! for its cliques. Places that it finds for cliques of later threads are written afterwards. A row does not depend on who makes it.

use std::ops::Range;

use super::block_index::{Slot, Slots};
use super::element_nodes::ElementNodes;
use super::rows::{MadeRows, RowsOfThread};
use crate::assemble::scatter::partition::Partition;
use crate::linear_algebra::BlockRows;
use crate::linear_algebra::large_pages::zeros;
use crate::threads::Threads;

/// The blocks of the pairs in the cliques; and for the first `mapped` cliques the places of their pairs, clique after
/// clique.
pub(in crate::assemble) fn couple(
    cliques: &ElementNodes,
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
    cliques: &'a ElementNodes<'a>,
    /// Starts of the places of each clique that is mapped, and their end.
    begins: Vec<usize>,
    /// Elements that are mapped, and rows, of each thread.
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
        let made = self.threads.run(parts, RowsOfThread::make);
        let made: Vec<MadeRows<P>> = made.into_iter().collect::<Option<_>>()?;
        let (mut pointers, mut columns) = (vec![], vec![]);
        for (made, rows) in made.into_iter().zip(&self.partition.rows) {
            let mut found = &made.places_of_later[..];
            for clique in made.later {
                let clique = clique as usize;
                let (nodes, width) = (cliques.rows[clique], cliques.columns[clique].len());
                let (of_clique, later) = found.split_at(nodes.len() * width);
                found = later;
                let Some(&start) = begins.get(clique).filter(|_| clique + 1 < begins.len()) else { continue };
                for (i, node) in nodes.iter().enumerate() {
                    if rows.contains(&(*node as usize)) {
                        let of_row = i * width..(i + 1) * width;
                        places[start..][of_row.clone()].copy_from_slice(&of_clique[of_row]);
                    }
                }
            }
            if pointers.is_empty() {
                (pointers, columns) = (made.pointers, made.columns);
            } else {
                let before = columns.len();
                pointers.extend(made.pointers[1..].iter().map(|end| before + end));
                columns.extend_from_slice(&made.columns);
            }
        }
        Some((BlockRows::new(pointers, columns), places))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// A chain of pairs, then a clique whose rows have 300 columns.
    fn chain_and_wide() -> (Vec<[u32; 2]>, Vec<u32>) {
        ((0..2_000).map(|k| [k, k + 1]).collect(), (50..350).rev().collect())
    }

    #[test]
    fn places_widen_where_a_row_is_long() {
        let (chain, wide) = chain_and_wide();
        let sets: Vec<&[u32]> = chain.iter().map(|pair| &pair[..]).chain([&wide[..]]).collect();
        let cliques = ElementNodes { rows: sets.clone(), columns: sets.clone() };
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

    /// Sets of one to nine nodes out of a window that moves, some of them twice in a set; other trial than test nodes.
    fn scattered_sets(count: u32) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
        let mut state = 1_u32;
        let mut below = |end: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % end
        };
        let mut set = |clique: u32| {
            let nodes = 1 + below(9);
            (0..nodes).map(|_| clique + below(40)).collect::<Vec<u32>>()
        };
        (0..count).map(|clique| (set(clique), set(2 * clique + 1_000))).unzip()
    }

    #[test]
    fn rows_are_unions_of_sets_and_places_find_their_columns() {
        let (test_nodes, trial_nodes) = scattered_sets(2_000);
        let (rows, columns) = (test_nodes.iter().map(|set| &set[..]), trial_nodes.iter().map(|set| &set[..]));
        let cliques = ElementNodes { rows: rows.collect(), columns: columns.collect() };
        let mut expected = vec![BTreeSet::new(); 2_045];
        for (rows, columns) in cliques.rows.iter().zip(&cliques.columns) {
            rows.iter().for_each(|row| expected[*row as usize].extend(columns.iter().copied()));
        }
        for (threads, mapped) in [(1, 2_000), (3, 2_000), (1, 1_500), (3, 1_500)] {
            let (blocks, places) = couple(&cliques, (expected.len(), 5_045), mapped, Threads::new(threads));
            for (row, expected) in expected.iter().enumerate() {
                assert!(blocks.row(row).iter().eq(expected), "row {row}, {threads} threads, {mapped} mapped");
            }
            let Slots::Bytes(places) = places else { panic!("rows of some hundred columns need a byte") };
            let mut places = places.iter();
            for (rows, columns) in cliques.rows.iter().zip(&cliques.columns).take(mapped) {
                for row in *rows {
                    for (column, place) in columns.iter().zip(&mut places) {
                        assert_eq!(blocks.row(*row as usize)[usize::from(*place)], *column);
                    }
                }
            }
            assert_eq!(places.next(), None);
        }
    }

    #[test]
    fn threads_make_the_same_rows_and_places() {
        let (chain, wide) = chain_and_wide();
        // Rows and columns differ; the wide one comes first, in the middle, last among the mapped, and behind them.
        for position in [0, 700, 2_000] {
            let mut rows: Vec<&[u32]> = chain.iter().map(|pair| &pair[..]).collect();
            rows.insert(position, &wide);
            let columns: Vec<&[u32]> = rows.iter().map(|row| &row[1..]).collect();
            let cliques = ElementNodes { rows, columns };
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
