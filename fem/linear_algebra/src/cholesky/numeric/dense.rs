//! Dense kernels of a supernode: products of rows of one block, and the factorisation of another, a few columns at once in registers.
//!
//! An entry is one sum over the columns in their order, whichever tile it is in: tiles may be cut as is best.

mod lu;

use std::marker::PhantomData;

use faer::traits::pulp::{Arch, Simd, WithSimd};

pub(super) use self::lu::FactorLu;
use super::pivots::Pivots;
use crate::elimination::PANEL;

/// Columns of a tile.
const COLUMNS: usize = 4;
/// Registers of a column of a tile.
const REGISTERS: usize = 3;
/// Numbers of a tile's column, at most: of eight a register.
const TILE: usize = 8 * REGISTERS;

/// Rows of a block that is stored column by column.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) block: &'a [f64],
    /// The block whose rows they are multiplied by: the same one, or that of the other triangle.
    pub(super) factors: &'a [f64],
    pub(super) height: usize,
    pub(super) first: usize,
}

/// Takes products of rows out of another block: entry (targets[i], targets[j]) less Σ sign × row i × row j, for each row i and the
/// first `columns` of rows j, as far as i ≥ j.
pub(super) struct Subtract<'a, P> {
    pub(super) rows: Rows<'a>,
    /// Of the columns of these rows, as the rule for pivots reads them.
    pub(super) signs: &'a [f64],
    pub(super) rule: PhantomData<P>,
    pub(super) columns: usize,
    /// Rows of the other block.
    pub(super) targets: &'a [u32],
    pub(super) target: &'a mut [f64],
    pub(super) target_height: usize,
    /// Of the first of the targets' columns, in the block's rows.
    pub(super) target_first: usize,
}

/// Factors columns of a block: their triangle on the diagonal and what is below it. An error is the first of the columns whose
/// pivot is not taken. There are at most as many as in a panel.
pub(super) struct Factor<'a, P> {
    pub(super) pivots: P,
    /// Place of the first column in the elimination order.
    pub(super) place: usize,
    pub(super) columns: &'a mut [f64],
    pub(super) height: usize,
    /// Row of the first column's diagonal.
    pub(super) first: usize,
    /// End of the rows that are taken.
    pub(super) end: usize,
}

pub(super) fn run<Op: WithSimd>(op: Op) -> Op::Output {
    Arch::new().dispatch(op)
}

impl<P: Pivots> WithSimd for Subtract<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut from = 0;
        while from + COLUMNS <= self.columns {
            self.strip::<S, COLUMNS>(simd, from);
            from += COLUMNS;
        }
        match self.columns - from {
            3 => self.strip::<S, 3>(simd, from),
            2 => self.strip::<S, 2>(simd, from),
            1 => self.strip::<S, 1>(simd, from),
            _ => {}
        }
    }
}

impl<P: Pivots> Subtract<'_, P> {
    #[inline(always)]
    fn strip<S: Simd, const C: usize>(&mut self, simd: S, from: usize) {
        let count = self.targets.len();
        let full = REGISTERS * S::F64_LANES;
        let mut row = from;
        while row + full <= count {
            let sums = products::<S, P, REGISTERS, C, true>(simd, (self.rows, self.signs), row, from, full);
            self.store::<S, REGISTERS, C>(sums, from, row, full);
            row += full;
        }
        let rest = count - row;
        match rest.div_ceil(S::F64_LANES) {
            3 => {
                let sums = products::<S, P, 3, C, false>(simd, (self.rows, self.signs), row, from, rest);
                self.store::<S, 3, C>(sums, from, row, rest);
            }
            2 => {
                let sums = products::<S, P, 2, C, false>(simd, (self.rows, self.signs), row, from, rest);
                self.store::<S, 2, C>(sums, from, row, rest);
            }
            1 => {
                let sums = products::<S, P, 1, C, false>(simd, (self.rows, self.signs), row, from, rest);
                self.store::<S, 1, C>(sums, from, row, rest);
            }
            _ => {}
        }
    }

    #[inline(always)]
    fn store<S: Simd, const R: usize, const C: usize>(
        &mut self,
        sums: [[S::f64s; R]; C],
        from: usize,
        row: usize,
        rows: usize,
    ) {
        let targets = &self.targets[row..row + rows];
        let in_a_row = targets[rows - 1] - targets[0] == rows as u32 - 1;
        for (k, sums) in sums.iter().enumerate() {
            let column = self.targets[from + k] as usize - self.target_first;
            let column = &mut self.target[column * self.target_height..][..self.target_height];
            let mut buffer = [0.0; TILE];
            for (part, sum) in S::as_mut_simd_f64s(&mut buffer).0.iter_mut().zip(sums) {
                *part = *sum;
            }
            // Above the diagonal there are no entries to read.
            let skipped = (from + k).saturating_sub(row);
            if skipped >= rows {
                continue;
            }
            if in_a_row {
                let first = targets[skipped] as usize;
                let column = &mut column[first..first + rows - skipped];
                for (value, sum) in column.iter_mut().zip(&buffer[skipped..]) {
                    *value -= sum;
                }
            } else {
                for (target, sum) in targets[skipped..].iter().zip(&buffer[skipped..]) {
                    column[*target as usize] -= sum;
                }
            }
        }
    }
}

/// Sums over all columns of products of some rows with C others; of the last register only the rows that exist.
#[inline(always)]
fn products<S: Simd, P: Pivots, const R: usize, const C: usize, const FULL: bool>(
    simd: S,
    (rows, signs): (Rows<'_>, &[f64]),
    row: usize,
    other: usize,
    count: usize,
) -> [[S::f64s; R]; C] {
    let mut sums = [[simd.splat_f64s(0.0); R]; C];
    let count = if FULL { R * S::F64_LANES } else { count };
    let columns = rows.block.chunks_exact(rows.height).zip(rows.factors.chunks_exact(rows.height));
    for (number, (column, factors)) in columns.enumerate() {
        let sign = P::sign(signs, number);
        let column = &column[rows.first..];
        let factors = &factors[rows.first + other..][..C];
        let left = load::<S, R, FULL>(simd, &column[row..row + count]);
        for k in 0..C {
            let factor = simd.splat_f64s(sign * factors[k]);
            for r in 0..R {
                sums[k][r] = simd.mul_add_e_f64s(left[r], factor, sums[k][r]);
            }
        }
    }
    sums
}

#[inline(always)]
fn load<S: Simd, const R: usize, const FULL: bool>(simd: S, values: &[f64]) -> [S::f64s; R] {
    let mut registers = [simd.splat_f64s(0.0); R];
    if FULL {
        let whole = &S::as_simd_f64s(values).0[..R];
        registers.copy_from_slice(whole);
    } else {
        let (whole, rest) = values.split_at((R - 1) * S::F64_LANES);
        let whole = &S::as_simd_f64s(whole).0[..R - 1];
        registers[..R - 1].copy_from_slice(whole);
        registers[R - 1] = simd.partial_load_f64s(rest);
    }
    registers
}

impl<P: Pivots> WithSimd for Factor<'_, P> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<(), usize> {
        let mut from = 0;
        let width = self.columns.len() / self.height;
        let mut signs = [1.0; PANEL];
        while from + COLUMNS <= width {
            self.strip::<S, COLUMNS>(simd, from, &mut signs)?;
            from += COLUMNS;
        }
        match width - from {
            3 => self.strip::<S, 3>(simd, from, &mut signs),
            2 => self.strip::<S, 2>(simd, from, &mut signs),
            1 => self.strip::<S, 1>(simd, from, &mut signs),
            _ => Ok(()),
        }
    }
}

impl<P: Pivots> Factor<'_, P> {
    #[inline(always)]
    fn strip<S: Simd, const C: usize>(
        &mut self,
        simd: S,
        from: usize,
        signs: &mut [f64; PANEL],
    ) -> Result<(), usize> {
        let height = self.height;
        let (known, rest) = self.columns.split_at_mut(from * height);
        let own = &mut rest[..C * height];
        let rows = Rows { block: known, factors: known, height, first: 0 };
        let (column, from) = (from, self.first + from);
        // The triangle on the diagonal.
        let mut triangle = [[0.0; C]; C];
        for k in 0..C {
            for l in 0..=k {
                triangle[k][l] = own[l * height + from + k];
            }
        }
        for (number, column) in known.chunks_exact(height).enumerate() {
            let sign = P::sign(&signs[..], number);
            let factors = &column[from..from + C];
            for k in 0..C {
                for l in 0..=k {
                    triangle[k][l] -= sign * factors[k] * factors[l];
                }
            }
        }
        let place = self.place + column;
        let inverse = factor(&mut triangle, |k, pivot| self.pivots.diagonal(place + k, pivot))
            .map_err(|pivot| column + pivot)?;
        for (k, row) in triangle.iter().enumerate() {
            for (l, value) in row[..=k].iter().enumerate() {
                own[l * height + from + k] = *value;
            }
        }
        for k in 0..C {
            signs[column + k] = 1.0_f64.copysign(triangle[k][k]);
        }
        // Other rows are taken with the signs of the triangle's columns.
        let own_signs: [f64; C] = std::array::from_fn(|l| P::sign(&signs[..], column + l));
        for row in &mut triangle {
            row.iter_mut().zip(own_signs).for_each(|(value, sign)| *value *= sign);
        }
        let solve = Solve { triangle, inverse, height };
        solve.rows_below::<S, P>(simd, (rows, &signs[..]), own, from, self.end);
        Ok(())
    }
}

/// Factors a small triangle, and gives the inverses of its diagonal's sizes; or else the first pivot that is not taken.
#[inline(always)]
fn factor<const C: usize>(
    triangle: &mut [[f64; C]; C],
    diagonal: impl Fn(usize, f64) -> Option<f64>,
) -> Result<[f64; C], usize> {
    let mut inverse = [0.0; C];
    let mut signs = [1.0; C];
    for k in 0..C {
        let (above, rest) = triangle.split_at_mut(k);
        let own = &mut rest[0];
        for (l, other) in above.iter().enumerate() {
            let known: f64 =
                other[..l].iter().zip(&own[..l]).zip(&signs).map(|((a, b), sign)| sign * (a * b)).sum();
            own[l] = (own[l] - known) * inverse[l];
        }
        let known: f64 = own[..k].iter().zip(&signs).map(|(value, sign)| sign * (value * value)).sum();
        own[k] = diagonal(k, own[k] - known).ok_or(k)?;
        inverse[k] = 1.0 / own[k].abs();
        signs[k] = 1.0_f64.copysign(own[k]);
    }
    Ok(inverse)
}

/// The last steps of a tile of columns: their own triangle.
struct Solve<const C: usize> {
    triangle: [[f64; C]; C],
    inverse: [f64; C],
    height: usize,
}

impl<const C: usize> Solve<C> {
    /// Rows below the tile's triangle, which begins in the given row, as far as an end.
    #[inline(always)]
    fn rows_below<S: Simd, P: Pivots>(
        &self,
        simd: S,
        (rows, signs): (Rows<'_>, &[f64]),
        own: &mut [f64],
        from: usize,
        end: usize,
    ) {
        let full = REGISTERS * S::F64_LANES;
        let mut row = from + C;
        while row + full <= end {
            let sums = products::<S, P, REGISTERS, C, true>(simd, (rows, signs), row, from, full);
            self.apply::<S, REGISTERS, true>(simd, sums, own, row, full);
            row += full;
        }
        let rest = end - row;
        match rest.div_ceil(S::F64_LANES) {
            3 => {
                let sums = products::<S, P, 3, C, false>(simd, (rows, signs), row, from, rest);
                self.apply::<S, 3, false>(simd, sums, own, row, rest);
            }
            2 => {
                let sums = products::<S, P, 2, C, false>(simd, (rows, signs), row, from, rest);
                self.apply::<S, 2, false>(simd, sums, own, row, rest);
            }
            1 => {
                let sums = products::<S, P, 1, C, false>(simd, (rows, signs), row, from, rest);
                self.apply::<S, 1, false>(simd, sums, own, row, rest);
            }
            _ => {}
        }
    }

    #[inline(always)]
    fn apply<S: Simd, const R: usize, const FULL: bool>(
        &self,
        simd: S,
        mut sums: [[S::f64s; R]; C],
        own: &mut [f64],
        row: usize,
        count: usize,
    ) {
        let count = if FULL { R * S::F64_LANES } else { count };
        for k in 0..C {
            let column = &mut own[k * self.height + row..][..count];
            let values = load::<S, R, FULL>(simd, column);
            let inverse = simd.splat_f64s(self.inverse[k]);
            for r in 0..R {
                let mut value = simd.sub_f64s(values[r], sums[k][r]);
                for (factor, solved) in self.triangle[k][..k].iter().zip(&sums) {
                    value = simd.negate_mul_add_e_f64s(solved[r], simd.splat_f64s(*factor), value);
                }
                sums[k][r] = simd.mul_f64s(value, inverse);
            }
            if FULL {
                for (target, value) in S::as_mut_simd_f64s(column).0.iter_mut().zip(sums[k]) {
                    *target = value;
                }
            } else {
                let (whole, rest) = column.split_at_mut((R - 1) * S::F64_LANES);
                for (target, value) in S::as_mut_simd_f64s(whole).0.iter_mut().zip(sums[k]) {
                    *target = value;
                }
                simd.partial_store_f64s(rest, sums[k][R - 1]);
            }
        }
    }
}
