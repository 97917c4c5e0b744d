//! Linear solvers: what Newton's method and adjoint problems ask of them.

use std::sync::Arc;

use super::condensed_solver::CondensedSolver;
use super::elimination::Elimination;
use super::floating::Floating;
use super::solver_report::SolverReport;
use super::step_memory::StepMemory;
use crate::linear_algebra::{
    BlockMatrix, CsrMatrix, GmresReport, Groups, KrylovReport, LinearAlgebraError, ResidualHistory,
    SparsityPattern, Transpose,
};

/// A solver of systems with one square matrix after another. An implementation may keep whatever serves the next
/// matrix: the analysis of the pattern, a factor.
pub trait LinearSolver {
    /// Says that the coming matrices are parts of this process, which add up over `count` processes to the matrix that is meant; 1: that
    /// they are whole. A problem says it before it sets a matrix.
    ///
    /// # Errors
    /// [`SolverError::Processes`] of a solver that does not add up matrices of as many processes.
    fn set_processes(&mut self, count: usize) -> Result<(), SolverError> {
        if count <= 1 { Ok(()) } else { Err(SolverError::Processes { problem: count, solver: 1 }) }
    }

    /// Says which unknowns of the coming matrices live in one cell or facet each, so that a solver may eliminate them before others: see
    /// [`LocalUnknowns`](super::LocalUnknowns). A problem says it before it sets a matrix. Other solvers do not use it.
    #[doc(hidden)]
    fn set_local_unknowns(&mut self, _groups: Groups) {}

    /// Takes the matrix of the next solves.
    ///
    /// # Errors
    /// If the matrix cannot be factored.
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError>;

    /// Takes the matrix of the next solves as the part of a larger one that an elimination leaves.
    ///
    /// # Errors
    /// As [`LinearSolver::set_matrix`], and if the matrix does not fit the elimination.
    #[doc(hidden)]
    fn set_reduced(
        &mut self,
        matrix: &BlockMatrix,
        elimination: &mut Elimination,
    ) -> Result<(), SolverError> {
        let known = self.pattern().cloned();
        self.set_matrix(elimination.reduce_matrix_sharing(matrix, known.as_ref())?)
    }

    /// The memory that one problem leaves to the next, of a solver that keeps it.
    #[doc(hidden)]
    fn memory(&mut self) -> Option<&mut StepMemory> {
        None
    }

    /// Solves A x = b or Aᵀ x = b, so that each equation holds relative to the sizes of its own terms,
    /// |b − A x|_i small relative to (|A| |x| + |b|)_i: fields of different units and parts of different stiffness are right
    /// each in its own scale. A residual ‖b − A x‖₂ ≤ `absolute_tolerance` is good enough for the caller, who would gain
    /// nothing from a smaller one, if no equation is left aside, that is, off by more than about a thousandth of its
    /// terms; 0 asks for the solver's own accuracy. Direct solvers may ignore it.
    ///
    /// # Errors
    /// If no matrix was set, the size is wrong, or no accurate solution was found.
    fn solve_with(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError>;

    /// Solves A x = b or Aᵀ x = b for several right-hand sides, each as [`LinearSolver::solve_with`] does, with the bits that its solution has by itself as
    /// long as none fails. Direct solvers read their factor once for all of them; unless a solver says otherwise, one is solved after the
    /// other.
    ///
    /// ```
    /// use forms_fem::linear_algebra::{CsrMatrix, Transpose};
    /// use forms_fem::prelude::*;
    ///
    /// let mut solver = TangentSolver::default();
    /// solver.set_matrix(CsrMatrix::from_triplets(2, 2, &[(0, 0, 2.0), (1, 1, 4.0)])?)?;
    /// let found = solver.solve_each(&[&[1.0, 0.0], &[0.0, 1.0]], 0.0, Transpose::No)?;
    /// assert!((found[0].solution[0] - 0.5).abs() < 1e-15 && (found[1].solution[1] - 0.25).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`LinearSolver::solve_with`]; of several right-hand sides [`SolverError::OfSeveral`] with the number of the first that failed.
    fn solve_each(
        &mut self,
        sides: &[&[f64]],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<Vec<LinearSolution>, SolverError> {
        one_after_the_other(self, sides, absolute_tolerance, transpose)
    }

    /// Solves A x = b.
    ///
    /// # Errors
    /// As [`LinearSolver::solve_with`].
    fn solve(&mut self, b: &[f64], absolute_tolerance: f64) -> Result<LinearSolution, SolverError> {
        self.solve_with(b, absolute_tolerance, Transpose::No)
    }

    /// Solves Aᵀ x = b.
    ///
    /// # Errors
    /// As [`LinearSolver::solve_with`].
    fn solve_transposed(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
    ) -> Result<LinearSolution, SolverError> {
        self.solve_with(b, absolute_tolerance, Transpose::Yes)
    }

    /// Whether solutions are handed out only if each equation holds relative to the sizes of its own terms. Of a solver that
    /// does not see to it, affine problems look at each solution themselves.
    fn judges_equations(&self) -> bool {
        false
    }

    /// The number of negative eigenvalues of the matrix, which is symmetric, by the signs of pivots; none of a solver that does not count
    /// them. An eigenproblem on several processes needs it.
    ///
    /// # Errors
    /// If no matrix was set, or its factor failed.
    fn negative_eigenvalues(&mut self) -> Result<Option<usize>, SolverError> {
        Ok(None)
    }

    /// The pattern that the solver keeps of earlier matrices: one with the same entries takes less memory if it shares it.
    fn pattern(&self) -> Option<&Arc<SparsityPattern>> {
        None
    }

    /// The solver's account of itself, where it keeps one.
    fn report(&self) -> Option<SolverReport> {
        None
    }

    /// The [`CondensedSolver`] that this solver is, or to which it delegates: Newton's method then iterates on the unknowns that
    /// the nonlinearity touches.
    fn as_condensed(&mut self) -> Option<&mut CondensedSolver> {
        None
    }
}

/// Solutions for several right-hand sides, one after the other.
pub(super) fn one_after_the_other<S: LinearSolver + ?Sized>(
    solver: &mut S,
    sides: &[&[f64]],
    absolute_tolerance: f64,
    transpose: Transpose,
) -> Result<Vec<LinearSolution>, SolverError> {
    let count = sides.len();
    let solve = |(number, b): (usize, &&[f64])| {
        solver.solve_with(b, absolute_tolerance, transpose).map_err(|error| error.of_side(number, count))
    };
    sides.iter().enumerate().map(solve).collect()
}

/// The solution of one linear system, and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSolution {
    /// The solution x.
    pub solution: Vec<f64>,
    /// ‖b − A x‖₂ / ‖b‖₂, computed from x (0 if b = 0).
    pub relative_residual: f64,
    /// Iterations of a Krylov method; 0 for a direct solution.
    pub iterations: usize,
}

/// A reason why a linear system was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum SolverError {
    /// The matrix or a vector is unfit, or the factorisation failed.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
    /// The matrix is singular, and an unknown that it does not determine.
    #[error(
        "the matrix is singular: nothing determines {}`{field}` at {position:?} (a pivot is {ratio:e} of its scale); \
         {}",
        of(component),
        floating
    )]
    Undetermined {
        field: &'static str,
        /// Its component, where it has several.
        component: Option<usize>,
        position: Vec<f64>,
        /// As in [`LinearAlgebraError::Singular`].
        ratio: f64,
        /// The body or tool that moves freely there.
        floating: Floating,
    },
    /// The matrix is close to a singular one, and an unknown that it hardly determines.
    #[error(
        "the matrix is ill-conditioned: its condition is at least {condition:e}, and it hardly determines {}`{field}` \
         at {position:?}; a part may be held by a much softer one, or the spaces do not fit each other",
        of(component)
    )]
    IllConditioned {
        field: &'static str,
        /// Its component, where it has several.
        component: Option<usize>,
        position: Vec<f64>,
        /// As in [`LinearAlgebraError::IllConditioned`].
        condition: f64,
    },
    /// The solution that was found is none of an equation.
    #[error(
        "the solution is inaccurate: the equation of {}`{field}` at {position:?} is off by {backward_error:e} of its \
         terms",
        of(component)
    )]
    Inaccurate {
        /// Name of the unknown in the form to which the equation belongs.
        field: &'static str,
        /// Its component, where it has several.
        component: Option<usize>,
        position: Vec<f64>,
        /// As in [`LinearAlgebraError::Inaccurate`].
        backward_error: f64,
    },
    /// A solver that takes whole matrices where each process has a part, or the other way round.
    #[error("{}", other_processes(*problem, *solver))]
    Processes {
        /// Number of processes among which the problem's matrix is divided.
        problem: usize,
        /// Number of processes whose matrices the solver adds up.
        solver: usize,
    },
    /// One of several right-hand sides for which a matrix was to be solved with.
    #[error("right-hand side {} of {count}: {why}", number + 1)]
    OfSeveral {
        /// Its number, from 0.
        number: usize,
        /// Number of all.
        count: usize,
        why: Box<SolverError>,
    },
    /// A solve was asked for before a matrix was set.
    #[error("no matrix was given to the linear solver")]
    NoMatrix,
    /// The Krylov method did not reach an acceptable residual.
    #[error(
        "the Krylov method stopped at relative residual {:e} after {} iterations",
        .0.relative_residual, .0.iterations
    )]
    NotConverged(GmresReport),
    /// An iterative method failed.
    #[error("{method} failed: {why}")]
    Krylov {
        method: &'static str,
        why: String,
        /// The work done, with the history of residuals.
        report: KrylovReport,
    },
    /// A failure of a solver from outside of this crate.
    #[error("{solver} failed: {why}{}", residuals(history))]
    Other {
        solver: &'static str,
        why: String,
        /// Norms of the residuals of its iterations, where it has some.
        history: ResidualHistory,
    },
}

impl SolverError {
    /// The failure, whichever right-hand side it is of.
    pub(super) fn of_any_side(self) -> Self {
        match self {
            SolverError::OfSeveral { why, .. } => *why,
            error => error,
        }
    }

    /// The failure of a right-hand side among several.
    pub(super) fn of_side(self, number: usize, count: usize) -> Self {
        if count == 1 { self } else { SolverError::OfSeveral { number, count, why: Box::new(self) } }
    }

    /// Whether LU may succeed after this failure.
    pub(super) fn is_for_lu(&self) -> bool {
        matches!(
            self,
            SolverError::NotConverged(_)
                | SolverError::LinearAlgebra(
                    LinearAlgebraError::Singular { .. }
                        | LinearAlgebraError::NotPositiveDefinite { .. }
                        | LinearAlgebraError::Inaccurate { .. }
                        | LinearAlgebraError::IllConditioned { .. }
                        | LinearAlgebraError::VectorNotFinite { what: "the solution", .. }
                )
        )
    }
}

fn of(component: &Option<usize>) -> String {
    component.map(|component| format!("component {component} of ")).unwrap_or_default()
}

fn other_processes(problem: usize, solver: usize) -> String {
    if problem > solver {
        return format!(
            "the problem is solved on {problem} processes, and each has a part of the matrix, but the linear solver takes whole \
             matrices: give the problem one that adds up the parts (`PetscSolver` of forms-distributed), or leave out `.on(..)`"
        );
    }
    format!(
        "the linear solver adds up the matrices of {solver} processes, and each of them has the whole matrix, so that the solution would \
         be divided by their number: write `.on(&world)` before `.solve()` (who sets matrices without a problem calls \
         `set_processes`)"
    )
}

fn residuals(history: &ResidualHistory) -> String {
    if history.0.is_empty() { String::new() } else { format!("; residuals: {history:?}") }
}

#[cfg(test)]
mod tests {
    use crate::linear_algebra::{GmresReport, KrylovReport, ResidualHistory};
    use crate::solve::SolverError;

    #[test]
    fn an_error_prints_the_end_of_its_history() {
        let history: Vec<f64> = (0..1000).map(|k| 1.0 / f64::from(k + 1)).collect();
        let other = ResidualHistory(history.clone());
        let other = SolverError::Other { solver: "PETSc", why: "no".into(), history: other };
        for printed in [format!("{other:?}"), other.to_string()] {
            assert!(printed.contains("995 residuals, then [") && printed.len() < 300, "{printed}");
        }
        let report = GmresReport { history: history.clone(), iterations: 999, ..GmresReport::default() };
        let printed = format!("{:?}", SolverError::NotConverged(report));
        assert!(printed.contains("995 residuals, then [") && printed.len() < 300, "{printed}");
        let report = KrylovReport { history, iterations: 999, relative_residual: 1e-3 };
        let printed = format!("{:?}", SolverError::Krylov { method: "cg", why: "no".into(), report });
        assert!(printed.contains("0.001]") && printed.len() < 300, "{printed}");
        let short = KrylovReport { history: vec![1.0, 0.5], ..KrylovReport::default() };
        assert!(format!("{short:?}").contains("history: [1.0, 0.5]"), "{short:?}");
    }
}
