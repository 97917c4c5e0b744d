//! Blocks of equal rows in the cells that couple them.

use super::block_graph::BlockGraph;
use super::cells::Cells;

/// The blocks of cells, each once.
pub(super) struct CellBlocks<'a> {
    pub(super) centres: &'a [[f64; 3]],
    /// Starts of the cells' blocks, and their end.
    starts: Vec<usize>,
    blocks: Vec<u32>,
}

impl<'a> CellBlocks<'a> {
    /// The blocks of a graph in cells of its unknowns. Those that are left out are marked with [`u32::MAX`] in the list of
    /// the blocks' numbers.
    pub(super) fn new(cells: &'a Cells, graph: &BlockGraph, numbers: &[u32]) -> Self {
        let mut of_unknown = vec![u32::MAX; graph.begins[graph.blocks()]];
        for (ends, number) in graph.begins.windows(2).zip(numbers) {
            of_unknown[ends[0]..ends[1]].fill(*number);
        }
        let mut found = CellBlocks { centres: cells.centres(), starts: vec![0], blocks: vec![] };
        let mut own: Vec<u32> = vec![];
        for cell in 0..cells.count() {
            own.clear();
            for &unknown in cells.unknowns(cell) {
                let block = of_unknown[unknown as usize];
                if block != u32::MAX && own.last() != Some(&block) {
                    own.push(block);
                }
            }
            own.sort_unstable();
            own.dedup();
            found.blocks.extend_from_slice(&own);
            found.starts.push(found.blocks.len());
        }
        found
    }

    /// Number of cells.
    pub(super) fn count(&self) -> usize {
        self.centres.len()
    }

    /// Blocks of a cell, ascending.
    #[inline]
    pub(super) fn of(&self, cell: u32) -> &[u32] {
        &self.blocks[self.starts[cell as usize]..self.starts[cell as usize + 1]]
    }
}
