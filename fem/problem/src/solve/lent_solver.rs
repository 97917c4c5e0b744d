//! The linear solver of a loop over steps: its own, or one that is lent to it.

use super::{LinearSolver, LocalUnknowns};

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
    /// Whichever it is.
    pub fn get(&mut self) -> &mut dyn LinearSolver {
        match self {
            LentSolver::Own(solver) => &mut **solver,
            LentSolver::Lent(solver) => &mut **solver,
        }
    }
}
