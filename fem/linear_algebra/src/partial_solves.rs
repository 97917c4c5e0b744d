//! Half solves with an LLᵀ or LSLᵀ factor, and its trailing block: what a Schur complement on the unknowns that
//! are eliminated last needs.

use faer::linalg::matmul::matmul;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::{Accum, Mat, MatMut, Par};

use super::cholesky::SymmetricFactor;
use super::error::{LinearAlgebraError, check_size};
use super::threads::Threads;
use super::wide_registers::cleared;

impl SymmetricFactor {
    /// L⁻¹ P b in place of b, in elimination order, for a factor LLᵀ or LSLᵀ of P A Pᵀ.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn solve_lower(&self, b: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        self.solve_lower_each(&[b]).map(|mut found| found.swap_remove(0))
    }

    /// L⁻¹ P b of several right-hand sides, which read L once. Each has the bits of [`SymmetricFactor::solve_lower`].
    ///
    /// # Errors
    /// If a size is wrong.
    pub fn solve_lower_each(&self, sides: &[&[f64]]) -> Result<Vec<Vec<f64>>, LinearAlgebraError> {
        let order = self.analysis().elimination_order();
        let mut found = Vec::with_capacity(sides.len());
        for b in sides {
            check_size("the right-hand side", order.len(), b.len())?;
            found.push(order.iter().map(|unknown| b[*unknown as usize]).collect());
        }
        self.solve_with_lower(&mut in_place(&mut found));
        Ok(found)
    }

    /// Pᵀ L⁻ᵀ y, from elimination order back to the order of the unknowns.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn solve_upper(&self, y: Vec<f64>) -> Result<Vec<f64>, LinearAlgebraError> {
        self.solve_upper_each(vec![y]).map(|mut found| found.swap_remove(0))
    }

    /// Pᵀ L⁻ᵀ y of several right-hand sides, which read L once. Each has the bits of [`SymmetricFactor::solve_upper`].
    ///
    /// # Errors
    /// If a size is wrong.
    pub fn solve_upper_each(&self, mut sides: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, LinearAlgebraError> {
        let order = self.analysis().elimination_order();
        sides.iter().try_for_each(|y| check_size("the right-hand side", order.len(), y.len()))?;
        self.solve_with_upper(&mut in_place(&mut sides));
        let mut x = vec![0.0; order.len()];
        for side in &mut sides {
            for (value, unknown) in side.iter().zip(order) {
                x[*unknown as usize] = *value;
            }
            std::mem::swap(side, &mut x);
        }
        Ok(sides)
    }

    /// The last `count` rows and columns of L, dense and lower triangular.
    pub(crate) fn trailing_block(&self, count: usize) -> Mat<f64> {
        let supernodes = self.supernodes();
        let factor = SupernodalLltRef::new(supernodes, self.values());
        let first = self.analysis().size() - count;
        let mut block = Mat::zeros(count, count);
        for s in 0..supernodes.n_supernodes() {
            let node = factor.supernode(s);
            let (start, values) = (node.start(), node.val());
            for j in 0..values.ncols() {
                if start + j < first {
                    continue;
                }
                let column = start + j - first;
                for i in j..values.ncols() {
                    block[(start + i - first, column)] = values[(i, j)];
                }
                for (i, row) in node.pattern().iter().enumerate() {
                    block[(*row as usize - first, column)] = values[(values.ncols() + i, j)];
                }
            }
        }
        block
    }
}

fn in_place(sides: &mut [Vec<f64>]) -> Vec<&mut [f64]> {
    sides.iter_mut().map(Vec::as_mut_slice).collect()
}

/// Columns of L D Lᵀ that are computed together.
const TILE: usize = 96;

/// L D Lᵀ of a dense lower triangular L and a diagonal of signs. The same bits come from any number of threads, which share tiles of columns.
pub(crate) fn lower_times_transposed(threads: Threads, lower: &Mat<f64>, signs: &[f64]) -> Mat<f64> {
    let size = lower.nrows();
    let signed = Mat::from_fn(size, size, |i, j| lower[(i, j)] * signs[j]);
    let mut product = Mat::zeros(size, size);
    let mut tiles = vec![];
    let mut rest = product.as_mut();
    for first in (0..size).step_by(TILE) {
        let (tile, after) = rest.split_at_col_mut(TILE.min(size - first));
        tiles.push((first, tile));
        rest = after;
    }
    // Rows above the tile come from symmetry; those of L have entries up to the tile's last column.
    threads.share(tiles, |(first, tile): (usize, MatMut<'_, f64>)| {
        let end = first + tile.ncols();
        let left = signed.get(first.., ..end);
        let right = lower.get(first..end, ..end).transpose();
        let below = tile.subrows_mut(first, size - first);
        cleared(|| matmul(below, Accum::Replace, left, right, 1.0, Par::Seq));
    });
    for j in 0..size {
        for i in 0..j {
            product[(i, j)] = product[(j, i)];
        }
    }
    product
}
