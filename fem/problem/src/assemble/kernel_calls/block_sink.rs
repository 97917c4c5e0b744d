//! Takers of the blocks of pairs of nodes.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

/// Taker of the blocks of an element matrix, one by one as they are finished.
pub(in crate::assemble) trait BlockSink<L> {
    /// The block of a pair of nodes, row-major. Pairs are numbered row by row, of symmetric matrices those with i ≤ j.
    fn put(&mut self, number: usize, block: &[L]);
    /// Room for the blocks of all pairs where a block is a number.
    fn numbers(&mut self) -> &mut [L];
}

/// Blocks one after the other.
impl<L: Copy> BlockSink<L> for [L] {
    #[inline(always)]
    fn put(&mut self, number: usize, block: &[L]) {
        let target = &mut self[number * block.len()..][..block.len()];
        for entry in 0..block.len() {
            target[entry] = block[entry];
        }
    }
    #[inline(always)]
    fn numbers(&mut self) -> &mut [L] {
        self
    }
}
