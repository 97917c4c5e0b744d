//! Dense kernels of a supernode: products of rows of one block, and the factorisation of another, a few columns at once in registers.
//!
//! An entry is one sum over the columns in their order, whichever tile it is in: tiles may be cut as is best.

use faer::traits::pulp::{Arch, Simd, WithSimd};

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
    pub(super) height: usize,
    pub(super) first: usize,
}

/// Takes products of rows out of another block: entry (targets[i], targets[j]) less Σ row i × row j, for each row i and the
/// first `columns` of rows j, as far as i ≥ j.
pub(super) struct Subtract<'a> {
    pub(super) rows: Rows<'a>,
    pub(super) columns: usize,
    /// Rows of the other block.
    pub(super) targets: &'a [u32],
    pub(super) target: &'a mut [f64],
    pub(super) target_height: usize,
    /// Of the first of the targets' columns, in the block's rows.
    pub(super) target_first: usize,
}

/// Factors columns of a block: their triangle on the diagonal and what is below it. An error is the first of the columns whose
/// pivot is not positive.
pub(super) struct Factor<'a> {
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

impl WithSimd for Subtract<'_> {
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

impl Subtract<'_> {
    #[inline(always)]
    fn strip<S: Simd, const C: usize>(&mut self, simd: S, from: usize) {
        let count = self.targets.len();
        let full = REGISTERS * S::F64_LANES;
        let mut row = from;
        while row + full <= count {
            let sums = products::<S, REGISTERS, C, true>(simd, self.rows, row, from, full);
            self.store::<S, REGISTERS, C>(sums, from, row, full);
            row += full;
        }
        let rest = count - row;
        match rest.div_ceil(S::F64_LANES) {
            3 => {
                let sums = products::<S, 3, C, false>(simd, self.rows, row, from, rest);
                self.store::<S, 3, C>(sums, from, row, rest);
            }
            2 => {
                let sums = products::<S, 2, C, false>(simd, self.rows, row, from, rest);
                self.store::<S, 2, C>(sums, from, row, rest);
            }
            1 => {
                let sums = products::<S, 1, C, false>(simd, self.rows, row, from, rest);
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
fn products<S: Simd, const R: usize, const C: usize, const FULL: bool>(
    simd: S,
    rows: Rows<'_>,
    row: usize,
    other: usize,
    count: usize,
) -> [[S::f64s; R]; C] {
    let mut sums = [[simd.splat_f64s(0.0); R]; C];
    let count = if FULL { R * S::F64_LANES } else { count };
    for column in rows.block.chunks_exact(rows.height) {
        let column = &column[rows.first..];
        let factors = &column[other..other + C];
        let left = load::<S, R, FULL>(simd, &column[row..row + count]);
        for k in 0..C {
            let factor = simd.splat_f64s(factors[k]);
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

impl WithSimd for Factor<'_> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<(), usize> {
        let mut from = 0;
        let width = self.columns.len() / self.height;
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

impl Factor<'_> {
    #[inline(always)]
    fn strip<S: Simd, const C: usize>(&mut self, simd: S, from: usize) -> Result<(), usize> {
        let height = self.height;
        let (known, rest) = self.columns.split_at_mut(from * height);
        let own = &mut rest[..C * height];
        let rows = Rows { block: known, height, first: 0 };
        let (column, from) = (from, self.first + from);
        // The triangle on the diagonal.
        let mut triangle = [[0.0; C]; C];
        for k in 0..C {
            for l in 0..=k {
                triangle[k][l] = own[l * height + from + k];
            }
        }
        for column in known.chunks_exact(height) {
            let factors = &column[from..from + C];
            for k in 0..C {
                for l in 0..=k {
                    triangle[k][l] -= factors[k] * factors[l];
                }
            }
        }
        let inverse = factor(&mut triangle).map_err(|pivot| column + pivot)?;
        for (k, row) in triangle.iter().enumerate() {
            for (l, value) in row[..=k].iter().enumerate() {
                own[l * height + from + k] = *value;
            }
        }
        let solve = Solve { triangle, inverse, height };
        let full = REGISTERS * S::F64_LANES;
        let mut row = from + C;
        while row + full <= self.end {
            let sums = products::<S, REGISTERS, C, true>(simd, rows, row, from, full);
            solve.apply::<S, REGISTERS, true>(simd, sums, own, row, full);
            row += full;
        }
        let rest = self.end - row;
        match rest.div_ceil(S::F64_LANES) {
            3 => {
                let sums = products::<S, 3, C, false>(simd, rows, row, from, rest);
                solve.apply::<S, 3, false>(simd, sums, own, row, rest);
            }
            2 => {
                let sums = products::<S, 2, C, false>(simd, rows, row, from, rest);
                solve.apply::<S, 2, false>(simd, sums, own, row, rest);
            }
            1 => {
                let sums = products::<S, 1, C, false>(simd, rows, row, from, rest);
                solve.apply::<S, 1, false>(simd, sums, own, row, rest);
            }
            _ => {}
        }
        Ok(())
    }
}

/// Factors a small triangle, and gives the inverses of its diagonal; or else the first pivot that is not positive.
#[inline(always)]
fn factor<const C: usize>(triangle: &mut [[f64; C]; C]) -> Result<[f64; C], usize> {
    let mut inverse = [0.0; C];
    for k in 0..C {
        let (above, rest) = triangle.split_at_mut(k);
        let own = &mut rest[0];
        for (l, other) in above.iter().enumerate() {
            let known: f64 = other[..l].iter().zip(&own[..l]).map(|(a, b)| a * b).sum();
            own[l] = (own[l] - known) * inverse[l];
        }
        let known: f64 = own[..k].iter().map(|value| value * value).sum();
        let pivot = own[k] - known;
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(k);
        }
        own[k] = pivot.sqrt();
        inverse[k] = 1.0 / own[k];
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
