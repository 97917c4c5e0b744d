//! Which pivots a factorisation takes, and the signs of columns that follow from them.
//!
//! A = L S Lᵀ with S = ±1. A column whose sign is negative has a negative number on the diagonal of L, and enters products with one
//! factor negated.

/// The rule for pivots of a factorisation.
pub(in crate::cholesky) trait Pivots: Copy + Sync {
    /// The sign of a column among those of some columns.
    fn sign(signs: &[f64], column: usize) -> f64;

    /// The entry of L on the diagonal from the pivot at a place of the elimination order; none if the pivot is not taken.
    fn diagonal(self, place: usize, pivot: f64) -> Option<f64>;

    /// The signs of factored columns, whose block begins with the row of the first one's diagonal, into memory for them.
    fn read_signs(block: &[f64], height: usize, signs: &mut Vec<f64>);
}

/// Of LLᵀ: all are positive.
#[derive(Clone, Copy)]
pub(in crate::cholesky) struct Positive;

impl Pivots for Positive {
    #[inline(always)]
    fn sign(_: &[f64], _: usize) -> f64 {
        1.0
    }

    #[inline(always)]
    fn diagonal(self, _: usize, pivot: f64) -> Option<f64> {
        (pivot > 0.0).then(|| pivot.sqrt())
    }

    fn read_signs(_: &[f64], _: usize, _: &mut Vec<f64>) {}
}

/// Of LSLᵀ: a pivot below its threshold is replaced.
#[derive(Clone, Copy)]
pub(in crate::cholesky) struct Signed<'a> {
    /// For each place what replaces a pivot that is smaller, with the sign that such a pivot gets.
    pub(in crate::cholesky) substitutes: &'a [f64],
}

impl Pivots for Signed<'_> {
    #[inline(always)]
    fn sign(signs: &[f64], column: usize) -> f64 {
        signs[column]
    }

    #[inline(always)]
    fn diagonal(self, place: usize, pivot: f64) -> Option<f64> {
        let substitute = self.substitutes[place];
        let taken = if pivot.abs() < substitute.abs() { substitute } else { pivot };
        let root = taken.abs().sqrt();
        (root > 0.0 && root.is_finite()).then(|| root.copysign(taken))
    }

    fn read_signs(block: &[f64], height: usize, signs: &mut Vec<f64>) {
        signs.clear();
        let columns = block.chunks(height).enumerate();
        signs.extend(columns.map(|(k, column)| 1.0_f64.copysign(column[k])));
    }
}

/// Of L U, with ones on the diagonal of L: all but zero.
#[derive(Clone, Copy)]
pub(in crate::cholesky) struct Unpivoted;

impl Pivots for Unpivoted {
    #[inline(always)]
    fn sign(_: &[f64], _: usize) -> f64 {
        1.0
    }

    #[inline(always)]
    fn diagonal(self, _: usize, pivot: f64) -> Option<f64> {
        (pivot != 0.0 && pivot.is_finite()).then_some(pivot)
    }

    fn read_signs(_: &[f64], _: usize, _: &mut Vec<f64>) {}
}
