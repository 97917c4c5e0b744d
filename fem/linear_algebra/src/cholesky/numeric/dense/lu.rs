//! The factorisation L U of a dense block without exchanges of rows, a few columns of L and rows of U at once in registers.

use faer::traits::pulp::{Simd, WithSimd};

use super::{COLUMNS, Rows, Solve};
use crate::cholesky::numeric::pivots::Pivots;

/// Factors a square on the diagonal, with what is below it in L and in Uᵀ. L has ones on its diagonal. An error is the first of the
/// columns whose pivot is not taken.
pub(in crate::cholesky::numeric) struct FactorLu<'a, P> {
    pub(in crate::cholesky::numeric) pivots: P,
    /// Place of the first column in the elimination order.
    pub(in crate::cholesky::numeric) place: usize,
    /// Columns of L.
    pub(in crate::cholesky::numeric) lower: &'a mut [f64],
    /// Rows of U, as columns of Uᵀ.
    pub(in crate::cholesky::numeric) upper: &'a mut [f64],
    pub(in crate::cholesky::numeric) height: usize,
    /// Row of the first column's diagonal.
    pub(in crate::cholesky::numeric) first: usize,
    /// End of the rows that are taken.
    pub(in crate::cholesky::numeric) end: usize,
}

impl<P: Pivots> WithSimd for FactorLu<'_, P> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<(), usize> {
        let mut from = 0;
        let width = self.lower.len() / self.height;
        while from + COLUMNS <= width {
            self.strip::<S, COLUMNS>(simd, from)?;
            from += COLUMNS;
        }
        match width - from {
            3 => self.strip::<S, 3>(simd, from),
            2 => self.strip::<S, 2>(simd, from),
            1 => self.strip::<S, 1>(simd, from),
            _ => Ok(()),
        }
    }
}

impl<P: Pivots> FactorLu<'_, P> {
    #[inline(always)]
    fn strip<S: Simd, const C: usize>(&mut self, simd: S, column: usize) -> Result<(), usize> {
        let height = self.height;
        let (known_lower, rest) = self.lower.split_at_mut(column * height);
        let lower = &mut rest[..C * height];
        let (known_upper, rest) = self.upper.split_at_mut(column * height);
        let upper = &mut rest[..C * height];
        let from = self.first + column;
        // Row by row.
        let mut square = [[0.0; C]; C];
        for k in 0..C {
            for l in 0..C {
                square[k][l] =
                    if l <= k { lower[l * height + from + k] } else { upper[k * height + from + l] };
            }
        }
        for (lower, upper) in known_lower.chunks_exact(height).zip(known_upper.chunks_exact(height)) {
            let (left, right) = (&lower[from..from + C], &upper[from..from + C]);
            for k in 0..C {
                for l in 0..C {
                    square[k][l] -= left[k] * right[l];
                }
            }
        }
        let place = self.place + column;
        let inverse = factor(&mut square, |k, pivot| self.pivots.diagonal(place + k, pivot))
            .map_err(|pivot| column + pivot)?;
        let (mut above, mut below) = ([[0.0; C]; C], square);
        for k in 0..C {
            for l in 0..k {
                lower[l * height + from + k] = square[k][l];
                upper[l * height + from + k] = square[l][k];
                above[k][l] = square[l][k];
            }
            below[k][k] = 1.0;
            lower[k * height + from + k] = 1.0;
            upper[k * height + from + k] = square[k][k];
        }
        let rows = Rows { block: known_lower, factors: known_upper, height, first: 0 };
        let solve = Solve { triangle: above, inverse, height };
        solve.rows_below::<S, P>(simd, (rows, &[]), lower, from, self.end);
        let rows = Rows { block: known_upper, factors: known_lower, height, first: 0 };
        let solve = Solve { triangle: below, inverse: [1.0; C], height };
        solve.rows_below::<S, P>(simd, (rows, &[]), upper, from, self.end);
        Ok(())
    }
}

/// Factors a small square in place, L below the diagonal, and gives the inverses of its pivots; or else the first pivot that is not taken.
#[inline(always)]
fn factor<const C: usize>(
    square: &mut [[f64; C]; C],
    diagonal: impl Fn(usize, f64) -> Option<f64>,
) -> Result<[f64; C], usize> {
    let mut inverse = [0.0; C];
    for k in 0..C {
        let (above, below) = square.split_at_mut(k + 1);
        let pivots = &mut above[k];
        pivots[k] = diagonal(k, pivots[k]).ok_or(k)?;
        inverse[k] = 1.0 / pivots[k];
        for row in below {
            row[k] *= inverse[k];
            for l in k + 1..C {
                row[l] -= row[k] * pivots[l];
            }
        }
    }
    Ok(inverse)
}
