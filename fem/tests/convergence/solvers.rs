//! The linear solvers that problems are solved with.

use forms_fem::prelude::*;
use forms_fem::solve::LuSolver;

/// Number of solvers.
pub const COUNT: usize = 3;

/// One of them, by its number.
pub fn solver(number: usize) -> (&'static str, Box<dyn LinearSolver>) {
    match number % COUNT {
        0 => ("TangentSolver", Box::new(TangentSolver::default())),
        1 => ("LuSolver", Box::new(LuSolver::default())),
        _ => ("CondensedSolver", Box::new(CondensedSolver::default())),
    }
}
