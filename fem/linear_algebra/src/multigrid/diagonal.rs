//! The inverse of the blocks on a block matrix's diagonal, which is Jacobi's preconditioner by nodes.

use std::sync::{Mutex, PoisonError};

use super::super::block_matrix::BlockMatrix;
use super::super::block_product::Single;
use super::super::error::{LinearAlgebraError, check_size};
use super::super::operator::{OperatorError, Preconditioner};
use super::super::vector::in_pieces;
use crate::threads::Threads;

/// Inverses of the diagonal blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockDiagonal {
    components: usize,
    inverses: Vec<f64>,
    /// Those of products with the inverses.
    threads: Threads,
}

impl BlockDiagonal {
    /// Inverses of the diagonal blocks of a matrix, on some threads, which products with them use, too.
    ///
    /// # Errors
    /// If the matrix is not square, of one set of nodes, or a diagonal block is singular (the error names the unknown).
    pub fn new(matrix: &BlockMatrix, threads: Threads) -> Result<Self, LinearAlgebraError> {
        let single = Single::of(matrix)?;
        check_size("the set of columns of a square matrix", matrix.rows(), matrix.columns())?;
        let components = single.rows.components;
        let size = components * components;
        let mut inverses = vec![0.0; single.rows.nodes * size];
        let failed = Mutex::new(None);
        in_pieces(threads, &mut inverses, size, |first, inverses| {
            for (node, inverse) in (first / size.max(1)..).zip(inverses.chunks_exact_mut(size)) {
                if let Some(place) = single.pair.place(node, node as u32) {
                    inverse.copy_from_slice(&single.values[place * size..(place + 1) * size]);
                }
                if let Err((component, ratio)) = invert(inverse, components) {
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    let unknown = node * components + component;
                    if failed.is_none_or(|(first, _)| unknown < first) {
                        *failed = Some((unknown, ratio));
                    }
                    return;
                }
            }
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((unknown, ratio)) => Err(LinearAlgebraError::Singular { unknown, ratio }),
            None => Ok(BlockDiagonal { components, inverses, threads }),
        }
    }

    /// z = factor D⁻¹ r + keep z.
    pub(super) fn apply(&self, factor: f64, r: &[f64], keep: f64, z: &mut [f64]) {
        in_pieces(self.threads, z, self.components, |first, z| {
            let (inverses, r) = (&self.inverses[first * self.components..], &r[first..]);
            match self.components {
                1 => apply_blocks::<1>(inverses, factor, r, keep, z),
                2 => apply_blocks::<2>(inverses, factor, r, keep, z),
                3 => apply_blocks::<3>(inverses, factor, r, keep, z),
                6 => apply_blocks::<6>(inverses, factor, r, keep, z),
                components => {
                    let blocks = inverses.chunks_exact(components * components);
                    let vectors = r.chunks_exact(components).zip(z.chunks_exact_mut(components));
                    for (block, (r, z)) in blocks.zip(vectors) {
                        for (z, row) in z.iter_mut().zip(block.chunks_exact(components)) {
                            let sum: f64 = row.iter().zip(r).map(|(a, r)| a * r).sum();
                            *z = factor * sum + keep * *z;
                        }
                    }
                }
            }
        });
    }

    /// D⁻¹ applied to rows of blocks: what the node's rows of a matrix are multiplied with.
    pub(super) fn block(&self, node: usize) -> &[f64] {
        let length = self.components * self.components;
        &self.inverses[node * length..(node + 1) * length]
    }
}

/// z = factor D⁻¹ r + keep z, for blocks of a size that the compiler knows.
fn apply_blocks<const N: usize>(inverses: &[f64], factor: f64, r: &[f64], keep: f64, z: &mut [f64]) {
    let (rows, _) = inverses.as_chunks::<N>();
    let (blocks, _) = rows.as_chunks::<N>();
    let ((r, _), (z, _)) = (r.as_chunks::<N>(), z.as_chunks_mut::<N>());
    for ((block, r), z) in blocks.iter().zip(r).zip(z) {
        for (z, row) in z.iter_mut().zip(block) {
            let sum: f64 = row.iter().zip(r).map(|(a, r)| a * r).sum();
            *z = factor * sum + keep * *z;
        }
    }
}

impl Preconditioner for &BlockDiagonal {
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
        check_size("the vector to precondition", self.inverses.len() / self.components.max(1), r.len())?;
        check_size("the preconditioned vector", r.len(), z.len())?;
        z.fill(0.0); // what was not finite is forgotten
        self.apply(1.0, r, 0.0, z);
        Ok(())
    }
}

/// Replaces a small dense matrix by its inverse: Gauss–Jordan with pivots on the diagonal, as a symmetric definite
/// block allows. Fails with the component of a pivot that is zero up to rounding.
fn invert(block: &mut [f64], size: usize) -> Result<(), (usize, f64)> {
    let scales: Vec<f64> = (0..size).map(|i| block[i * size + i].abs()).collect();
    for k in 0..size {
        let pivot = block[k * size + k];
        let ratio = if scales[k] == 0.0 { 0.0 } else { pivot.abs() / scales[k] };
        if ratio <= 1e-14 || !ratio.is_finite() {
            return Err((k, ratio));
        }
        block[k * size + k] = 1.0;
        for j in 0..size {
            block[k * size + j] /= pivot;
        }
        for i in (0..size).filter(|&i| i != k) {
            let factor = std::mem::replace(&mut block[i * size + k], 0.0);
            for j in 0..size {
                block[i * size + j] -= factor * block[k * size + j];
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block_product::block_matrix;

    #[test]
    fn diagonal_blocks_are_inverted_and_a_singular_one_is_named() {
        let values = vec![4.0, 1.0, 1.0, 3.0, 2.0, 0.5, 0.5, 1.0];
        let matrix = block_matrix((2, 2), (2, 2), vec![0, 1, 2], vec![0, 1], values).unwrap();
        let mut z = vec![f64::NAN; 4];
        (&BlockDiagonal::new(&matrix, Threads::ONE).unwrap())
            .precondition(&[5.0, 4.0, 2.5, 1.5], &mut z)
            .unwrap();
        assert!(z.iter().all(|value| (value - 1.0).abs() < 1e-15), "{z:?}");
        let values = vec![4.0, 1.0, 1.0, 3.0, 1.0, 1.0, 1.0, 1.0];
        let matrix = block_matrix((2, 2), (2, 2), vec![0, 1, 2], vec![0, 1], values).unwrap();
        assert!(matches!(
            BlockDiagonal::new(&matrix, Threads::ONE),
            Err(LinearAlgebraError::Singular { unknown: 3, .. })
        ));
    }
}
