//! Solution of the discrete problems: prescribed unknowns, linear solvers with memory, semismooth Newton.
//!
//! [`newton()`] asks a [`NonlinearProblem`] for residuals and tangents, an [`Elimination`] takes the
//! prescribed unknowns out, and a [`LinearSolver`] (the [`TangentSolver`] unless another is given) solves.
//! A [`Problem`] makes such a problem of a compiled form with one or several unknowns, and solves itself.
//! A [`Continuation`] follows a branch of solutions through limit points and bifurcations.
//! A [`MultigridSolver`] takes large systems in space. An [`Eigenproblem`] of two forms gives vibrations and buckling loads.
//! The solver keeps its factor, so that adjoint problems with the tangent or its transpose reuse it.

pub mod communicator;
pub mod condensed_solver;
pub mod continuation;
#[cfg(test)]
mod contrasts;
pub mod deflation;
pub mod divided;
pub mod eigenproblem;
pub mod elimination;
mod floating;
mod lent_solver;
mod linear_and_nonlinear;
mod linear_part;
pub mod linear_solver;
pub mod linear_system;
pub mod load_steps;
pub mod local_unknowns;
pub mod lu_solver;
pub mod multigrid_solver;
pub mod newton;
mod node_blocks;
pub mod per_unknown;
pub mod problem;
mod processes;
mod rigid_loads;
pub mod solved;
pub mod solver_report;
mod step_memory;
pub mod tangent_solver;

pub use crate::assemble::Terms;
pub use communicator::{CommunicationError, Communicator, agreed, on_part_of_cells, summed};
pub use condensed_solver::CondensedSolver;
pub use continuation::{
    Branch, BranchEnd, BranchEvent, BranchPoint, Continuation, ContinuationError, ContinuationFailure,
    EventKind, Inertia,
};
pub use deflation::Deflation;
pub use divided::DividedVectors;
pub use eigenproblem::{Eigenmode, Eigenproblem, EigenproblemError};
pub use elimination::Elimination;
pub use floating::Floating;
#[doc(hidden)]
pub use lent_solver::LentSolver;
pub use linear_solver::{LinearSolution, LinearSolver, SolverError};
pub use linear_system::{solve_linear, solve_linear_transposed};
pub use load_steps::{
    CommittingSteps, Extrapolate, Increment, LoadPath, LoadStep, LoadStepError, LoadSteps, StepStart,
};
pub use local_unknowns::LocalUnknowns;
#[doc(hidden)]
pub use local_unknowns::groups_of;
pub use lu_solver::LuSolver;
pub use multigrid_solver::{MultigridSolver, MultigridSolverOptions, MultigridSolverReport};
pub use newton::{
    ActivePoints, BoundFailure, FieldUnknowns, HeldUnknown, LineSearch, LinearPart, NewtonError,
    NewtonFailure, NewtonOptions, NewtonSolution, NewtonStep, NonlinearProblem, NonlinearTangent,
    Oscillation, PartlyLinear, PrescribedValues, Products, Remedy, Start, SwitchingPoint, Tangent,
    UnknownBounds, WorstEquation, newton, newton_bounded, newton_eliminating,
};
pub use per_unknown::PerUnknown;
#[doc(hidden)]
pub use problem::agreement::GivenEquations;
pub use problem::{LinearProblems, PositivityError, Problem, SolveError};
#[doc(hidden)]
pub use problem::{OwnedForm, SolvedForm, solve_owned};
#[doc(hidden)]
pub use processes::Processes;
pub use rigid_loads::{RigidLoadError, RigidLoads};
pub use solved::{ReactionError, Solved};
pub use solver_report::{SolverPath, SolverReport};
#[doc(hidden)]
pub use step_memory::StepMemory;
pub use tangent_solver::{TangentSolver, TangentSolverOptions};

pub use crate::linear_algebra::Transpose;
