//! Direct solver for any square matrix: LU with partial pivoting and iterative refinement.

use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use crate::linear_algebra::vector::{add_scaled, largest, norm};
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError, LuFactor};

/// Backward error at which refinement has nothing left to gain.
const ROUNDING: f64 = 2e-16;
/// Largest backward error of a solution that is handed out.
const ACCEPTED: f64 = 1e-10;
/// Most steps of iterative refinement; with partial pivoting one nearly always suffices.
const REFINEMENTS: usize = 2;

/// Factors each matrix by LU with partial pivoting. It is what a [`super::TangentSolver`] turns to when a
/// matrix has zeros on its diagonal, as saddle points have, or defeats its own factors.
#[derive(Debug, Default)]
pub struct LuSolver {
    system: Option<(CsrMatrix, LuFactor)>,
    /// Numeric factorisations so far.
    factorisations: usize,
}

impl LuSolver {
    /// Numeric factorisations so far.
    pub fn factorisations(&self) -> usize {
        self.factorisations
    }

    /// The current matrix.
    pub fn matrix(&self) -> Option<&CsrMatrix> {
        self.system.as_ref().map(|(matrix, _)| matrix)
    }
}

impl LinearSolver for LuSolver {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        if self.matrix() == Some(&matrix) {
            return Ok(()); // an adjoint problem with the tangent that is already factored
        }
        let earlier = self.system.take().filter(|(known, _)| known.same_pattern(&matrix));
        let factor = LuFactor::new(&matrix, earlier.as_ref().map(|(_, factor)| factor))?;
        self.factorisations += 1;
        self.system = Some((matrix, factor));
        Ok(())
    }

    fn solve_side(
        &mut self,
        b: &[f64],
        _absolute_tolerance: f64,
        transposed: bool,
    ) -> Result<LinearSolution, SolverError> {
        let (matrix, factor) = self.system.as_ref().ok_or(SolverError::NoMatrix)?;
        let matrix_norm = if transposed { matrix.column_sum_norm() } else { matrix.row_sum_norm() };
        let residual = |x: &[f64]| -> Result<(Vec<f64>, f64), LinearAlgebraError> {
            let mut rest = if transposed { matrix.multiply_transposed(x)? } else { matrix.multiply(x)? };
            for (rest, b) in rest.iter_mut().zip(b) {
                *rest = b - *rest;
            }
            let scale = matrix_norm * largest(x) + largest(b);
            let backward_error = if scale == 0.0 { 0.0 } else { largest(&rest) / scale };
            Ok((rest, backward_error))
        };
        let mut x = b.to_vec();
        factor.solve_in_place(&mut x, transposed)?;
        let (mut rest, mut backward_error) = residual(&x)?;
        // The first step also helps where the backward error is at rounding: rows of small entries, as those
        // of a constraint beside a stiffness, profit from it.
        for step in 0..REFINEMENTS {
            if step > 0 && backward_error <= ROUNDING {
                break;
            }
            let mut change = rest.clone();
            factor.solve_in_place(&mut change, transposed)?;
            add_scaled(&mut change, 1.0, &x);
            let (next, next_error) = residual(&change)?;
            if next_error > backward_error || norm(&next) >= norm(&rest) {
                break;
            }
            (x, rest, backward_error) = (change, next, next_error);
        }
        if backward_error > ACCEPTED || backward_error.is_nan() {
            return Err(LinearAlgebraError::Inaccurate { backward_error }.into());
        }
        let scale = norm(b);
        let relative_residual = if scale == 0.0 { 0.0 } else { norm(&rest) / scale };
        Ok(LinearSolution { solution: x, relative_residual, iterations: 0 })
    }
}
