//! Errors in PETSc, and on other processes.

use forms_fem::linear_algebra::{LinearAlgebraError, ResidualHistory};
use forms_fem::solve::SolverError;

/// PETSc refused something.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PetscError {
    /// A function returned an error.
    #[error("PETSc's {function} failed with code {code}: {message}")]
    Call {
        /// The function's name in C.
        function: &'static str,
        /// Its `PetscErrorCode`.
        code: i32,
        /// PETSc's message.
        message: String,
    },
    /// [`crate::World`] was made twice.
    #[error("PETSc was started already in this process: there is one world")]
    StartedAlready,
    /// A vector that does not fit the rows of the others.
    #[error("a vector has {found} entries where {expected} are wanted")]
    Size {
        /// Rows.
        expected: usize,
        /// Entries.
        found: usize,
    },
    /// More rows or entries than PETSc's indices can count.
    #[error("{count} {what} are more than PETSc's indices can count")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// Their number.
        count: usize,
    },
}

impl From<PetscError> for SolverError {
    fn from(error: PetscError) -> Self {
        SolverError::Other { solver: "PETSc", why: error.to_string(), history: ResidualHistory::default() }
    }
}

/// A failure of something that all processes do together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DistributedError<E: std::error::Error> {
    /// This process failed.
    #[error(transparent)]
    Here(E),
    /// Others failed, and say why themselves.
    #[error("{count} of the other processes failed")]
    Elsewhere {
        /// Their number.
        count: usize,
    },
    /// The exchange between the processes failed.
    #[error(transparent)]
    Petsc(#[from] PetscError),
}

impl From<DistributedError<LinearAlgebraError>> for SolverError {
    fn from(error: DistributedError<LinearAlgebraError>) -> Self {
        match error {
            DistributedError::Here(error) => error.into(),
            DistributedError::Petsc(error) => error.into(),
            DistributedError::Elsewhere { .. } => SolverError::Other {
                solver: "PETSc",
                why: error.to_string(),
                history: ResidualHistory::default(),
            },
        }
    }
}
