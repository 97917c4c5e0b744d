//! The triangles that a factorisation stores: L, or L and Uᵀ. Of both, each panel of a supernode has its columns of L first, then those of Uᵀ.

use super::dense::{Factor, FactorLu, run};
use super::pivots::{Pivots, Positive, Signed, Unpivoted};

/// Columns of a panel, of all triangles that are stored.
pub(in crate::cholesky) struct Columns<'a> {
    /// Place of the first column in the elimination order.
    pub(in crate::cholesky) place: usize,
    pub(in crate::cholesky) values: &'a mut [f64],
    pub(in crate::cholesky) height: usize,
    /// Row of the first column's diagonal.
    pub(in crate::cholesky) first: usize,
    /// End of the rows that are taken.
    pub(in crate::cholesky) end: usize,
}

/// The triangles of a factorisation by a rule for pivots.
pub(in crate::cholesky) trait Triangles: Pivots {
    /// Their number.
    const COUNT: usize = 1;

    /// Factors columns: their triangle on the diagonal and what is below it. An error is the first of the columns whose pivot is not taken.
    fn factor(self, columns: Columns<'_>) -> Result<(), usize> {
        let Columns { place, values, height, first, end } = columns;
        run(Factor { pivots: self, place, columns: values, height, first, end })
    }

    /// Columns of a triangle in a panel, and those of the triangle whose rows they are multiplied by.
    fn with_factors(panel: &[f64], triangle: usize) -> (&[f64], &[f64]) {
        let length = panel.len() / Self::COUNT;
        let part = |triangle: usize| &panel[triangle * length..][..length];
        (part(triangle), part(Self::COUNT - 1 - triangle))
    }
}

impl Triangles for Positive {}

impl Triangles for Signed<'_> {}

impl Triangles for Unpivoted {
    const COUNT: usize = 2;

    fn factor(self, columns: Columns<'_>) -> Result<(), usize> {
        let Columns { place, values, height, first, end } = columns;
        let (lower, upper) = values.split_at_mut(values.len() / 2);
        run(FactorLu { pivots: self, place, lower, upper, height, first, end })
    }
}
