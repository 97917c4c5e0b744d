//! Solver for tangents that are symmetric, or unsymmetric on few unknowns; saddle points go to LU.

use std::sync::Arc;
use std::time::Instant;

use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use super::lu_solver::LuSolver;
use super::solver_report::{SolverPath, SolverReport};
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::singularity::check_regular;
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{
    Analysis, ConditionEstimate, CsrMatrix, GmresError, GmresOptions, GmresReport, Ordering, SymmetricFactor,
    condition_estimate, gmres,
};
use crate::threads::Threads;

/// Choices of a [`TangentSolver`].
#[derive(Clone, Debug, PartialEq)]
pub struct TangentSolverOptions {
    /// Elimination order of the factor.
    pub ordering: Ordering,
    /// A matrix whose [`CsrMatrix::asymmetry`] is at most this is solved as a symmetric one (and refined
    /// with the matrix as it is).
    pub symmetry_tolerance: f64,
    /// Relative residual that GMRES aims at.
    pub tolerance: f64,
    /// Relative residual at which stagnation is accepted as rounding.
    pub accepted: f64,
    /// Basis vectors that GMRES keeps.
    pub restart: usize,
    /// Most GMRES iterations of one solve.
    pub max_iterations: usize,
    /// The factor of an earlier matrix is replaced, at the next matrix, once a solve with it takes this many
    /// iterations more than with a matrix's own factor. None: as many as a factorisation costs, estimated
    /// from the symbolic analysis.
    pub refresh_after: Option<usize>,
    /// Most steps of iterative refinement of a direct solution.
    pub refinement_steps: usize,
    /// Threads for products and dot products of GMRES. Factorisations and triangular solves run on one, so that
    /// solutions are the same for each number of threads.
    pub threads: Threads,
}

impl Default for TangentSolverOptions {
    fn default() -> Self {
        Self {
            ordering: Ordering::default(),
            symmetry_tolerance: 1e-12,
            tolerance: 1e-13,
            accepted: 1e-11,
            restart: 60,
            max_iterations: 300,
            refresh_after: None,
            refinement_steps: 3,
            threads: Threads::all(),
        }
    }
}

/// A factor with a pivot below this part of its scale is asked whether the matrix is singular.
const DOUBTFUL: f64 = 1e-9;

/// A symmetric matrix is factored (LLᵀ, or LBLᵀ if it is indefinite) and solved directly with refinement. An
/// unsymmetric one is solved by GMRES, preconditioned with the factor of the symmetric part of itself or of an
/// earlier matrix; its transpose too, with the same factor. Analysis and factor are kept between matrices.
///
/// A matrix with a zero on its diagonal (a saddle point) is factored by LU with partial pivoting, because LBLᵀ
/// pivots inside supernodes only; so is every matrix on which the other ways fail.
#[derive(Debug, Default)]
pub struct TangentSolver {
    options: TangentSolverOptions,
    analysis: Option<Arc<Analysis>>,
    factor: Option<SymmetricFactor>,
    matrix: Option<CsrMatrix>,
    symmetric: bool,
    /// Whether the factor is of the matrix's own symmetric part.
    factor_is_fresh: bool,
    /// GMRES iterations of the last solve with a fresh factor.
    fresh_iterations: Option<usize>,
    refresh_wanted: bool,
    lu: LuSolver,
    /// The current matrix has a null vector, so that LU would not help.
    proved_singular: bool,
    /// The current matrix is factored by LU.
    by_lu: bool,
    /// Matrices of this many unknowns defeated the other factors: LU from the start.
    lu_size: Option<usize>,
    report: SolverReport,
}

impl TangentSolver {
    /// A solver without a matrix yet.
    pub fn new(options: TangentSolverOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// What was done so far.
    pub fn report(&self) -> &SolverReport {
        &self.report
    }

    /// The current matrix.
    pub fn matrix(&self) -> Option<&CsrMatrix> {
        self.matrix.as_ref()
    }

    /// Whether the current matrix is treated as symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    /// Whether the current factor is an LLᵀ, so that the symmetric part it was made of is positive definite.
    pub fn is_positive_definite(&self) -> Option<bool> {
        self.factor.as_ref().map(SymmetricFactor::is_positive_definite)
    }

    /// Estimates the condition of the current matrix in the 1-norm by about five solves, and reports it.
    ///
    /// # Errors
    /// If there is no matrix, or a solve fails.
    pub fn estimate_condition(&mut self) -> Result<ConditionEstimate, SolverError> {
        let matrix = self.matrix.clone().ok_or(SolverError::NoMatrix)?;
        let this = std::cell::RefCell::new(&mut *self);
        let solved = |x: &mut Vec<f64>, transposed| -> Result<(), SolverError> {
            *x = this.borrow_mut().solve_side(x, 0.0, transposed)?.solution;
            Ok(())
        };
        let found = condition_estimate(&matrix, |x| solved(x, false), |x| solved(x, true))?;
        self.report.condition = Some(found.condition);
        Ok(found)
    }

    /// Factors the symmetric part of the current matrix.
    fn refactor(&mut self) -> Result<(), SolverError> {
        let matrix = self.matrix.as_ref().ok_or(SolverError::NoMatrix)?;
        let own_part;
        let part = if self.symmetric {
            matrix
        } else {
            own_part = matrix.symmetric_part()?;
            &own_part
        };
        let storage = self.factor.take().map(SymmetricFactor::into_storage).unwrap_or_default();
        let analysis = match self.analysis.take() {
            Some(analysis) if analysis.fits(part) => analysis,
            _ => {
                let analysis = Arc::new(Analysis::new(part.pattern(), &self.options.ordering)?);
                self.report.analyses += 1;
                self.report.analysis_seconds += analysis.seconds();
                self.report.factor_entries = analysis.factor_entries();
                self.report.orderings = analysis.candidates().to_vec();
                self.fresh_iterations = None;
                analysis
            }
        };
        self.analysis = Some(analysis.clone());
        let start = Instant::now();
        let result = SymmetricFactor::cholesky_or_indefinite(&analysis, part, storage);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let factor = result?;
        if !factor.is_positive_definite() || factor.smallest_pivot_ratio() < DOUBTFUL {
            let found = check_regular(part, |y| factor.solve_in_place(y));
            self.proved_singular = self.symmetric && found.is_err();
            found?;
        }
        self.report.factorisations += 1;
        self.report.indefinite_factorisations += usize::from(!factor.is_positive_definite());
        self.factor = Some(factor);
        self.factor_is_fresh = true;
        self.refresh_wanted = false;
        Ok(())
    }

    /// Hands the current matrix to LU.
    fn factor_by_lu(&mut self) -> Result<(), SolverError> {
        let matrix = self.matrix.clone().ok_or(SolverError::NoMatrix)?;
        self.lu_size = Some(matrix.rows());
        self.by_lu = true;
        let start = Instant::now();
        let result = self.lu.set_matrix(matrix);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        self.report.lu_factorisations += usize::from(result.is_ok());
        result
    }

    fn solve_by_lu(&mut self, b: &[f64], transposed: bool) -> Result<LinearSolution, SolverError> {
        let start = Instant::now();
        let solution = self.lu.solve_side(b, 0.0, transposed);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        solution
    }

    fn solve_directly(&mut self, b: &[f64]) -> Result<LinearSolution, SolverError> {
        let (Some(matrix), Some(factor)) = (&self.matrix, &self.factor) else {
            return Err(SolverError::NoMatrix);
        };
        let start = Instant::now();
        let refined = factor.solve_refined(matrix, b, self.options.refinement_steps);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        let refined = refined?;
        Ok(LinearSolution {
            solution: refined.solution,
            relative_residual: refined.relative_residual,
            iterations: 0,
        })
    }

    fn solve_iteratively(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transposed: bool,
    ) -> Result<LinearSolution, SolverError> {
        loop {
            let mut x = vec![0.0; b.len()];
            let start = Instant::now();
            let result = self.run_gmres(b, &mut x, absolute_tolerance, transposed);
            self.report.solve_seconds += start.elapsed().as_secs_f64();
            let report = match result {
                Ok(report) => report,
                Err(GmresError::Operator(error)) => return Err(error),
                Err(
                    GmresError::Stagnated(report)
                    | GmresError::NotConverged(report)
                    | GmresError::NotFinite(report),
                ) => {
                    if report.relative_residual <= self.options.accepted {
                        report
                    } else if self.factor_is_fresh {
                        return Err(SolverError::NotConverged(report));
                    } else {
                        // The factor of an earlier matrix was not good enough: take this matrix's own.
                        self.refactor()?;
                        continue;
                    }
                }
                Err(GmresError::BadArguments { solution, right_hand_side, .. }) => {
                    check_size("the right-hand side", solution, right_hand_side)?;
                    return Err(SolverError::NotConverged(GmresReport::default()));
                }
            };
            if self.factor_is_fresh {
                self.fresh_iterations = Some(report.iterations);
            } else {
                let usual = self.fresh_iterations.unwrap_or(0);
                self.refresh_wanted |= report.iterations > usual + self.worthwhile_excess();
            }
            return Ok(LinearSolution {
                solution: x,
                relative_residual: report.relative_residual,
                iterations: report.iterations,
            });
        }
    }

    /// Iterations that cost as much as a factorisation. Measured in 2D: a factorisation with 85 and 168
    /// multiplications per stored number took the time of 5 and 10 iterations.
    fn worthwhile_excess(&self) -> usize {
        let estimate = self.analysis.as_ref().map_or(0.0, |analysis| {
            analysis.multiplications() / (17.0 * analysis.factor_entries().max(1) as f64)
        });
        self.options.refresh_after.unwrap_or(estimate as usize)
    }

    fn run_gmres(
        &self,
        b: &[f64],
        x: &mut [f64],
        absolute_tolerance: f64,
        transposed: bool,
    ) -> Result<GmresReport, GmresError<SolverError>> {
        let (Some(matrix), Some(factor)) = (&self.matrix, &self.factor) else {
            return Err(GmresError::Operator(SolverError::NoMatrix));
        };
        if !norm(b).is_finite() {
            crate::linear_algebra::error::check_finite("the right-hand side", b)
                .map_err(|error| GmresError::Operator(error.into()))?;
        }
        let options = GmresOptions {
            tolerance: self.options.tolerance,
            absolute_tolerance,
            restart: self.options.restart,
            max_iterations: self.options.max_iterations,
            operator_norm: Some(if transposed { matrix.column_sum_norm() } else { matrix.row_sum_norm() }),
            flexible: false,
            threads: self.options.threads,
        };
        gmres(
            |v, w| match transposed {
                false => matrix.multiply_on(self.options.threads, v, w).map_err(SolverError::from),
                true => matrix.multiply_transposed_into(v, w).map_err(SolverError::from),
            },
            |v| factor.solve_in_place(v).map_err(SolverError::from),
            b,
            x,
            &options,
        )
    }
}

impl LinearSolver for TangentSolver {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        if (self.factor_is_fresh || self.by_lu) && self.matrix.as_ref() == Some(&matrix) {
            return Ok(()); // an adjoint problem with the tangent that is already factored
        }
        (self.matrix, self.factor_is_fresh, self.by_lu) = (None, false, false);
        self.proved_singular = false;
        check_size("the set of columns of a square matrix", matrix.rows(), matrix.columns())?;
        matrix.check_finite()?;
        self.symmetric = matrix.is_symmetric(self.options.symmetry_tolerance)?;
        let fits = self.factor.as_ref().is_some_and(|factor| factor.analysis().size() == matrix.rows());
        let known = self.lu_size == Some(matrix.rows());
        let saddle = (0..matrix.rows()).any(|row| matrix.get(row, row) == 0.0);
        self.matrix = Some(matrix);
        let mut result = Ok(());
        if known || saddle {
            result = self.factor_by_lu();
        } else if self.symmetric || self.refresh_wanted || !fits {
            result = self.refactor();
            if result.as_ref().is_err_and(SolverError::is_for_lu) && !self.proved_singular {
                result = self.factor_by_lu();
            }
        }
        if result.is_err() {
            self.matrix = None;
        }
        result
    }

    fn solve_side(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transposed: bool,
    ) -> Result<LinearSolution, SolverError> {
        let matrix = self.matrix.as_ref().ok_or(SolverError::NoMatrix)?;
        check_size("the right-hand side", matrix.rows(), b.len())?;
        let found = if self.by_lu {
            self.solve_by_lu(b, transposed)
        } else if self.symmetric {
            self.solve_directly(b)
        } else {
            self.solve_iteratively(b, absolute_tolerance, transposed)
        };
        let solution = match found {
            Err(error) if !self.by_lu && error.is_for_lu() => {
                self.factor_by_lu()?;
                self.solve_by_lu(b, transposed)?
            }
            found => found?,
        };
        self.report.path = Some(match (self.by_lu, self.symmetric, self.is_positive_definite()) {
            (true, ..) => SolverPath::Lu,
            (_, false, _) => SolverPath::Gmres,
            (_, _, Some(false)) => SolverPath::Indefinite,
            _ => SolverPath::Cholesky,
        });
        self.report.solves += 1;
        self.report.iterations.push(solution.iterations);
        self.report.largest_residual = self.report.largest_residual.max(solution.relative_residual);
        Ok(solution)
    }
}

#[cfg(test)]
mod tests;
