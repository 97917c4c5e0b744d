//! Tangent as a problem lends it, and products with it.

use std::borrow::Cow;
use std::ops::Range;

use crate::linear_algebra::equations::Equations;
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

impl Tangent<'_> {
    /// K x, and Σ_j |K_ij x_j| of each row. Both are zero where x does not fit.
    pub fn products(&self, x: &[f64]) -> Products {
        let zero = || (vec![0.0; self.matrix.rows()], vec![0.0; self.matrix.rows()]);
        let (sums, sizes) = self.matrix.as_ref().products(x).unwrap_or_else(|_| zero());
        Products { sums, sizes }
    }
}

impl<'a> Tangent<'a> {
    /// A matrix that is lent, with no places known.
    pub(in crate::solve) fn lent(matrix: &'a BlockMatrix) -> Self {
        Tangent { matrix: Cow::Borrowed(matrix), changed: None }
    }
}

/// A product with a tangent, and the size of its terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Products {
    /// Σ_j K_ij x_j of each row.
    pub sums: Vec<f64>,
    /// Σ_j |K_ij x_j| of each row.
    pub sizes: Vec<f64>,
}

impl Products {
    /// Adds the products of another part of the matrix.
    pub(in crate::solve) fn add(&mut self, other: &Products) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| *sum += other);
        self.sizes.iter_mut().zip(&other.sizes).for_each(|(size, other)| *size += other);
    }
}

impl From<CsrMatrix> for Tangent<'_> {
    /// A tangent without further known properties.
    fn from(matrix: CsrMatrix) -> Self {
        Tangent { matrix: Cow::Owned(matrix.into()), changed: None }
    }
}
