//! Solutions by the factor of K and dense factors, of several systems at once: right-hand sides of one matrix, or of several matrices that K is a part of.

use std::sync::Arc;
use std::time::Instant;

use super::{Condensed, CondensedSolver, Current, LinearPart};
use crate::linear_algebra::backward_error::{Residual, Rule, refine_each};
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::error::{check_finite, check_size};
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{CondensedSide, LinearAlgebraError, Transpose};
use crate::solve::linear_solver::{LinearSolution, LinearSolver, SolverError};
use crate::solve::solver_report::SolverPath;

/// Relative residual below which refinement of the whole solution stops.
const ACCURATE: f64 = 1e-15;
/// Most steps of iterative refinement of the whole solution.
const REFINEMENTS: usize = 4;

/// Systems that wait for others to be solved together with the factor of K, and what was found of earlier ones.
#[derive(Debug, Default)]
pub(super) struct Kept {
    waiting: Vec<(Condensed, Arc<[f64]>)>,
    solved: Vec<Result<KeptSolution, SolverError>>,
}

/// The solution of a system that was kept.
#[derive(Debug)]
pub(in crate::solve) struct KeptSolution {
    pub found: LinearSolution,
    /// b − A x.
    pub rest: Vec<f64>,
}

/// A right-hand side of a system.
#[derive(Clone, Copy)]
struct Column<'a> {
    system: &'a Condensed,
    b: &'a [f64],
    transpose: Transpose,
    tolerance: f64,
}

impl CondensedSolver {
    /// Keeps the current matrix with a right-hand side until [`CondensedSolver::take_kept`]. False: it is no linear part with additions, and has to be
    /// solved with now.
    ///
    /// # Errors
    /// A right-hand side that is unfit.
    pub(in crate::solve) fn keep(&mut self, b: &Arc<[f64]>) -> Result<bool, SolverError> {
        let (Some(Current::Condensed(system)), Some(LinearPart { matrix, .. })) =
            (&self.current, &self.linear_part)
        else {
            return Ok(false);
        };
        // Another matrix that is stored as a whole would take as much memory as the linear part.
        if !Arc::ptr_eq(&system.matrix.base, matrix) {
            return Ok(false);
        }
        check_size("the right-hand side", matrix.rows(), b.len())?;
        check_finite("the right-hand side", b)?;
        self.kept.waiting.push((system.clone(), b.clone()));
        Ok(true)
    }

    /// Solves the systems that were kept: their solutions, in the order in which they came.
    pub(in crate::solve) fn take_kept(&mut self) -> Vec<Result<KeptSolution, SolverError>> {
        self.solve_waiting();
        std::mem::take(&mut self.kept.solved)
    }

    /// Forgets systems that were kept.
    pub(in crate::solve) fn forget_kept(&mut self) {
        self.kept = Kept::default();
    }

    /// Solves systems that wait, with the factor that they have been condensed with.
    pub(super) fn solve_waiting(&mut self) {
        let waiting = std::mem::take(&mut self.kept.waiting);
        let columns: Vec<Column<'_>> = waiting
            .iter()
            .map(|(system, b)| Column { system, b, transpose: Transpose::No, tolerance: 0.0 })
            .collect();
        if columns.is_empty() {
            return;
        }
        let found = match self.solve_columns(&columns) {
            Ok(found) => found,
            Err(error) => columns.iter().map(|_| Err(error.clone())).collect(),
        };
        self.kept.solved.extend(found);
    }

    /// Solutions for several right-hand sides of one matrix.
    pub(super) fn solve_condensed_each(
        &mut self,
        system: &Condensed,
        sides: &[&[f64]],
        tolerance: f64,
        transpose: Transpose,
    ) -> Result<Vec<LinearSolution>, SolverError> {
        let count = sides.len();
        let named = |number: usize| move |error: SolverError| error.of_side(number, count);
        for (number, b) in sides.iter().enumerate() {
            let fits = check_size("the right-hand side", system.matrix.base.rows(), b.len())
                .and_then(|()| check_finite("the right-hand side", b));
            fits.map_err(|error| named(number)(error.into()))?;
        }
        let columns: Vec<Column<'_>> =
            sides.iter().map(|b| Column { system, b, transpose, tolerance }).collect();
        let found = self.solve_columns(&columns)?.into_iter().enumerate();
        found.map(|(number, one)| one.map(|one| one.found).map_err(named(number))).collect()
    }

    /// Solves columns together, and those by the fallback that cannot be solved so.
    fn solve_columns(
        &mut self,
        columns: &[Column<'_>],
    ) -> Result<Vec<Result<KeptSolution, SolverError>>, SolverError> {
        let start = Instant::now();
        let found = self.condensed_columns(columns);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        let mut solutions = vec![];
        for (found, column) in found?.into_iter().zip(columns) {
            solutions.push(match found {
                Some(found) => {
                    self.report.solves += 1;
                    self.report.path = Some(SolverPath::Condensed);
                    self.report.iterations.push(0);
                    let residual = found.found.relative_residual;
                    self.report.largest_residual = self.report.largest_residual.max(residual);
                    Ok(found)
                }
                None => self.by_fallback(column),
            });
        }
        Ok(solutions)
    }

    /// The solution by the fallback, which takes over.
    fn by_fallback(&mut self, column: &Column<'_>) -> Result<KeptSolution, SolverError> {
        let Column { system, b, transpose, tolerance } = *column;
        self.fall_back(system.matrix.to_matrix()?)?;
        let found = self.fallback.solve_with(b, tolerance, transpose)?;
        let side = system.matrix.side(transpose);
        let rest = Residual::of(&side, self.fallback.threads(), &found.solution, b)?.rest;
        Ok(KeptSolution { found, rest })
    }

    /// Solutions by the factor of K; none where an equation does not hold.
    fn condensed_columns(&self, columns: &[Column<'_>]) -> Result<Vec<Option<KeptSolution>>, SolverError> {
        let condensation = self.condensation.as_ref().ok_or(SolverError::NoMatrix)?;
        let solve = |numbers: &[usize], sides: Vec<Vec<f64>>| -> Result<_, LinearAlgebraError> {
            let mut systems = vec![];
            for (k, b) in numbers.iter().zip(&sides) {
                let Column { system, transpose, .. } = columns[*k];
                systems.push(CondensedSide { b, dense: system.dense.as_deref(), transpose });
            }
            condensation.solve_each(&systems)
        };
        let sides: Vec<Side<'_>> =
            columns.iter().map(|column| column.system.matrix.side(column.transpose)).collect();
        let systems: Vec<_> = sides.iter().zip(columns).map(|(side, column)| (side, column.b)).collect();
        let scales: Vec<f64> = columns.iter().map(|column| norm(column.b)).collect();
        let relative = |k: usize, rest: &[f64]| if scales[k] == 0.0 { 0.0 } else { norm(rest) / scales[k] };
        let error = |k: usize, _: &[f64], residual: &Residual| relative(k, &residual.rest);
        let is_enough = |k: usize, error: f64| error <= ACCURATE || error * scales[k] <= columns[k].tolerance;
        let rule = Rule { steps: REFINEMENTS, error: &error, is_enough: &is_enough };
        let refined = refine_each(self.fallback.threads(), &systems, &rule, solve)?;
        let mut solutions = vec![];
        for (k, (mut found, _)) in refined.into_iter().enumerate() {
            // Each equation has to hold in its own scale, exactly or as far as the caller asks.
            let holds = found.is_enough(columns[k].tolerance)
                || found
                    .finish(|change| -> Result<(), LinearAlgebraError> {
                        *change = solve(&[k], vec![std::mem::take(change)])?.swap_remove(0);
                        Ok(())
                    })
                    .is_ok();
            solutions.push(holds.then(|| {
                let relative_residual = relative(k, &found.residual.rest);
                let found_at = LinearSolution { solution: found.x, relative_residual, iterations: 0 };
                KeptSolution { found: found_at, rest: found.residual.rest }
            }));
        }
        Ok(solutions)
    }
}
