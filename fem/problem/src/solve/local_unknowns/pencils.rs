//! Eigenproblems without the unknowns of one cell each that the second matrix does not touch, as pressures, which have no mass.

use crate::linear_algebra::{
    BlockElimination, Counts, CsrMatrix, EigenError, Eliminated, Groups, LinearAlgebraError, Transpose,
};
use crate::threads::Threads;

/// A x = λ B x on the unknowns that are left, S x_r = λ B_rr x_r: it has the same finite eigenvalues.
pub(in crate::solve) struct LeftPencil {
    pub first: CsrMatrix,
    pub second: CsrMatrix,
    elimination: BlockElimination,
    blocks: Eliminated,
}

impl LeftPencil {
    /// The pencil that is left of two matrices; none if nothing can be eliminated.
    ///
    /// # Errors
    /// A pencil with too many entries, or matrices of different sizes.
    pub fn of(
        first: &CsrMatrix,
        second: &CsrMatrix,
        groups: &Groups,
    ) -> Result<Option<Self>, LinearAlgebraError> {
        let mut is_touched = vec![false; second.rows()];
        for row in 0..second.rows() {
            let (columns, values) = second.row(row);
            for (column, _) in columns.iter().zip(values).filter(|(_, value)| **value != 0.0) {
                (is_touched[row], is_touched[*column as usize]) = (true, true);
            }
        }
        let groups = groups.where_all(|unknown| is_touched.get(unknown) == Some(&false));
        let (mut elimination, _) = BlockElimination::new(first.pattern(), &groups)?;
        while let Some(known) = elimination {
            match known.eliminate(Threads::all(), first)? {
                Ok((left, blocks)) => {
                    let second = restricted(second, known.rest())?;
                    return Ok(Some(LeftPencil { first: left, second, elimination: known, blocks }));
                }
                Err((next, _)) => elimination = next,
            }
        }
        Ok(None)
    }

    /// Numbers of unknowns that were eliminated, and of others by the reason.
    pub fn counts(&self) -> Counts {
        self.elimination.counts()
    }

    /// An eigenvector of all unknowns from one of those that are left.
    ///
    /// # Errors
    /// A vector of another size.
    pub fn complete(&self, left: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        let zero = vec![0.0; self.elimination.pattern().rows()];
        self.elimination.recover(&self.blocks, &zero, left, Transpose::No)
    }

    /// An error with the number of its unknown among all.
    pub fn of_all(&self, error: EigenError) -> EigenError {
        let number = |unknown: usize| self.elimination.rest().get(unknown).map_or(0, |all| *all as usize);
        match error {
            EigenError::ShiftIsEigenvalue {
                shift,
                source: LinearAlgebraError::Singular { unknown, ratio },
            } => {
                let source = LinearAlgebraError::Singular { unknown: number(unknown), ratio };
                EigenError::ShiftIsEigenvalue { shift, source }
            }
            error => error,
        }
    }
}

/// The rows and columns of some unknowns, ascending.
fn restricted(matrix: &CsrMatrix, unknowns: &[u32]) -> Result<CsrMatrix, LinearAlgebraError> {
    let mut triplets = Vec::new();
    for (row, unknown) in unknowns.iter().enumerate() {
        let (columns, values) = matrix.row(*unknown as usize);
        for (column, value) in columns.iter().zip(values) {
            if let Ok(column) = unknowns.binary_search(column) {
                triplets.push((row, column, *value));
            }
        }
    }
    CsrMatrix::from_triplets(unknowns.len(), unknowns.len(), &triplets)
}
