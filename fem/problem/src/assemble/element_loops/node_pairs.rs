//! The innermost loops of element matrices: sums over points for pairs of basis functions, from their factors.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::BilinearKernel;

use super::block_sink::BlockSink;
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
    /// The blocks of all pairs (i, j); of symmetric ones only i ≤ j.
    #[inline(always)]
    pub fn sum<S: BlockSink<L> + ?Sized>(&self, sink: &mut S) {
        match const { tile(numbers::<K, L, D>(), L::REGISTERS) } {
            44 => self.sweep::<S, 4, 4>(sink),
            24 => self.sweep::<S, 2, 4>(sink),
            14 => self.sweep::<S, 1, 4>(sink),
            12 => self.sweep::<S, 1, 2>(sink),
            21 => self.sweep::<S, 2, 1>(sink),
            _ => self.sweep::<S, 1, 1>(sink),
        }
    }

    /// All blocks, in tiles of ROWS × COLUMNS pairs, for some trial functions after the other: as many as the first cache keeps
    /// while the test functions pass by.
    #[inline(always)]
    fn sweep<S: BlockSink<L> + ?Sized, const ROWS: usize, const COLUMNS: usize>(&self, sink: &mut S) {
        let ([rows, columns], points) = (self.nodes, self.points);
        let fitting = KEPT / (points * size_of::<K::Trial<L>>()).max(1);
        let width = if fitting < columns { (fitting / COLUMNS).max(1) * COLUMNS } else { columns };
        let mut start = 0;
        while start < columns {
            let end = columns.min(start + width);
            let last = if self.symmetric { end } else { rows };
            // What is left of the factors: no place is computed per row.
            let (mut tests, mut trials) = (self.tests, &self.trials[start * points..end * points]);
            let (mut i, mut j) = (0, start);
            while i + ROWS <= last {
                let (own, others) = tests.split_at(ROWS * points);
                self.row::<S, ROWS, COLUMNS>(own, trials, [i, j], end, sink);
                (tests, i) = (others, i + ROWS);
                if self.symmetric && j < i {
                    (trials, j) = (&trials[(i - j) * points..], i);
                }
            }
            if const { ROWS > 1 } {
                while i < last {
                    let (own, others) = tests.split_at(points);
                    self.row::<S, 1, COLUMNS>(own, trials, [i, j], end, sink);
                    (tests, i) = (others, i + 1);
                    if self.symmetric && j < i {
                        (trials, j) = (&trials[points..], i);
                    }
                }
            }
            start = end;
        }
    }

    /// The blocks of ROWS test functions from i on and the trial functions from j on, with their factors.
    #[inline(always)]
    fn row<S: BlockSink<L> + ?Sized, const ROWS: usize, const COLUMNS: usize>(
        &self,
        own: &[K::Test<L>],
        mut trials: &[K::Trial<L>],
        [i, mut j]: [usize; 2],
        end: usize,
        sink: &mut S,
    ) {
        let (points, columns) = (self.points, self.nodes[1]);
        let (mut tests, mut before) = ([&own[..0]; ROWS], [0; ROWS]);
        for a in 0..ROWS {
            let i = i + a;
            tests[a] = &own[a * points..][..points];
            // Numbers of the pairs of a row begin here; below the diagonal a symmetric matrix has none.
            before[a] = if self.symmetric { i * columns - i * (i + 1) / 2 } else { i * columns };
        }
        while j + COLUMNS <= end {
            let (own, others) = trials.split_at(COLUMNS * points);
            self.tile::<S, ROWS, COLUMNS>(&tests, own, [i, j], &before, sink);
            (trials, j) = (others, j + COLUMNS);
        }
        if const { COLUMNS > 1 } {
            while j < end {
                let (own, others) = trials.split_at(points);
                self.tile::<S, ROWS, 1>(&tests, own, [i, j], &before, sink);
                (trials, j) = (others, j + 1);
            }
        }
    }

    #[inline(always)]
    fn tile<S: BlockSink<L> + ?Sized, const ROWS: usize, const COLUMNS: usize>(
        &self,
        tests: &[&[K::Test<L>]; ROWS],
        factors: &[K::Trial<L>],
        [i, j]: [usize; 2],
        before: &[usize; ROWS],
        sink: &mut S,
    ) {
        let entries = const { K::TEST_COMPONENTS * K::TRIAL_COMPONENTS };
        let mut accumulators = [[K::zero::<L>(); COLUMNS]; ROWS];
        let points = self.points;
        let mut trials = [factors; COLUMNS];
        for b in 0..COLUMNS {
            trials[b] = &factors[b * points..][..points];
        }
        for q in 0..points {
            for a in 0..ROWS {
                for b in 0..COLUMNS {
                    K::pair(&mut accumulators[a][b], &tests[a][q], &trials[b][q]);
                }
            }
        }
        if const { ROWS * COLUMNS == 1 && in_two_passes(numbers::<K, L, D>(), L::REGISTERS) } {
            // The first loop is for the first sums, this one for the others: what a loop adds to and nobody reads is not compiled.
            let mut others = K::zero::<L>();
            for q in 0..points {
                K::pair(&mut others, &tests[0][q], &trials[0][q]);
            }
            let (sums, others) = (accumulators[0][0].as_mut(), others.as_mut());
            for k in IN_FIRST_PASS..numbers::<K, L, D>() {
                sums[k] = others[k];
            }
        }
        for a in 0..ROWS {
            let mut blocks = [self.kernel.finish(self.cell, &accumulators[a][0]); COLUMNS];
            for b in 1..COLUMNS {
                blocks[b] = self.kernel.finish(self.cell, &accumulators[a][b]);
            }
            // Below the diagonal a symmetric matrix is mirrored: only tiles of several rows reach there.
            let below = if ROWS > 1 && self.symmetric { (i + a).saturating_sub(j) } else { 0 };
            if below == 0 {
                sink.put_run(before[a] + j, &blocks, entries);
                continue;
            }
            for b in below..COLUMNS {
                sink.put(before[a] + j + b, &blocks[b].as_ref()[..entries]);
            }
        }
    }
}

/// Sums of no products: a product and −0 are the product whatever it is, so that the first one takes no addition.
#[inline(always)]
pub(in crate::assemble) fn no_products<K: BilinearKernel<D>, L: SimdLane, const D: usize>()
-> K::Accumulator<L> {
    let mut sums = K::zero::<L>();
    let numbers = sums.as_mut();
    for k in 0..numbers.len() {
        numbers[k] = L::splat(-0.0);
    }
    sums
}

/// Numbers of a pair's sums.
const fn numbers<K: BilinearKernel<D>, L: SimdLane, const D: usize>() -> usize {
    size_of::<K::Accumulator<L>>() / size_of::<L>()
}

/// Sums of a pair in the first of two passes.
const IN_FIRST_PASS: usize = 9;

/// Whether the sums of a pair are made in two passes over the points: with their factors they would not fit into registers, and each
/// that passes through memory waits for itself at every point.
const fn in_two_passes(numbers: usize, registers: usize) -> bool {
    registers < 32 && numbers > 12 && numbers <= 2 * IN_FIRST_PASS
}

/// Rows and columns of a tile, as the two digits of a number: each factor that is loaded serves several pairs, as many as there are
/// registers for accumulators of that many numbers. One number, since rustc leaves out the arms that a constant does not take where
/// it is an integer; those of a tuple it compiles.
const fn tile(accumulators: usize, registers: usize) -> usize {
    match (accumulators, registers >= 32) {
        (0 | 1, true) => 44,
        (0 | 1, false) => 24,
        (2..=4, true) => 14,
        (2..=6, false) => 12,
        (5..=9, true) => 21,
        _ => 11,
    }
}
