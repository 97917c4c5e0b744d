//! Solution of the discrete problems: prescribed unknowns, linear solvers with memory, semismooth Newton.
//!
//! [`newton()`] asks a [`NonlinearProblem`] for residuals and tangents, an [`Elimination`] takes the
//! prescribed unknowns out, and a [`LinearSolver`] (the [`TangentSolver`] unless another is given) solves.
//! [`FormProblem`] (one unknown) and [`MixedProblem`] (several) make such a problem of a compiled form.
//! A [`MultigridSolver`] takes large systems in space.
//! The solver keeps its factor, so that adjoint problems with the tangent or its transpose reuse it.

mod assembled_once;
pub mod condensed_solver;
#[cfg(test)]
mod contrasts;
pub mod elimination;
pub mod linear_solver;
pub mod load_steps;
pub mod lu_solver;
pub mod mixed_problem;
pub mod multigrid_solver;
pub mod newton;
mod node_blocks;
pub mod problem;
pub mod reaction;
pub mod solver_report;
pub mod tangent_solver;

pub use condensed_solver::CondensedSolver;
pub use elimination::{Elimination, solve_linear, solve_linear_transposed};
pub use linear_solver::{LinearSolution, LinearSolver, SolverError};
pub use load_steps::{LoadPath, LoadStep, LoadStepError, LoadSteps};
pub use lu_solver::LuSolver;
pub use mixed_problem::{LinearProblemError, MixedProblem, MixedSolved};
pub use multigrid_solver::{MultigridSolver, MultigridSolverOptions, MultigridSolverReport};
pub use newton::{
    ActivePoints, LineSearch, NewtonError, NewtonFailure, NewtonOptions, NewtonSolution, NewtonStep,
    NonlinearProblem, Start, Tangent, newton, newton_eliminating,
};
pub use problem::{FormProblem, Solved};
pub use reaction::ReactionError;
pub use solver_report::{SolverPath, SolverReport};
pub use tangent_solver::{TangentSolver, TangentSolverOptions};
