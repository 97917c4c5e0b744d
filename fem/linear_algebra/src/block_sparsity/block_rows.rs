//! The blocks between one set of nodes and another, in compressed rows.

use std::ops::Range;

use crate::error::{LinearAlgebraError, check_size};
use crate::threads::Threads;

/// Nodes with a number of components each, and where their unknowns start in a vector over several such sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeSet {
    /// Number of nodes.
    pub nodes: usize,
    /// Unknowns per node; those of a node follow each other.
    pub components: usize,
    /// The first unknown.
    pub offset: usize,
}

impl NodeSet {
    /// Sets of nodes one after the other, from their nodes and components.
    pub fn in_a_row(sizes: impl IntoIterator<Item = (usize, usize)>) -> Vec<NodeSet> {
        let mut offset = 0;
        let set = |(nodes, components)| {
            let set = NodeSet { nodes, components, offset };
            offset += nodes * components;
            set
        };
        sizes.into_iter().map(set).collect()
    }

    /// The unknowns.
    #[inline]
    pub fn unknowns(&self) -> Range<usize> {
        self.offset..self.offset + self.nodes * self.components
    }
}

/// The blocks of one pair of sets in compressed rows: row node i has the column nodes
/// `columns[pointers[i]..pointers[i + 1]]`, ascending. Without any blocks there are no pointers either.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlockRows {
    pub(super) pointers: Vec<usize>,
    pub(crate) columns: Vec<u32>,
    /// Place of the first value in the list of all values.
    pub(super) first_value: usize,
    /// Values per block.
    pub(super) block: usize,
}

impl BlockRows {
    /// Blocks at these places; `pointers` is empty or has one entry more than there are row nodes.
    pub fn new(pointers: Vec<usize>, columns: Vec<u32>) -> Self {
        BlockRows { pointers, columns, first_value: 0, block: 1 }
    }

    /// Number of blocks.
    #[inline]
    pub fn blocks(&self) -> usize {
        self.columns.len()
    }

    /// The place of each row node's first block in the list of this pair's blocks, and the number of blocks.
    #[doc(hidden)]
    #[inline]
    pub fn pointers(&self) -> &[usize] {
        &self.pointers
    }

    /// The places of a row node's blocks in the list of this pair's blocks.
    #[doc(hidden)]
    #[inline]
    pub fn range(&self, node: usize) -> Range<usize> {
        match self.pointers.get(node..node + 2) {
            Some(ends) => ends[0]..ends[1],
            None => 0..0,
        }
    }

    /// The row nodes in ranges with about equally many blocks.
    pub(crate) fn parts(&self, count: usize) -> Vec<Range<usize>> {
        let nodes = self.pointers.len().saturating_sub(1);
        let start = |part: usize| match part == count {
            true => nodes,
            false => self.pointers.partition_point(|first| *first < part * self.blocks() / count).min(nodes),
        };
        (0..count).map(|part| start(part)..start(part + 1)).collect()
    }

    /// Work on some threads on the values of row nodes, `block` numbers per block: each part gets its nodes and their values.
    #[doc(hidden)]
    pub fn on_threads(
        &self,
        threads: Threads,
        (values, block): (&mut [f64], usize),
        work: impl Fn(Range<usize>, &mut [f64]) + Send + Sync,
    ) {
        let ranges = self.parts(threads.for_work(values.len()));
        let mut rest = values;
        let parts = ranges.into_iter().filter(|nodes| !nodes.is_empty()).map(|nodes| {
            let blocks = self.pointers[nodes.end] - self.pointers[nodes.start];
            let (own, later) = std::mem::take(&mut rest).split_at_mut(blocks * block);
            rest = later;
            (nodes, own)
        });
        threads.run(parts.collect(), |(nodes, values)| work(nodes, values));
    }

    /// Column nodes of a row node.
    #[inline]
    pub fn row(&self, node: usize) -> &[u32] {
        &self.columns[self.range(node)]
    }

    /// The place of a block in the list of this pair's blocks, if there is one at this row and column node.
    #[doc(hidden)]
    #[inline]
    pub fn place(&self, row: usize, column: u32) -> Option<usize> {
        let range = self.range(row);
        Some(range.start + self.columns[range].binary_search(&column).ok()?)
    }

    /// The places of this pair's values in the list of all values.
    #[doc(hidden)]
    #[inline]
    pub fn values(&self) -> Range<usize> {
        self.first_value..self.first_value + self.columns.len() * self.block
    }

    pub(super) fn check(&self, rows: &NodeSet, columns: &NodeSet) -> Result<(), LinearAlgebraError> {
        if self.pointers.is_empty() {
            return check_size("the list of blocks without rows", 0, self.columns.len());
        }
        check_size("the list of block row pointers", rows.nodes + 1, self.pointers.len())?;
        check_size("the first block row pointer", 0, self.pointers[0])?;
        check_size("the list of blocks", self.pointers[rows.nodes], self.columns.len())?;
        for (node, ends) in self.pointers.windows(2).enumerate() {
            let not_ascending = |what, position| LinearAlgebraError::NotAscending { what, position };
            if ends[1] < ends[0] || ends[1] > self.columns.len() {
                return Err(not_ascending("the list of block row pointers", node + 1));
            }
            let row = &self.columns[ends[0]..ends[1]];
            if let Some(k) = (1..row.len()).find(|&k| row[k] <= row[k - 1]) {
                return Err(not_ascending("the column nodes of a row", ends[0] + k));
            }
            if let Some(&last) = row.last()
                && last as usize >= columns.nodes
            {
                let (what, index, size) = ("column node", last as usize, columns.nodes);
                return Err(LinearAlgebraError::IndexOutOfRange { what, index, size });
            }
        }
        Ok(())
    }
}
