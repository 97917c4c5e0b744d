//! The rows that a thread adds to, and what it keeps for the rows of others.

use std::ops::Range;

/// Contributions to rows that belong to another thread: rows of element matrices or vectors.
#[derive(Default)]
pub(in crate::assemble) struct Deferred {
    pub rows: Vec<u32>,
    pub places: Vec<u32>,
    pub values: Vec<f64>,
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
    pub deferred: Deferred,
}

impl OwnRows<'_> {
    /// Contributions to other threads' rows.
    pub fn into_deferred(self) -> Deferred {
        self.deferred
    }
}
