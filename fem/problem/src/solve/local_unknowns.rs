//! Elimination of unknowns that live in one cell or facet each, around any linear solver.

mod exchange;
mod of_spaces;
mod pencils;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Instant;

use exchange::{Exchange, groups_after_exchange};
#[doc(hidden)]
pub use of_spaces::groups_of;
pub(in crate::solve) use pencils::LeftPencil;

use super::linear_solver::{LinearSolution, LinearSolver, SolverError, one_after_the_other};
use super::{CondensedSolver, SolverReport, StepMemory, TangentSolver, TangentSolverOptions};
use crate::linear_algebra::backward_error::Refinement;
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{
    BlockElimination, Counts, CsrMatrix, Eliminated, Groups, SparsityPattern, Transpose,
};
use crate::threads::Threads;

/// Part of its terms by which an equation is off after rounding alone.
const ROUNDING: f64 = 1e-15;
/// Differences of partners up to which a matrix counts as symmetric.
const SYMMETRY: f64 = 1e-10;
/// Most steps of refinement to that; elimination loses digits where a group is much softer than what it is coupled with.
const REFINEMENTS: usize = 3;

/// Eliminates unknowns that live in one cell or facet each, as pressures of degree 0, enhanced strains or latent variables, and dual multipliers, and solves
/// what is left with another solver; a [`TangentSolver`] unless another is given. [`Problem`](super::Problem) uses it by default.
///
/// Elimination is exact: solutions are refined until each equation of the whole system holds, and are those of the whole system. What is left of a nearly
/// incompressible body is positive definite, so that the solver within takes a Cholesky factor. Spaces with discontinuous values
/// have such unknowns. Those that an entry couples with other cells stay, and so do groups with a pivot below 1e-10 of its scale, as
/// pressures of an incompressible body; [`SolverReport::local_unknowns`] counts them. Where what is left cannot be solved, the
/// solver within gets the whole matrix. A [`CondensedSolver`] within gets it too: its factor of the linear part eliminates
/// these unknowns with the others, but for those that contact changes.
///
/// ```
/// use forms_fem::prelude::*;
/// use forms_fem::solve::LocalUnknowns;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Quadrilateral, 1)?;
/// let (bodies, pressures) = (Space::vector(&mesh, 2)?, Space::discontinuous_scalar(&mesh, 0)?);
/// // A nearly incompressible body.
/// let form = form!(|u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>| {
///     integral(cells("all"), 2 * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - 1e-4 * p * q - v[0])
/// });
/// let mut held = Constraints::new(&bodies);
/// held.fix("left", |_| [0.0; 2])?;
/// let mut solver = LocalUnknowns::<TangentSolver>::default();
/// let problem = Problem::new(&form, [&bodies, &pressures]).constrained(&held);
/// let solved = problem.solver(&mut solver).solve()?;
/// let counts = solved.report.and_then(|report| report.local_unknowns);
/// assert_eq!(counts.map(|counts| counts.eliminated), Some(64));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct LocalUnknowns<S = TangentSolver> {
    solver: S,
    threads: Option<Threads>,
    groups: Groups,
    /// Whether matrices are parts of this process.
    is_divided: bool,
    elimination: Option<BlockElimination>,
    /// A pattern from which nothing is eliminated.
    whole: Option<Arc<SparsityPattern>>,
    current: Option<Current>,
    counts: Option<Counts>,
    seconds: f64,
}

/// The matrix of the next solves, where something was eliminated from it.
#[derive(Debug)]
struct Current {
    matrix: CsrMatrix,
    blocks: Eliminated,
    exchange: Option<Exchange>,
}

impl LocalUnknowns {
    /// Elimination around a [`TangentSolver`] on some threads.
    pub fn on(threads: Threads) -> Self {
        let options = TangentSolverOptions { threads, ..TangentSolverOptions::default() };
        LocalUnknowns::around(TangentSolver::new(options)).with_threads(threads)
    }
}

impl<S: LinearSolver> LocalUnknowns<S> {
    /// Elimination around a solver.
    pub fn around(solver: S) -> Self {
        LocalUnknowns {
            solver,
            threads: None,
            groups: Groups::default(),
            is_divided: false,
            elimination: None,
            whole: None,
            current: None,
            counts: None,
            seconds: 0.0,
        }
    }

    /// With this number of threads in place of all; the bits are the same.
    #[must_use]
    pub fn with_threads(self, threads: Threads) -> Self {
        LocalUnknowns { threads: Some(threads), ..self }
    }

    /// The solver of what is left.
    pub fn solver(&self) -> &S {
        &self.solver
    }

    pub(super) fn threads(&self) -> Threads {
        self.threads.unwrap_or_else(Threads::all)
    }

    /// Schur complement of a matrix, and its groups' blocks; none if nothing is eliminated.
    fn eliminate(
        &mut self,
        matrix: &CsrMatrix,
        groups: &Groups,
    ) -> Result<Option<(CsrMatrix, Eliminated)>, SolverError> {
        let is_whole = |pattern: &Arc<SparsityPattern>| {
            Arc::ptr_eq(pattern, matrix.pattern()) || **pattern == **matrix.pattern()
        };
        if self.whole.as_ref().is_some_and(is_whole) {
            return Ok(None);
        }
        let mut elimination = match self.elimination.take() {
            Some(known) if known.fits(matrix) => Some(known),
            _ => {
                let (found, counts) = BlockElimination::new(matrix.pattern(), groups)?;
                self.counts = Some(counts);
                found
            }
        };
        let threads = self.threads();
        while let Some(known) = elimination {
            match known.eliminate(threads, matrix)? {
                Ok(found) => {
                    self.counts = Some(known.counts());
                    self.elimination = Some(known);
                    return Ok(Some(found));
                }
                Err((next, counts)) => {
                    self.counts = Some(counts);
                    elimination = next;
                }
            }
        }
        self.whole = Some(matrix.pattern().clone());
        Ok(None)
    }

    /// Hands the whole matrix to the solver.
    fn set_whole(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.current = None;
        if let Some(counts) = &mut self.counts {
            counts.eliminated = 0;
        }
        self.solver.set_matrix(matrix)
    }

    /// Solves by the solver of what is left, and refines.
    fn solve_eliminated(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let threads = self.threads();
        let LocalUnknowns { solver, elimination, current, .. } = self;
        let (Some(elimination), Some(Current { matrix, blocks, exchange })) = (elimination, current) else {
            return Err(SolverError::NoMatrix);
        };
        check_size("the right-hand side", matrix.rows(), b.len())?;
        crate::linear_algebra::error::check_finite("the right-hand side", b)?;
        let mut iterations = 0;
        let mut solve = |b: &[f64], tolerance: f64| -> Result<Vec<f64>, SolverError> {
            let exchanged = exchange.as_ref().map(|exchange| exchange.right_hand_side(b, transpose));
            let b = exchanged.as_deref().unwrap_or(b);
            let reduced = elimination.reduce(blocks, b, transpose)?;
            let found = solver.solve_with(&reduced, tolerance, transpose)?;
            iterations += found.iterations;
            let whole = elimination.recover(blocks, b, &found.solution, transpose)?;
            Ok(exchange.as_ref().map(|exchange| exchange.solution(&whole, transpose)).unwrap_or(whole))
        };
        let side = Side::of(matrix, transpose);
        let x = solve(b, absolute_tolerance)?;
        let mut found = Refinement::new(&side, threads, b, x)?;
        if !found.is_enough(absolute_tolerance) {
            for _ in 0..REFINEMENTS {
                if found.residual.worst().error <= ROUNDING {
                    break;
                }
                found.step(|change| {
                    *change = solve(change, 0.0)?;
                    Ok::<(), SolverError>(())
                })?;
                let is_better = norm(&found.next.rest) < norm(&found.residual.rest);
                if !is_better || found.next.worst().error > found.residual.worst().error {
                    break;
                }
                found.accept();
            }
            found.finish(|change| {
                *change = solve(change, 0.0)?;
                Ok::<(), SolverError>(())
            })?;
        }
        let scale = norm(b);
        let relative_residual = if scale == 0.0 { 0.0 } else { norm(&found.residual.rest) / scale };
        Ok(LinearSolution { solution: found.x, relative_residual, iterations })
    }
}

impl<S: LinearSolver> LinearSolver for LocalUnknowns<S> {
    fn set_processes(&mut self, count: usize) -> Result<(), SolverError> {
        self.is_divided = count > 1;
        self.solver.set_processes(count)
    }

    fn set_local_unknowns(&mut self, groups: Groups) {
        if groups != self.groups {
            (self.elimination, self.whole, self.counts, self.current) = (None, None, None, None);
            self.groups = groups;
        }
    }

    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        if self.groups.is_empty() || self.is_divided || self.solver.as_condensed().is_some() {
            return self.set_whole(matrix);
        }
        if self.current.as_ref().is_some_and(|current| current.matrix == matrix) {
            return Ok(());
        }
        self.current = None;
        check_size("the set of columns of a square matrix", matrix.rows(), matrix.columns())?;
        matrix.check_finite()?;
        let start = Instant::now();
        let exchange = match self.groups.multipliers() {
            [] => None,
            // What is symmetric stays so.
            _ if matrix.is_symmetric(SYMMETRY)? => None,
            _ => Exchange::new(&matrix, &self.groups),
        };
        let found = match &exchange {
            Some(exchange) => {
                let groups = groups_after_exchange(&self.groups);
                exchange
                    .matrix(&matrix)
                    .map_err(SolverError::from)
                    .and_then(|matrix| self.eliminate(&matrix, &groups))
            }
            None => self.eliminate(&matrix, &self.groups.clone()),
        };
        self.seconds += start.elapsed().as_secs_f64();
        let Some((left, blocks)) = found? else { return self.set_whole(matrix) };
        match self.solver.set_matrix(left) {
            Ok(()) => self.current = Some(Current { matrix, blocks, exchange }),
            // An error of the whole matrix names its own unknowns.
            Err(error) if error.is_for_lu() => return self.set_whole(matrix),
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        if self.current.is_none() {
            return self.solver.solve_with(b, absolute_tolerance, transpose);
        }
        match self.solve_eliminated(b, absolute_tolerance, transpose) {
            Err(error) if error.is_for_lu() => {
                let Some(Current { matrix, .. }) = self.current.take() else { return Err(error) };
                self.set_whole(matrix)?;
                self.solver.solve_with(b, absolute_tolerance, transpose)
            }
            found => found,
        }
    }

    fn solve_each(
        &mut self,
        sides: &[&[f64]],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<Vec<LinearSolution>, SolverError> {
        match self.current {
            None => self.solver.solve_each(sides, absolute_tolerance, transpose),
            Some(_) => one_after_the_other(self, sides, absolute_tolerance, transpose),
        }
    }

    fn memory(&mut self) -> Option<&mut StepMemory> {
        self.solver.memory()
    }

    fn judges_equations(&self) -> bool {
        self.current.is_some() || self.solver.judges_equations()
    }

    fn pattern(&self) -> Option<&Arc<SparsityPattern>> {
        match &self.elimination {
            Some(known) => Some(known.pattern()),
            None => self.solver.pattern(),
        }
    }

    fn report(&self) -> Option<SolverReport> {
        let mut report = self.solver.report()?;
        report.local_unknowns = self.counts;
        report.factorisation_seconds += self.seconds;
        Some(report)
    }

    fn as_condensed(&mut self) -> Option<&mut CondensedSolver> {
        self.solver.as_condensed()
    }
}
