//! Limits of the search for opposite points.

/// A point this far outside a facet, in its own coordinates, still belongs to it.
pub(super) const INSIDE: f64 = 1e-8;

/// Steps of Newton's method, at most.
pub(super) const STEPS: usize = 40;
