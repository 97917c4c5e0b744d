//! The innermost loops of element matrices: sums over points for pairs of basis functions, from their factors.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::BilinearKernel;

use crate::lanes::SimdLane;

/// Bytes of trial factors that stay in the first cache while others pass by: half of the 32 KB that the smaller ones hold.
const KEPT: usize = 16 << 10;

/// The sums over the points of a cell, pair by pair.
pub(in crate::assemble) struct NodePairs<'a, K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    pub kernel: &'a K,
    pub cell: &'a K::Cell<L>,
    /// Factors of node i at point q, at `i * points + q`.
    pub tests: &'a [K::Test<L>],
    pub trials: &'a [K::Trial<L>],
    pub nodes: [usize; 2],
    pub points: usize,
    /// Only pairs i ≤ j are computed.
    pub symmetric: bool,
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> NodePairs<'_, K, L, D> {
    /// The blocks of all pairs (i, j), one after the other; of symmetric ones only i ≤ j.
    #[inline(always)]
    pub fn sum(&self, blocks: &mut [L]) {
        match const { tile(size_of::<K::Accumulator<L>>() / size_of::<L>(), L::REGISTERS) } {
            44 => self.sweep::<4, 4>(blocks),
            24 => self.sweep::<2, 4>(blocks),
            14 => self.sweep::<1, 4>(blocks),
            12 => self.sweep::<1, 2>(blocks),
            21 => self.sweep::<2, 1>(blocks),
            _ => self.sweep::<1, 1>(blocks),
        }
    }

    /// All blocks, in tiles of ROWS × COLUMNS pairs, for some trial functions after the other: as many as the first cache keeps
    /// while the test functions pass by.
    #[inline(always)]
    fn sweep<const ROWS: usize, const COLUMNS: usize>(&self, blocks: &mut [L]) {
        let [rows, columns] = self.nodes;
        let fitting = KEPT / (self.points * size_of::<K::Trial<L>>()).max(1);
        let width = if fitting < columns { (fitting / COLUMNS).max(1) * COLUMNS } else { columns };
        let mut start = 0;
        while start < columns {
            let end = columns.min(start + width);
            let last = if self.symmetric { end } else { rows };
            let mut i = 0;
            while i + ROWS <= last {
                self.row::<ROWS, COLUMNS>(i, start, end, blocks);
                i += ROWS;
            }
            if const { ROWS > 1 } {
                while i < last {
                    self.row::<1, COLUMNS>(i, start, end, blocks);
                    i += 1;
                }
            }
            start = end;
        }
    }

    /// The blocks of ROWS test functions and the trial functions in a range.
    #[inline(always)]
    fn row<const ROWS: usize, const COLUMNS: usize>(
        &self,
        i: usize,
        start: usize,
        end: usize,
        blocks: &mut [L],
    ) {
        let mut j = if self.symmetric { start.max(i) } else { start };
        while j + COLUMNS <= end {
            self.tile::<ROWS, COLUMNS>(i, j, blocks);
            j += COLUMNS;
        }
        if const { COLUMNS > 1 } {
            while j < end {
                self.tile::<ROWS, 1>(i, j, blocks);
                j += 1;
            }
        }
    }

    #[inline(always)]
    fn tile<const ROWS: usize, const COLUMNS: usize>(&self, i: usize, j: usize, blocks: &mut [L]) {
        let columns = self.nodes[1];
        let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
        let mut accumulators = [[K::zero::<L>(); COLUMNS]; ROWS];
        let points = self.points;
        let (mut tests, mut trials) = ([&self.tests[..0]; ROWS], [&self.trials[..0]; COLUMNS]);
        for a in 0..ROWS {
            tests[a] = &self.tests[(i + a) * points..][..points];
        }
        for b in 0..COLUMNS {
            trials[b] = &self.trials[(j + b) * points..][..points];
        }
        for q in 0..points {
            for a in 0..ROWS {
                for b in 0..COLUMNS {
                    K::pair(&mut accumulators[a][b], &tests[a][q], &trials[b][q]);
                }
            }
        }
        for a in 0..ROWS {
            for b in 0..COLUMNS {
                let (i, j) = (i + a, j + b);
                // Below the diagonal a symmetric matrix is mirrored.
                if self.symmetric && j < i {
                    continue;
                }
                let before = if self.symmetric { i * columns - i * (i + 1) / 2 } else { i * columns };
                let block = self.kernel.finish(self.cell, &accumulators[a][b]);
                copy_block(block.as_ref(), &mut blocks[(before + j) * entries..][..entries]);
            }
        }
    }
}

/// Rows and columns of a tile, as the two digits of a number: each factor that is loaded serves several pairs, as many as there are
/// registers for accumulators of so many numbers. One number, since rustc leaves out the arms that a constant does not take where
/// it is an integer; those of a tuple it compiles.
const fn tile(accumulators: usize, registers: usize) -> usize {
    match (accumulators, registers >= 32) {
        (0 | 1, true) => 44,
        (0 | 1, false) => 24,
        (2..=4, true) => 14,
        (2..=4, false) => 12,
        (5..=9, true) => 21,
        _ => 11,
    }
}

/// Copies a block. Copying slices as such would be a call.
#[inline(always)]
fn copy_block<L: Copy>(block: &[L], target: &mut [L]) {
    let block = &block[..target.len()];
    for entry in 0..target.len() {
        target[entry] = block[entry];
    }
}
