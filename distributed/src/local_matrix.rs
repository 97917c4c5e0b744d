//! This process's part of a matrix over the free unknowns: with an index per entry, or in blocks over all unknowns.

use std::sync::Arc;

use forms_fem::linear_algebra::vector::is_finite;
use forms_fem::linear_algebra::{BlockMatrix, BlockSparsity, CsrMatrix, LinearAlgebraError, SparsityPattern};
use forms_fem::solve::Elimination;

/// The part of a matrix that this process assembled.
pub(crate) enum LocalMatrix<'a> {
    /// Over the free unknowns.
    Free(&'a CsrMatrix),
    /// Over all unknowns. None of those that are not free is given by others.
    All {
        matrix: &'a BlockMatrix,
        free: &'a [usize],
        /// The number of each unknown among the free ones.
        numbers: Vec<u32>,
    },
}

/// The positions of a process's part.
#[derive(Debug)]
pub(crate) enum LocalPattern {
    Free(Arc<SparsityPattern>),
    All(Arc<BlockSparsity>),
}

/// An unknown that is not free has no number.
const HELD: u32 = u32::MAX;

impl<'a> LocalMatrix<'a> {
    /// The free rows and columns of a matrix over all unknowns.
    pub fn of_all(matrix: &'a BlockMatrix, elimination: &'a Elimination) -> Self {
        let (free, mut numbers) = (elimination.free(), vec![HELD; elimination.size()]);
        (0..).zip(free).for_each(|(number, unknown)| numbers[*unknown] = number);
        LocalMatrix::All { matrix, free, numbers }
    }

    /// Number of its rows.
    pub fn rows(&self) -> usize {
        match self {
            LocalMatrix::Free(matrix) => matrix.rows(),
            LocalMatrix::All { free, .. } => free.len(),
        }
    }

    /// A visit to each column of a row, with the value there. Each column comes once.
    pub fn visit_row(&self, row: usize, mut visit: impl FnMut(u32, f64)) {
        match self {
            LocalMatrix::Free(matrix) => {
                let (columns, values) = matrix.row(row);
                columns.iter().zip(values).for_each(|(column, value)| visit(*column, *value));
            }
            LocalMatrix::All { matrix, free, numbers } => {
                let entries = matrix.row(free[row]).map(|(column, value)| (numbers[column], value));
                entries
                    .filter(|(column, _)| *column != HELD)
                    .for_each(|(column, value)| visit(column, value));
            }
        }
    }

    /// An error for an entry that is no number.
    pub fn check_finite(&self) -> Result<(), LinearAlgebraError> {
        let values = match self {
            LocalMatrix::Free(matrix) => matrix.values(),
            LocalMatrix::All { matrix, .. } => matrix.values(),
        };
        if is_finite(values) {
            return Ok(());
        }
        // One among held unknowns does no harm.
        for row in 0..self.rows() {
            let mut wrong = None;
            self.visit_row(row, |column, value| {
                if !value.is_finite() {
                    wrong = wrong.or(Some((column as usize, value)));
                }
            });
            if let Some((column, value)) = wrong {
                return Err(LinearAlgebraError::EntryNotFinite { row, column, value });
            }
        }
        Ok(())
    }

    pub fn pattern(&self) -> LocalPattern {
        match self {
            LocalMatrix::Free(matrix) => LocalPattern::Free(Arc::clone(matrix.pattern())),
            LocalMatrix::All { matrix, .. } => LocalPattern::All(Arc::clone(matrix.sparsity())),
        }
    }

    /// Whether it has the positions of one before.
    pub fn has(&self, pattern: &LocalPattern) -> bool {
        match (self, pattern) {
            (LocalMatrix::Free(matrix), LocalPattern::Free(known)) => {
                Arc::ptr_eq(matrix.pattern(), known) || **matrix.pattern() == **known
            }
            (LocalMatrix::All { matrix, .. }, LocalPattern::All(known)) => {
                Arc::ptr_eq(matrix.sparsity(), known) || **matrix.sparsity() == **known
            }
            _ => false,
        }
    }
}
