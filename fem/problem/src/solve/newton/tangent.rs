//! Tangents as a problem lends them: the whole, or the nonlinear part alone.

use std::borrow::Cow;
use std::ops::Range;

#[cfg(doc)]
use super::NonlinearProblem;
use crate::linear_algebra::{BlockMatrix, CsrMatrix};

/// A tangent, lent by the problem that keeps it.
#[derive(Clone, Debug)]
pub struct Tangent<'a> {
    /// All rows and columns.
    pub matrix: Cow<'a, BlockMatrix>,
    /// Places among the matrix's values, as ascending ranges of whole blocks, outside those it is equal to the
    /// problem's linear part; none where the problem does not know them.
    pub changed: Option<&'a [Range<usize>]>,
}

/// The tangent of the nonlinear part alone, lent by the problem that keeps it.
#[derive(Clone, Copy, Debug)]
pub struct NonlinearTangent<'a> {
    /// All rows and columns.
    pub matrix: &'a BlockMatrix,
    /// The rows with entries, ascending.
    pub rows: &'a [usize],
    /// The unknowns that the nonlinear part reads at any iterate, ascending.
    pub reads: &'a [usize],
}

impl Tangent<'_> {
    /// Σ_j |K_ij| a_j for each row i.
    pub fn balancing_forces(&self, amplitudes: &[f64]) -> Vec<f64> {
        let force = |row| self.matrix.row(row).map(|(column, k)| k.abs() * amplitudes[column]).sum();
        (0..self.matrix.rows()).map(force).collect()
    }
}

impl From<CsrMatrix> for Tangent<'_> {
    /// A tangent without further known properties.
    fn from(matrix: CsrMatrix) -> Self {
        Tangent { matrix: Cow::Owned(matrix.into()), changed: None }
    }
}
