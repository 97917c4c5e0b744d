//! Solutions with the factor of a symmetric matrix, for several right-hand sides at once.

use std::time::Instant;

use super::{TangentSolver, TangentSolverOptions, saddle_point};
use crate::linear_algebra::Transpose;
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::error::check_size;
use crate::solve::linear_solver::{LinearSolution, SolverError};
use crate::solve::solver_report::SolverPath;

/// A solution or an error for each of several right-hand sides.
type Each = Vec<Result<LinearSolution, SolverError>>;

impl TangentSolver {
    /// Solves a symmetric system for several right-hand sides, with the matrix as it was given; the factor's system may be a scaled one.
    ///
    /// # Errors
    /// No matrix, or those of the first solves with its factor.
    pub(super) fn solve_symmetric(
        &mut self,
        sides: &[&[f64]],
        transpose: Transpose,
    ) -> Result<Each, SolverError> {
        let size = self.matrix.as_ref().ok_or(SolverError::NoMatrix)?.rows();
        sides.iter().try_for_each(|b| check_size("the right-hand side", size, b.len()))?;
        let Some(scaling) = self.scaling.clone().filter(|_| self.scaled.is_some()) else {
            return self.solve_directly(sides, transpose);
        };
        let scaled: Vec<Vec<f64>> = sides.iter().map(|b| scaling.times(b)).collect();
        let loads: Vec<&[f64]> = scaled.iter().map(Vec::as_slice).collect();
        let found = self.solve_directly(&loads, transpose)?.into_iter();
        let given = sides.iter().zip(&scaled);
        let unscaled = found
            .zip(given)
            .map(|(found, (b, scaled))| self.unscaled(&scaling, (b, scaled), found?, transpose));
        Ok(unscaled.collect())
    }

    fn solve_directly(&mut self, sides: &[&[f64]], transpose: Transpose) -> Result<Each, SolverError> {
        let matrix = self.system()?;
        let factor = self.factor.as_ref().ok_or(SolverError::NoMatrix)?;
        let start = Instant::now();
        // The products of a symmetric matrix are faster than those of its transposed.
        let side = match self.equals_transposed {
            true => Side::of_symmetric(matrix),
            false => Side::of(matrix, transpose),
        };
        let TangentSolverOptions { threads, mut refinement_steps, .. } = self.options;
        if self.by_signs {
            refinement_steps = refinement_steps.max(saddle_point::REFINEMENTS);
        }
        // Without refinement nothing is measured by it.
        let matrix_norm = if refinement_steps == 0 { 0.0 } else { matrix.row_sum_norm() };
        let systems: Vec<_> = sides.iter().map(|b| (&side, *b)).collect();
        let refined = factor.solve_sides_refined(&systems, threads, matrix_norm, refinement_steps);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        let refined = refined?.into_iter().map(|one| {
            let refined = one?;
            let (solution, relative_residual) = (refined.solution, refined.relative_residual);
            Ok(LinearSolution { solution, relative_residual, iterations: 0 })
        });
        Ok(refined.collect())
    }

    /// Counts a solution.
    pub(super) fn count(&mut self, solution: &LinearSolution) {
        self.report.path = Some(match (self.by_lu, self.symmetric, self.is_positive_definite()) {
            _ if self.by_signs => SolverPath::SignedCholesky,
            (true, ..) => SolverPath::Lu,
            (_, false, _) => SolverPath::Gmres,
            (_, _, Some(false)) => SolverPath::Indefinite,
            _ => SolverPath::Cholesky,
        });
        self.report.solves += 1;
        self.report.iterations.push(solution.iterations);
        self.report.largest_residual = self.report.largest_residual.max(solution.relative_residual);
    }
}
