//! The graph of blocks of a symmetric pattern.

use std::ops::Range;

use super::error::LinearAlgebraError;
use super::pattern::SparsityPattern;
use super::threads::Threads;

/// Blocks of consecutive unknowns whose rows have the same pattern, and which of them are coupled. Rows of the graph
/// are ascending and hold the block itself.
#[derive(Clone, Debug)]
pub(super) struct BlockGraph {
    /// First unknown of each block, and the number of unknowns at the end.
    pub(super) begins: Vec<usize>,
    /// Starts of each block's neighbours.
    pub(super) pointers: Vec<u32>,
    pub(super) neighbours: Vec<u32>,
}

impl BlockGraph {
    /// The graph, the same on any number of threads.
    pub(super) fn new(threads: Threads, pattern: &SparsityPattern) -> Result<Self, LinearAlgebraError> {
        let size = pattern.rows();
        let parts = threads.for_work(pattern.entries());
        let is_first = |row: &usize| *row == 0 || pattern.row(*row) != pattern.row(*row - 1);
        let begins = threads.run(pieces(size, parts), |rows| rows.filter(is_first).collect::<Vec<usize>>());
        let mut begins = begins.concat();
        begins.push(size);
        let blocks = begins.len() - 1;
        let mut block_of = vec![0_u32; pattern.columns()];
        for block in 0..blocks {
            block_of[begins[block]..begins[block + 1]].fill(block as u32);
        }
        // The neighbours of some blocks, and where those of each end.
        let found = threads.run(pieces(blocks, parts), |blocks| {
            let (mut ends, mut neighbours) = (Vec::with_capacity(blocks.len()), Vec::<u32>::new());
            for &begin in &begins[blocks] {
                let first = neighbours.len();
                for &column in pattern.row(begin) {
                    let block = block_of[column as usize];
                    // Columns ascend, and so do their blocks: a repeated block repeats at once.
                    if neighbours.len() == first || neighbours.last() != Some(&block) {
                        neighbours.push(block);
                    }
                }
                ends.push(neighbours.len());
            }
            (ends, neighbours)
        });
        let mut pointers = Vec::with_capacity(blocks + 1);
        pointers.push(0_u32);
        let mut before = 0;
        for (ends, neighbours) in &found {
            if u32::try_from(before + neighbours.len()).is_err() {
                return Err(LinearAlgebraError::TooLarge { what: "the graph to order" });
            }
            pointers.extend(ends.iter().map(|end| (before + end) as u32));
            before += neighbours.len();
        }
        let mut lists = found.into_iter().map(|(_, neighbours)| neighbours);
        let mut neighbours = lists.next().unwrap_or_default();
        lists.for_each(|others| neighbours.extend(others));
        Ok(BlockGraph { begins, pointers, neighbours })
    }

    /// The graph of some blocks, ascending, with numbers of their own.
    pub(super) fn restricted(&self, kept: &[u32]) -> Self {
        let mut new = vec![u32::MAX; self.blocks()];
        for (number, &block) in kept.iter().enumerate() {
            new[block as usize] = number as u32;
        }
        let (mut begins, mut pointers, mut neighbours) = (vec![0], vec![0_u32], Vec::new());
        for &block in kept {
            let near = self.row(block as usize).iter().map(|other| new[*other as usize]);
            neighbours.extend(near.filter(|other| *other != u32::MAX));
            // At most as many as in the whole graph, which have been counted.
            pointers.push(neighbours.len() as u32);
            begins.push(begins[begins.len() - 1] + self.size(block as usize));
        }
        BlockGraph { begins, pointers, neighbours }
    }

    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.pointers.len() - 1
    }

    /// Number of unknowns of a block.
    pub(super) fn size(&self, block: usize) -> usize {
        self.begins[block + 1] - self.begins[block]
    }

    /// Blocks that are coupled with a block.
    pub(super) fn row(&self, block: usize) -> &[u32] {
        &self.neighbours[self.pointers[block] as usize..self.pointers[block + 1] as usize]
    }

    /// Whether the pattern that it is the graph of is symmetric: the graph is, and each of its couplings is of whole blocks.
    pub(super) fn is_of_symmetric(&self, pattern: &SparsityPattern) -> bool {
        let mut entries = 0;
        // Rows come in ascending order, so the partner of (i, j) is the next unvisited entry of row j.
        let mut next = self.pointers.clone();
        for block in 0..self.blocks() {
            for &other in self.row(block) {
                let other = other as usize;
                let partner = next[other] as usize;
                if partner >= self.pointers[other + 1] as usize || self.neighbours[partner] as usize != block
                {
                    return false;
                }
                next[other] += 1;
                entries += self.size(block) * self.size(other);
            }
        }
        entries == pattern.entries()
    }

    /// Whether the row of each unknown has the pattern of the row before it.
    pub(super) fn likeness(&self) -> Vec<bool> {
        let mut likeness = vec![true; self.begins[self.blocks()]];
        self.begins[..self.blocks()].iter().for_each(|begin| likeness[*begin] = false);
        likeness
    }

    /// The unknowns of blocks in some order.
    pub(super) fn unknowns_in(&self, order: &[u32]) -> Vec<u32> {
        order
            .iter()
            .flat_map(|&block| self.begins[block as usize] as u32..self.begins[block as usize + 1] as u32)
            .collect()
    }
}

/// Ranges of nearly equal length of the numbers below a count.
fn pieces(count: usize, parts: usize) -> Vec<Range<usize>> {
    let length = count.div_ceil(parts).max(1);
    (0..count).step_by(length).map(|first| first..count.min(first + length)).collect()
}
