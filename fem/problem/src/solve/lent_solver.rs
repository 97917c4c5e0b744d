//! The linear solver of a loop over steps: its own, or one that is lent to it.

use super::{LinearSolver, LocalUnknowns};
use crate::threads::Threads;

/// A linear solver of one's own, or a lent one.
#[doc(hidden)]
pub enum LentSolver<'a> {
    Own(Box<LocalUnknowns>),
    Lent(&'a mut dyn LinearSolver),
}

impl Default for LentSolver<'_> {
    fn default() -> Self {
        LentSolver::Own(Box::default())
    }
}

impl LentSolver<'_> {
    /// A number of threads for a solver of one's own; a lent one has its own.
    pub fn set_threads(&mut self, threads: Threads) {
        if let LentSolver::Own(solver) = self {
            **solver = LocalUnknowns::on(threads);
        }
    }

    /// Whichever it is.
    pub fn get(&mut self) -> &mut dyn LinearSolver {
        match self {
            LentSolver::Own(solver) => &mut **solver,
            LentSolver::Lent(solver) => &mut **solver,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::LentSolver;
    use crate::solve::TangentSolver;
    use crate::threads::Threads;

    #[test]
    fn the_threads_of_a_loop_reach_its_own_solver_and_no_other() {
        let mut own = LentSolver::default();
        own.set_threads(Threads::new(3));
        let LentSolver::Own(solver) = &own else { panic!("a solver of its own") };
        assert_eq!(solver.solver().threads(), Threads::new(3));
        let mut given = TangentSolver::default();
        let all = given.threads();
        LentSolver::Lent(&mut given).set_threads(Threads::new(3));
        assert_eq!(given.threads(), all);
    }
}
