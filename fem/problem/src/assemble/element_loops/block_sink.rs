//! Takers of the blocks of pairs of nodes.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use super::reference_tensor::Coefficient;
use crate::lanes::SimdLane;

/// Taker of the blocks of an element matrix, one by one as they are finished.
pub(in crate::assemble) trait BlockSink<L> {
    /// The block of a pair of nodes, row-major. Pairs are numbered row by row, of symmetric matrices those with i ≤ j.
    fn put(&mut self, number: usize, block: &[L]);
    /// The blocks of successive pairs, of `entries` numbers each.
    #[inline(always)]
    fn put_run<B: AsRef<[L]>, const COUNT: usize>(
        &mut self,
        number: usize,
        blocks: &[B; COUNT],
        entries: usize,
    ) {
        for k in 0..COUNT {
            self.put(number + k, &blocks[k].as_ref()[..entries]);
        }
    }
    /// The numbers of all pairs where a block is a number: sums of some products with coefficients.
    fn put_sums<C: Coefficient<L>, const PRODUCTS: usize>(
        &mut self,
        products: &[L; PRODUCTS],
        coefficients: &[[C; PRODUCTS]],
    );
}

/// Σ product × coefficient.
#[inline(always)]
pub(in crate::assemble) fn sum<L: SimdLane, C: Coefficient<L>, const PRODUCTS: usize>(
    products: &[L; PRODUCTS],
    coefficients: &[C; PRODUCTS],
) -> L {
    let mut sum = products[0] * coefficients[0].lanes();
    for product in 1..PRODUCTS {
        sum = products[product].multiply_add(coefficients[product].lanes(), sum);
    }
    sum
}

/// Blocks one after the other.
impl<L: SimdLane> BlockSink<L> for [L] {
    #[inline(always)]
    fn put(&mut self, number: usize, block: &[L]) {
        let target = &mut self[number * block.len()..][..block.len()];
        for entry in 0..block.len() {
            target[entry] = block[entry];
        }
    }
    #[inline(always)]
    fn put_run<B: AsRef<[L]>, const COUNT: usize>(
        &mut self,
        number: usize,
        blocks: &[B; COUNT],
        entries: usize,
    ) {
        let target = &mut self[number * entries..][..COUNT * entries];
        for k in 0..COUNT {
            let block = &blocks[k].as_ref()[..entries];
            for entry in 0..entries {
                target[k * entries + entry] = block[entry];
            }
        }
    }
    #[inline(always)]
    fn put_sums<C: Coefficient<L>, const PRODUCTS: usize>(
        &mut self,
        products: &[L; PRODUCTS],
        coefficients: &[[C; PRODUCTS]],
    ) {
        let target = &mut self[..coefficients.len()];
        for pair in 0..coefficients.len() {
            target[pair] = sum(products, &coefficients[pair]);
        }
    }
}
