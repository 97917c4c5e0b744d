//! Direct solver for any square matrix: LU with iterative refinement, with partial pivoting where the matrix asks for it.

use std::sync::Arc;

use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use crate::linear_algebra::Transpose;
use crate::linear_algebra::backward_error::{Refinement, Residual};
use crate::linear_algebra::equations::{Equations, Side};
use crate::linear_algebra::spectrum::irregular;
use crate::linear_algebra::vector::{largest, norm};
use crate::linear_algebra::{
    Analysis, CsrMatrix, LinearAlgebraError, LuFactor, Ordering, SparsityPattern, UnpivotedLu,
};
use crate::threads::Threads;

/// Backward error at which refinement has nothing left to gain.
const ROUNDING: f64 = 2e-16;
/// Part of its terms by which an equation is off after rounding alone.
const ROUNDING_OF_ROWS: f64 = 1e-15;
/// A scaled matrix whose smallest singular value is below this part of its norm may leave a solution three digits or fewer: it is
/// asked for each solution what rounding of the matrix makes of it.
const ILL_CONDITIONED: f64 = 1e-13;
/// Largest effect of rounding on a solution, as a part of its largest entry.
const UNCERTAIN: f64 = 1e-6;
/// Most steps of iterative refinement of the whole solution; with partial pivoting one nearly always suffices.
const REFINEMENTS: usize = 2;

/// Smaller matrices are factored with partial pivoting from the start.
const SMALL: usize = 500;

/// A solver that factors each matrix by LU, and refines each solution until every equation holds relative to the sizes
/// of its own terms. It is what a [`super::TangentSolver`] turns to when a
/// matrix has zeros on its diagonal, as saddle points have, or defeats its own factors.
///
/// Large matrices without zeros on the diagonal get an [`UnpivotedLu`] on all threads, with twice the memory and time of a symmetric factor.
/// Where that is not accurate, and for all other regular matrices, an [`LuFactor`] pivots on one thread. Solutions are the same on any
/// number of threads. The last matrix and its factor are kept: for
/// an adjoint problem with the same tangent, for solves with other right-hand sides, and to look at the matrix.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Quadrilateral, 1)?;
/// let space = Space::scalar(&mesh, 1)?;
/// let mut walls = Constraints::new(&space);
/// walls.fix("boundary", |_| 0.0)?;
/// // Diffusion in a wind: the matrix is not symmetric.
/// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| {
///     integral(cells("all"), dot(grad(u), grad(v)) + 10.0 * grad(u)[0] * v - v)
/// });
/// let mut solver = LuSolver::default();
/// let u = Problem::new(&form, &space).constrained(&walls).solver(&mut solver).solve()?.into_field();
/// assert!(u.evaluate(&[0.75, 0.5])?[0] > u.evaluate(&[0.25, 0.5])?[0]);
///
/// // Rows and columns of the matrix are the free unknowns, here those of the inner nodes; Aᵀ x = b by the same factor.
/// let b = vec![1.0; walls.free().len()];
/// let x = solver.solve_transposed(&b, 0.0)?.solution;
/// assert_eq!((x.len(), solver.matrix().map(|a| a.rows())), (49, Some(49)));
/// assert_eq!(solver.factorisations(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct LuSolver {
    threads: Threads,
    system: Option<(CsrMatrix, Factor)>,
    /// A pattern with the analysis of its symmetric completion.
    analysis: Option<(Arc<SparsityPattern>, Arc<Analysis>)>,
    /// Numeric factorisations so far.
    factorisations: usize,
}

/// A factor of the current matrix.
#[derive(Debug)]
enum Factor {
    Unpivoted(UnpivotedLu),
    Pivoted(Box<LuFactor>),
}

impl Factor {
    fn solve_in_place(&self, b: &mut [f64], transpose: Transpose) -> Result<(), LinearAlgebraError> {
        match self {
            Factor::Unpivoted(factor) => factor.solve_in_place(b, transpose),
            Factor::Pivoted(factor) => factor.solve_in_place(b, transpose),
        }
    }
}

impl LuSolver {
    /// A solver that uses some threads.
    pub fn on(threads: Threads) -> Self {
        LuSolver { threads, ..LuSolver::default() }
    }

    /// Whether the current factor was found without exchanges of rows.
    pub fn is_unpivoted(&self) -> bool {
        matches!(self.system, Some((_, Factor::Unpivoted(_))))
    }

    /// Takes an analysis of a pattern that the next matrix may have.
    pub(super) fn share(&mut self, analysis: &Arc<Analysis>) {
        if self.analysis.is_none() {
            self.analysis = Some((analysis.pattern().clone(), analysis.clone()));
        }
    }

    /// Whether a matrix is large enough, and has no zeros on its diagonal, rounding included.
    pub(super) fn may_be_unpivoted(matrix: &CsrMatrix) -> bool {
        matrix.rows() >= SMALL && !matrix.diagonal_above_rounding().contains(&0.0)
    }

    /// Factors a matrix without exchanges of rows. False: it is small, or has zeros on its diagonal, or the factor is not accurate.
    pub(super) fn factor_unpivoted(&mut self, matrix: &CsrMatrix) -> bool {
        if !Self::may_be_unpivoted(matrix) {
            return false;
        }
        let is_unpivoted = self.is_unpivoted();
        let storage = match self.system.take_if(|_| is_unpivoted) {
            Some((_, Factor::Unpivoted(factor))) => factor.into_storage(),
            _ => vec![],
        };
        // Whatever the reason of a failure is, pivoting has a judgement of its own.
        let Ok(factor) = self.unpivoted(matrix, storage) else { return false };
        self.factorisations += 1;
        self.system = Some((matrix.clone(), Factor::Unpivoted(factor)));
        true
    }

    fn unpivoted(
        &mut self,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<UnpivotedLu, LinearAlgebraError> {
        let pattern = matrix.pattern();
        let known = self.analysis.take().filter(|(known, _)| Arc::ptr_eq(known, pattern) || known == pattern);
        let analysis = match known {
            Some((_, analysis)) => analysis,
            None => {
                let found = Analysis::of_symmetric_on(self.threads, matrix, &Ordering::default(), &[])?;
                Arc::new(found.0)
            }
        };
        self.analysis = Some((pattern.clone(), analysis.clone()));
        match analysis.fits(matrix) {
            true => UnpivotedLu::new_on(self.threads, &analysis, matrix, storage),
            false => {
                let completed = matrix.on_pattern(analysis.pattern())?;
                UnpivotedLu::new_on(self.threads, &analysis, &completed, storage)
            }
        }
    }

    fn factor_pivoted(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        let earlier = match self.system.take() {
            Some((known, Factor::Pivoted(factor))) if known.same_pattern(&matrix) => Some(factor),
            _ => None,
        };
        let factor = LuFactor::new(&matrix, earlier.as_deref())?;
        self.factorisations += 1;
        self.system = Some((matrix, Factor::Pivoted(Box::new(factor))));
        Ok(())
    }

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
        if self.factor_unpivoted(&matrix) {
            return Ok(());
        }
        self.factor_pivoted(matrix)
    }

    fn judges_equations(&self) -> bool {
        true
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let found = self.refined(b, absolute_tolerance, transpose);
        let is_for_pivots = found.as_ref().is_err_and(SolverError::is_for_lu) && self.is_unpivoted();
        match self.system.take_if(|_| is_for_pivots) {
            Some((matrix, _)) => {
                self.factor_pivoted(matrix)?;
                self.refined(b, absolute_tolerance, transpose)
            }
            None => found,
        }
    }
}

impl LuSolver {
    /// A solution with the current factor.
    fn refined(
        &self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let (matrix, factor) = self.system.as_ref().ok_or(SolverError::NoMatrix)?;
        let matrix_norm =
            if transpose == Transpose::Yes { matrix.column_sum_norm() } else { matrix.row_sum_norm() };
        let side = Side::of(matrix, transpose);
        let whole = |x: &[f64], residual: &Residual| {
            let scale = matrix_norm * largest(x) + largest(b);
            if scale == 0.0 { 0.0 } else { largest(&residual.rest) / scale }
        };
        let solve = |change: &mut Vec<f64>| factor.solve_in_place(change, transpose);
        let mut x = b.to_vec();
        solve(&mut x)?;
        let mut found = Refinement::new(&side, self.threads, b, x)?;
        let mut backward_error = whole(&found.x, &found.residual);
        // The first step also helps where the backward error is at rounding: rows of small entries, as those
        // of a constraint next to a stiffness, profit from it, unless they are at rounding themselves.
        for step in 0..REFINEMENTS {
            let rows_are_at_rounding = found.residual.worst().error <= ROUNDING_OF_ROWS;
            if rows_are_at_rounding || step > 0 && backward_error <= ROUNDING {
                break;
            }
            found.step(solve)?;
            let next_error = whole(found.candidate(), &found.next);
            if next_error > backward_error || norm(&found.next.rest) >= norm(&found.residual.rest) {
                break;
            }
            found.accept();
            backward_error = next_error;
        }
        // Each equation has to hold in its own scale, or as far as the caller asks where it cannot.
        match found.finish(solve) {
            Err(error) if !found.is_enough(absolute_tolerance) => return Err(error.into()),
            _ => {}
        }
        let Refinement { x, residual, .. } = found;
        if let Factor::Pivoted(factor) = factor
            && factor.smallest_ratio() <= ILL_CONDITIONED
        {
            // Rounding of the entries, with signs that follow no pattern, as forces on the solution.
            let sizes = side.products(&x)?.1;
            let noise = sizes.iter().zip(irregular(x.len()));
            let mut moved: Vec<f64> = noise.map(|(size, sign)| f64::EPSILON * size * sign).collect();
            solve(&mut moved)?;
            let of = |x: &[f64]| factor.largest_scaled(x, transpose);
            if of(&moved) > UNCERTAIN * of(&x) {
                let (unknown, condition) = (factor.least_determined(), 1.0 / factor.smallest_ratio());
                return Err(LinearAlgebraError::IllConditioned { unknown, condition }.into());
            }
        }
        let scale = norm(b);
        let relative_residual = if scale == 0.0 { 0.0 } else { norm(&residual.rest) / scale };
        Ok(LinearSolution { solution: x, relative_residual, iterations: 0 })
    }
}

#[cfg(test)]
mod tests;
