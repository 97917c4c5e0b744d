//! The Cholesky factor with signs of a symmetric saddle point, and whether refinement with it ends.

use std::time::Instant;

use super::{TangentSolver, analyse};
use crate::linear_algebra::equilibration::Equilibration;
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError, SymmetricFactor};
use crate::solve::linear_solver::SolverError;

/// Most steps of refinement of a whole solution.
pub(super) const REFINEMENTS: usize = 20;
/// The most of an error that a step of refinement may leave: twenty steps then come to rounding.
const RATE: f64 = 0.15;
/// A scaled matrix with a larger inverse goes to LU, which judges whether it is singular, and how well it determines a solution.
const ILL_CONDITIONED: f64 = 1e12;

impl TangentSolver {
    /// Factors a symmetric matrix with signs.
    ///
    /// # Errors
    /// [`SolverError::is_for_lu`] where the factor is not good enough for refinement.
    pub(super) fn factor_with_signs(&mut self, matrix: &CsrMatrix) -> Result<(), SolverError> {
        let scaling = Equilibration::of_saddle_point(matrix)?;
        let mut scaled = scaling.of_matrix(matrix).with_whole_diagonal()?;
        let storage = self.factor.take().map(SymmetricFactor::into_storage).unwrap_or_default();
        let analysis = match self.analysis.take() {
            Some(analysis) if analysis.fits(&scaled) => analysis,
            _ => {
                let (analysis, completed) = analyse(&scaled, &self.options, &mut self.report)?;
                self.fresh_iterations = None;
                scaled = completed.unwrap_or(scaled);
                analysis
            }
        };
        self.analysis = Some(analysis.clone());
        let start = Instant::now();
        let found = SymmetricFactor::signed_on(self.options.threads, &analysis, &scaled, storage)
            .and_then(|factor| is_good(&factor, &scaled).map(|()| factor));
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let factor = found?;
        self.report.factorisations += 1;
        self.report.signed_factorisations += 1;
        self.report.negative_eigenvalues = Some(factor.negative_eigenvalues());
        (self.scaling, self.scaled, self.factor) = (Some(scaling), Some(scaled), Some(factor));
        (self.factor_is_fresh, self.by_signs, self.refresh_wanted) = (true, true, false);
        Ok(())
    }
}

/// Fails unless refinement with a factor ends at a solution that the matrix determines.
fn is_good(factor: &SymmetricFactor, matrix: &CsrMatrix) -> Result<(), LinearAlgebraError> {
    let remainder = factor.remainder(matrix)?;
    // Without zeros on the diagonal, signs other than its own are those of a matrix for pivoting.
    let is_truly_indefinite =
        factor.turned_pivots(matrix) > 0 && !matrix.diagonal_above_rounding().contains(&0.0);
    if remainder.rate <= RATE && remainder.inverse_norm <= ILL_CONDITIONED && !is_truly_indefinite {
        return Ok(());
    }
    Err(LinearAlgebraError::Inaccurate { row: 0, backward_error: remainder.rate })
}
