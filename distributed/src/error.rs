//! Errors in PETSc, and on other processes.

use forms_fem::linear_algebra::ResidualHistory;
use forms_fem::solve::SolverError;

/// PETSc refused something.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)]
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
    /// A function of MPI returned an error.
    #[error("{function} failed with code {code}")]
    Mpi {
        /// The function's name in C.
        function: &'static str,
        code: i32,
    },
    /// Other processes have ended because of an error, while this one goes on.
    #[error("{}", named(processes, "failed, and says why itself", "failed, and say why themselves"))]
    Failed { processes: Vec<usize> },
    /// Other processes do something else than this one.
    #[error(
        "{} at {elsewhere}, this process at {here}: all processes have to make the same calls in the same order",
        named(processes, "is", "are")
    )]
    OtherCalls {
        processes: Vec<usize>,
        /// Call that the others make.
        elsewhere: String,
        /// Call that this process makes.
        here: String,
    },
    /// An error of other processes in what all do together.
    #[error("{count} of the other processes failed")]
    Elsewhere { count: usize },
    /// Something that has to be the same on all processes.
    #[error("the processes have different {what}")]
    Different {
        /// Name of the thing.
        what: &'static str,
    },
    /// A part of a mesh that outlived its world.
    #[error("the world of these processes has ended")]
    Ended,
    /// More processes than a mesh can be divided among.
    #[error("{processes} processes cannot each have cells of a mesh of {cells}: start fewer")]
    TooManyProcesses { processes: usize, cells: usize },
    /// Something that a divided mesh does not have.
    #[error(
        "{what} are not available on a mesh that is divided among processes; take the whole mesh on each process"
    )]
    Divided {
        /// The thing, in words.
        what: String,
    },
    /// A mesh, a space or constraints that do not fit.
    #[error("{message}")]
    Unfit {
        /// The error of forms_fem.
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
        found: usize,
    },
    /// A prefix that names of options cannot begin with.
    #[error("\"{prefix}\" cannot begin the names of PETSc's options: it has letters, digits and `_` only")]
    OptionsPrefix { prefix: String },
    /// More rows or entries than PETSc's indices can count.
    #[error("{count} {what} are more than PETSc's indices can count")]
    TooMany { what: &'static str, count: usize },
}

/// Processes by their numbers, with what they do.
fn named(numbers: &[usize], one: &str, several: &str) -> String {
    /// Most numbers that are listed.
    const LISTED: usize = 8;
    if let [number] = numbers {
        return format!("process {number} {one}");
    }
    let mut listed: Vec<String> = numbers.iter().take(LISTED).map(usize::to_string).collect();
    let last = if numbers.len() > LISTED {
        format!("{} more", numbers.len() - LISTED)
    } else {
        listed.pop().unwrap_or_default()
    };
    format!("processes {} and {last} {several}", listed.join(", "))
}

impl From<PetscError> for SolverError {
    fn from(error: PetscError) -> Self {
        SolverError::Other { solver: "PETSc", why: error.to_string(), history: ResidualHistory::default() }
    }
}

/// A failure of something that all processes do together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum DistributedError<E: std::error::Error> {
    /// This process failed.
    #[error(transparent)]
    Here(E),
    /// Others failed, and say why themselves.
    #[error("{count} of the other processes failed")]
    Elsewhere { count: usize },
    /// The exchange between the processes failed.
    #[error(transparent)]
    Petsc(#[from] PetscError),
}

impl From<DistributedError<PetscError>> for PetscError {
    fn from(error: DistributedError<PetscError>) -> Self {
        match error {
            DistributedError::Here(error) | DistributedError::Petsc(error) => error,
            DistributedError::Elsewhere { count } => PetscError::Elsewhere { count },
        }
    }
}

impl From<DistributedError<SolverError>> for SolverError {
    fn from(error: DistributedError<SolverError>) -> Self {
        match error {
            DistributedError::Here(error) => error,
            DistributedError::Petsc(error) => error.into(),
            DistributedError::Elsewhere { .. } => SolverError::Other {
                solver: "PETSc",
                why: error.to_string(),
                history: ResidualHistory::default(),
            },
        }
    }
}
