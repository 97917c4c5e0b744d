//! Lagrange elements: nodes, and tables of basis functions at given points.

use super::CellShape;

/// The Lagrange element of a degree on a reference cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lagrange {
    /// Reference cell.
    pub shape: CellShape,
    /// Polynomial degree, 1 or 2.
    pub degree: usize,
}

/// Basis functions and their reference gradients at a list of points.
#[derive(Clone, Debug)]
pub struct Tables<const D: usize> {
    /// Number of nodes N.
    pub nodes: usize,
    /// Number of points Q.
    pub points: usize,
    /// φ_i(x_q) at `q * nodes + i`.
    pub value: Vec<f64>,
    /// ∇φ_i(x_q) in reference coordinates, at `q * nodes + i`.
    pub gradient: Vec<[f64; D]>,
}
