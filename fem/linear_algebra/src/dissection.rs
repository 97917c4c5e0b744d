//! Nested dissection by places: cells are halved again and again, and what both halves have in common separates them.
//!
//! The halves of halves make a binary tree. A block of unknowns belongs to the smallest part that holds all of its cells, and
//! is eliminated after all that belongs to parts of that part. Couplings tie parts that lie one in the other: where one does
//! not, as across a contact, one of its two blocks moves up to the smallest part that holds both.

use super::block_graph::BlockGraph;
use super::cell_blocks::CellBlocks;
use super::threads::Threads;

mod axes;
mod halves;
mod smoothing;

use halves::Halves;

/// A part of the cells: 1 is all of them, 2 p and 2 p + 1 are the halves of p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part(u32);

impl Part {
    /// All cells.
    const ALL: Part = Part(1);
    /// Most halvings from all cells to a part.
    const DEEPEST: u32 = 30;

    fn halves(self) -> [Part; 2] {
        [Part(2 * self.0), Part(2 * self.0 + 1)]
    }

    fn depth(self) -> u32 {
        self.0.ilog2()
    }

    /// Whether one of the two lies in the other.
    #[inline]
    fn is_along(self, other: Part) -> bool {
        let (a, b) = (self.depth(), other.depth());
        match a < b {
            true => other.0 >> (b - a) == self.0,
            false => self.0 >> (a - b) == other.0,
        }
    }

    /// The smallest part that holds both.
    fn with(self, other: Part) -> Part {
        let depth = self.depth().min(other.depth());
        let (a, b) = (self.0 >> (self.depth() - depth), other.0 >> (other.depth() - depth));
        let apart = u32::BITS - (a ^ b).leading_zeros();
        Part(a >> apart)
    }

    /// Ascending where parts come before the parts that hold them, and lower halves before upper ones.
    fn rank(self) -> u64 {
        let below = Self::DEEPEST - self.depth();
        let end = (u64::from(self.0) + 1) << below;
        end << 8 | u64::from(below)
    }
}

/// The blocks of a graph in the order of their elimination.
pub(super) fn dissect(graph: &BlockGraph, cells: &CellBlocks, threads: Threads) -> Vec<u32> {
    let parts = parts_of_blocks(graph, cells, threads);
    let mut ranked: Vec<(u64, u32)> =
        parts.iter().zip(0..).map(|(part, block)| (part.rank(), block)).collect();
    ranked.sort_unstable();
    ranked.into_iter().map(|(_, block)| block).collect()
}

/// The part to which each block belongs, so that couplings tie parts that lie one in the other.
fn parts_of_blocks(graph: &BlockGraph, cells: &CellBlocks, threads: Threads) -> Vec<Part> {
    let mut found: Vec<Option<Part>> = vec![None; graph.blocks()];
    for (cell, part) in (0..).zip(Halves::of_all(cells, graph.blocks(), threads)) {
        for &block in cells.of(cell) {
            let known = &mut found[block as usize];
            *known = Some(known.map_or(part, |known| known.with(part)));
        }
    }
    // What is in no cell goes where its neighbours are: into the smallest of their parts if these lie one in the other.
    for block in 0..found.len() {
        if found[block].is_none() {
            let near = graph.row(block).iter().filter_map(|other| found[*other as usize]);
            let together = near.reduce(|one, other| match one.is_along(other) {
                true if one.depth() >= other.depth() => one,
                true => other,
                false => one.with(other),
            });
            found[block] = Some(together.unwrap_or(Part::ALL));
        }
    }
    let mut parts: Vec<Part> = found.into_iter().map(|part| part.unwrap_or(Part::ALL)).collect();
    // A block that moves up keeps all its connections.
    for block in 0..parts.len() {
        for &other in graph.row(block) {
            let (one, two) = (parts[block], parts[other as usize]);
            if !one.is_along(two) {
                let later = if one.rank() > two.rank() { block } else { other as usize };
                parts[later] = one.with(two);
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests;
