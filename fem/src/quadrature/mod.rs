//! Quadrature rules on reference cells and facets.

/// Points and weights on a reference cell (or on a facet's own reference cell of dimension D − 1).
#[derive(Clone, Debug, PartialEq)]
pub struct QuadratureRule<const D: usize> {
    /// Points in reference coordinates.
    pub points: Vec<[f64; D]>,
    /// Weights; they sum to the reference cell's volume.
    pub weights: Vec<f64>,
}
