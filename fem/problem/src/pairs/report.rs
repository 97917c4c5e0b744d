//! The numbers of a pairing's points.

use super::found::Counts;

/// Numbers of a pairing's points: `assembler.pairs(&pairing, degree)`, or at an iterate `assembler.pairs_at`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairReport<const D: usize> {
    /// Quadrature points with an opposite point.
    pub points: usize,
    /// Quadrature points without one. Parts of facets that face nothing get no points with
    /// [`PairQuadrature::Pieces`](forms_core::contract::PairQuadrature::Pieces); compare `paired_measure` with `measure`.
    pub open: usize,
    /// Those of them for which a facet was found, but from behind or further away than the reach.
    pub rejected: usize,
    /// The largest −g, zero where nothing overlaps \[length\].
    pub deepest_overlap: f64,
    /// The point where it is; none where nothing overlaps.
    pub deepest_at: Option<[f64; D]>,
    /// The largest g, zero where there is none \[length\].
    pub largest_gap: f64,
    /// The measure of what has opposite points \[length^(D−1)\].
    pub paired_measure: f64,
    /// The measure of the surfaces that are integrated over \[length^(D−1)\]; of whole facets by the rule of their points.
    pub measure: f64,
    /// The moving segments; zero on whole facets and fixed pairs.
    pub segments: usize,
    /// The parts of facets between cuts that see no opposite facet, and have no points.
    pub dropped_parts: usize,
}

impl<const D: usize> PairReport<D> {
    pub(super) fn of(counts: &Counts<D>) -> Self {
        PairReport {
            points: counts.points,
            open: counts.open,
            rejected: counts.rejected,
            deepest_overlap: counts.deepest,
            deepest_at: counts.deepest_at,
            largest_gap: counts.largest,
            paired_measure: counts.paired,
            measure: counts.measure,
            segments: counts.segments,
            dropped_parts: counts.dropped,
        }
    }
}
