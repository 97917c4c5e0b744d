//! The rows that a thread adds to, and what it keeps for the rows of others.

use std::ops::Range;

use super::block_positions::CopiedPlaces;
use crate::assemble::block_pattern::block_index::Slot;

/// Contributions to rows that belong to another thread: rows of element matrices or vectors.
#[derive(Default)]
pub(in crate::assemble) struct Deferred {
    pub rows: Vec<u32>,
    pub places: Vec<u32>,
    pub values: Vec<f64>,
}

impl Deferred {
    /// Blocks of a row, kept at their places.
    #[inline(never)]
    pub fn keep<P: Slot>(&mut self, row: u32, places: &[P], blocks: &[f64]) {
        self.rows.push(row);
        self.places.extend(places.iter().map(|place| place.index() as u32));
        self.values.extend_from_slice(blocks);
    }
}

/// The rows that a thread adds to.
pub(in crate::assemble) struct OwnRows<'a> {
    pub rows: Range<usize>,
    /// All entries of these rows.
    pub values: &'a mut [f64],
    /// Of each row whether its values are known to be zero; empty where that is known of none, and for vectors.
    pub zeros: &'a mut [bool],
    /// Rows before this one have values; those from it on are still to be set to zero.
    pub written: usize,
    /// Whether entities add to most of the rows, and new memory is handed over before they do.
    pub is_dense: bool,
    /// Places of blocks that were copied ahead of the matrices.
    pub known: CopiedPlaces,
    pub deferred: Deferred,
}

impl OwnRows<'_> {
    /// Contributions to other threads' rows.
    pub fn into_deferred(self) -> Deferred {
        self.deferred
    }
}
