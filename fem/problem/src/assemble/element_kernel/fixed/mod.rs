//! Element kernels whose loops are compiled for one element, one rule and one geometry map: the quickest way
//! through one batch of cells. Each integral is prepared once, with its kernel, tables and memory for one instruction set;
//! nothing is looked up or checked per call but the lengths of the caller's lists.

mod batch;
mod by_moments;
mod field_buffers;
mod fields;
mod in_place;
mod matrices;
mod tables;
mod vectors;

pub(in crate::assemble) use matrices::PrepareMatrices;
pub(in crate::assemble) use tables::{FixedTables, fits};
pub(in crate::assemble) use vectors::PrepareVectors;

use super::ElementCells;
use crate::lanes::{Ordered, SimdLane};

/// An integral with all that its loops need, for one lane type.
pub(in crate::assemble) trait FixedIntegral: Send {
    /// Computes the results of the cells and writes them to `target`, one after the other, or adds them to what is there.
    ///
    /// # Panics
    /// When a list is too short.
    fn run(&mut self, cells: &ElementCells, target: &mut [f64], add: bool);
}

/// A call of an integral, to be run in the functions that are compiled for its lanes.
struct Call<'a, T> {
    integral: &'a mut T,
    cells: &'a ElementCells<'a>,
    target: &'a mut [f64],
    add: bool,
}

/// Writes results of `size` numbers each, or adds them to what is there.
#[inline(always)]
fn store<L: SimdLane>(source: Ordered<L>, size: usize, filled: usize, target: &mut [f64], add: bool) {
    if add {
        L::store_transposed::<true>(source, filled, target, size);
    } else {
        L::store_transposed::<false>(source, filled, target, size);
    }
}
