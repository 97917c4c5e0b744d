//! Limits of the search for opposite points.

/// A point this far outside a facet, in its own coordinates, still belongs to it.
pub(super) const INSIDE: f64 = 1e-8;

/// A point of a piece that was cut for a facet belongs to it this far outside.
pub(super) const CONTINUED: f64 = 0.25;

/// Steps of Newton's method, at most.
pub(super) const STEPS: usize = 40;
