//! Element kernels whose loops are compiled for one element, one rule and one geometry map: the quickest way
//! through one batch of cells. Everything that a batch needs is in arrays of known lengths; nothing is looked
//! up or checked per batch but the lengths of the caller's lists.

mod batch;
mod matrices;
mod tables;
mod vectors;

pub(super) use matrices::FixedMatrices;
pub(super) use tables::{FixedTables, Listed, fits};
pub(super) use vectors::FixedVectors;

use super::sizes::Sizes;
use super::walk::Group;
use crate::lanes::{Ordered, SimdLane};

/// A kernel, a group and the cells to run it on.
pub(super) struct FixedTask<'a, K, S: Sizes, const D: usize> {
    pub kernel: &'a K,
    pub group: &'a Group<D>,
    pub tables: &'a FixedTables<S, D>,
    pub listed: Listed<'a>,
}

/// Writes results of `size` numbers each, or adds them to what is there.
#[inline(always)]
fn put_out<L: SimdLane>(source: &Ordered<L>, size: usize, filled: usize, target: &mut [f64], add: bool) {
    if add {
        L::store_transposed::<true>(source, filled, target, size);
    } else {
        L::store_transposed::<false>(source, filled, target, size);
    }
}
