//! The inverse of the blocks on a block matrix's diagonal, which is Jacobi's preconditioner by nodes.

use super::super::block_matrix::BlockMatrix;
use super::super::block_product::Single;
use super::super::error::{LinearAlgebraError, check_size};
use super::super::operator::{OperatorError, Preconditioner};

/// Inverses of the diagonal blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockDiagonal {
    components: usize,
    inverses: Vec<f64>,
}

impl BlockDiagonal {
    /// Inverses of the diagonal blocks of a matrix.
    ///
    /// # Errors
    /// If the matrix is not square, of one set of nodes, or a diagonal block is singular (the error names the unknown).
    pub fn new(matrix: &BlockMatrix) -> Result<Self, LinearAlgebraError> {
        let single = Single::of(matrix)?;
        check_size("the set of columns of a square matrix", matrix.rows(), matrix.columns())?;
        let components = single.rows.components;
        let mut inverses = Vec::with_capacity(matrix.rows() * components);
        for node in 0..single.rows.nodes {
            let block = single.row(node).find(|(column, _)| *column as usize == node).map(|(_, block)| block);
            let first = inverses.len();
            inverses.extend_from_slice(block.unwrap_or(&[]));
            inverses.resize(first + components * components, 0.0);
            if let Err((component, ratio)) = invert(&mut inverses[first..], components) {
                return Err(LinearAlgebraError::Singular { unknown: node * components + component, ratio });
            }
        }
        Ok(BlockDiagonal { components, inverses })
    }

    /// z = factor D⁻¹ r + keep z.
    pub(super) fn apply(&self, factor: f64, r: &[f64], keep: f64, z: &mut [f64]) {
        match self.components {
            1 => self.apply_blocks::<1>(factor, r, keep, z),
            2 => self.apply_blocks::<2>(factor, r, keep, z),
            3 => self.apply_blocks::<3>(factor, r, keep, z),
            6 => self.apply_blocks::<6>(factor, r, keep, z),
            components => {
                let blocks = self.inverses.chunks_exact(components * components);
                for ((block, r), z) in
                    blocks.zip(r.chunks_exact(components)).zip(z.chunks_exact_mut(components))
                {
                    for (z, row) in z.iter_mut().zip(block.chunks_exact(components)) {
                        let sum: f64 = row.iter().zip(r).map(|(a, r)| a * r).sum();
                        *z = factor * sum + keep * *z;
                    }
                }
            }
        }
    }

    fn apply_blocks<const N: usize>(&self, factor: f64, r: &[f64], keep: f64, z: &mut [f64]) {
        let (rows, _) = self.inverses.as_chunks::<N>();
        let (blocks, _) = rows.as_chunks::<N>();
        let ((r, _), (z, _)) = (r.as_chunks::<N>(), z.as_chunks_mut::<N>());
        for ((block, r), z) in blocks.iter().zip(r).zip(z) {
            for (z, row) in z.iter_mut().zip(block) {
                let sum: f64 = row.iter().zip(r).map(|(a, r)| a * r).sum();
                *z = factor * sum + keep * *z;
            }
        }
    }

    /// D⁻¹ applied to rows of blocks: what the node's rows of a matrix are multiplied with.
    pub(super) fn block(&self, node: usize) -> &[f64] {
        let length = self.components * self.components;
        &self.inverses[node * length..(node + 1) * length]
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
        (&BlockDiagonal::new(&matrix).unwrap()).precondition(&[5.0, 4.0, 2.5, 1.5], &mut z).unwrap();
        assert!(z.iter().all(|value| (value - 1.0).abs() < 1e-15), "{z:?}");
        let values = vec![4.0, 1.0, 1.0, 3.0, 1.0, 1.0, 1.0, 1.0];
        let matrix = block_matrix((2, 2), (2, 2), vec![0, 1, 2], vec![0, 1], values).unwrap();
        assert!(matches!(BlockDiagonal::new(&matrix), Err(LinearAlgebraError::Singular { unknown: 3, .. })));
    }
}
