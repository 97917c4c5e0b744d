//! Solver for tangents that are symmetric, also saddle points, or unsymmetric on few unknowns; others go to LU.

mod direct;
mod iterative;
mod saddle_point;
mod unsymmetric;

use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;

use self::unsymmetric::UnpivotedFactors;
use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use super::lu_solver::LuSolver;
use super::solver_report::SolverReport;
use crate::linear_algebra::Transpose;
use crate::linear_algebra::backward_error::Residual;
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::equilibration::Equilibration;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::singularity::check_regular;
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{
    Analysis, ConditionEstimate, CsrMatrix, LinearAlgebraError, Ordering, SparsityPattern, SymmetricFactor,
    condition_estimate,
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
    /// Relative residual that GMRES aims at. Each equation has to hold besides, up to a hundred times this part of its
    /// own terms; where one does not, GMRES goes on from the residual.
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
    /// Unsymmetric matrices are factored by LU without pivoting, from the next one on, once a solve with a matrix's own symmetric factor takes
    /// more than this number of iterations. None: as many as LU costs, estimated from the symbolic analysis. `usize::MAX`: never. LU takes
    /// twice the memory.
    pub lu_after: Option<usize>,
    /// Most steps of iterative refinement of a direct solution.
    pub refinement_steps: usize,
    /// Threads for factors LLᵀ, LSLᵀ and LU with their solves, and for products and dot products of GMRES; solutions are the same for each
    /// number of them. Factors LBLᵀ, and LU with pivoting, run on one.
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
            lu_after: None,
            refinement_steps: 3,
            threads: Threads::all(),
        }
    }
}

/// A factor with a pivot below this part of its scale is asked whether the matrix is singular.
const DOUBTFUL: f64 = 1e-9;

/// A symmetric matrix is factored (LLᵀ, or LBLᵀ if it is indefinite) and solved directly with refinement. An
/// unsymmetric one is solved by GMRES, preconditioned with the factor of the symmetric part of itself or of an
/// earlier matrix; its transpose too, with the same factor. Where that takes longer, the next ones are factored by LU without
/// pivoting, on all threads. Analysis and factor are kept between matrices.
///
/// A symmetric matrix with zeros or negative numbers on its diagonal, as a saddle point has, gets a Cholesky factor with signs,
/// on all threads, and solutions are refined against the matrix. An unsymmetric saddle point is factored by LU with partial
/// pivoting, and so is every matrix on which the other ways fail. Where rows differ much in size, as
/// those of a stiff and a soft part or of fields in different units, the matrix is scaled first. A solution is handed out
/// if each equation holds relative to its own terms.
#[derive(Debug, Default)]
pub struct TangentSolver {
    options: TangentSolverOptions,
    analysis: Option<Arc<Analysis>>,
    factor: Option<SymmetricFactor>,
    matrix: Option<CsrMatrix>,
    /// The scaling that the factor was made with, and the current matrix scaled by it, where rows differ in size.
    scaling: Option<Equilibration>,
    scaled: Option<CsrMatrix>,
    symmetric: bool,
    /// The matrix is symmetric to the last bit.
    equals_transposed: bool,
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
    /// Whether the current factor is of a saddle point, with signs.
    by_signs: bool,
    /// Matrices of this many unknowns defeated the other factors: LU from the start.
    lu_size: Option<usize>,
    /// Whether the next unsymmetric matrix is factored by LU, where that is known.
    unpivoted: Option<UnpivotedFactors>,
    report: SolverReport,
}

impl TangentSolver {
    /// A solver without a matrix yet.
    pub fn new(options: TangentSolverOptions) -> Self {
        let lu = LuSolver::on(options.threads);
        Self { options, lu, ..Self::default() }
    }

    /// A solver with the same options that knows no matrix.
    pub(super) fn anew(&self) -> Self {
        Self::new(self.options.clone())
    }

    /// The work done so far.
    pub fn report(&self) -> &SolverReport {
        &self.report
    }

    /// Threads for factors, solves and products.
    pub(super) fn threads(&self) -> Threads {
        self.options.threads
    }

    /// Threads of the current factor.
    #[cfg(test)]
    pub(super) fn threads_of_factor(&self) -> Option<Threads> {
        self.factor.as_ref().map(SymmetricFactor::threads)
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

    /// The number of negative eigenvalues of the current matrix, where it is symmetric and its own factor tells.
    pub fn negative_eigenvalues(&self) -> Option<usize> {
        let tells = self.matrix.is_some() && self.symmetric && self.factor_is_fresh && !self.by_lu;
        self.factor.as_ref().filter(|_| tells).map(SymmetricFactor::negative_eigenvalues)
    }

    /// Estimate of the current matrix's condition in the 1-norm, by about five solves; it is also reported.
    ///
    /// # Errors
    /// If there is no matrix, or a solve fails.
    pub fn estimate_condition(&mut self) -> Result<ConditionEstimate, SolverError> {
        let matrix = self.matrix.clone().ok_or(SolverError::NoMatrix)?;
        let this = std::cell::RefCell::new(&mut *self);
        let solved = |x: &mut Vec<f64>, transpose| -> Result<(), SolverError> {
            *x = this.borrow_mut().solve_with(x, 0.0, transpose)?.solution;
            Ok(())
        };
        let found = condition_estimate(&matrix, |x| solved(x, Transpose::No), |x| solved(x, Transpose::Yes))?;
        self.report.condition = Some(found.condition);
        Ok(found)
    }

    /// The matrix that is factored and solved with.
    fn system(&self) -> Result<&CsrMatrix, SolverError> {
        self.scaled.as_ref().or(self.matrix.as_ref()).ok_or(SolverError::NoMatrix)
    }

    /// Factors the symmetric part of the current matrix.
    fn refactor(&mut self) -> Result<(), SolverError> {
        let matrix = self.scaled.as_ref().or(self.matrix.as_ref()).ok_or(SolverError::NoMatrix)?;
        let mut part = match self.symmetric {
            true => Cow::Borrowed(matrix),
            false => Cow::Owned(matrix.symmetric_part()?),
        };
        let storage = self.factor.take().map(SymmetricFactor::into_storage).unwrap_or_default();
        let analysis = match self.analysis.take() {
            Some(analysis) if analysis.fits(&part) => analysis,
            _ => {
                let (analysis, completed) = analyse(&part, &self.options, &mut self.report)?;
                self.fresh_iterations = None;
                part = completed.map_or(part, Cow::Owned);
                analysis
            }
        };
        self.analysis = Some(analysis.clone());
        let start = Instant::now();
        let result =
            SymmetricFactor::cholesky_or_indefinite_on(self.options.threads, &analysis, &part, storage);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let factor = result?;
        if !factor.is_positive_definite() || factor.smallest_pivot_ratio() < DOUBTFUL {
            let found = check_regular(&part, |y| factor.solve_in_place(y));
            // LU, which pivots, has a judgement of its own of what is only ill-conditioned.
            let singular = matches!(found, Err(LinearAlgebraError::Singular { .. }));
            self.proved_singular = self.symmetric && singular;
            found?;
        }
        self.report.factorisations += 1;
        self.report.indefinite_factorisations += usize::from(!factor.is_positive_definite());
        if !factor.is_positive_definite() {
            self.report.negative_eigenvalues = Some(factor.negative_eigenvalues());
        }
        self.factor = Some(factor);
        self.factor_is_fresh = true;
        self.refresh_wanted = false;
        Ok(())
    }

    /// Hands the current matrix to LU.
    fn factor_by_lu(&mut self) -> Result<(), SolverError> {
        let matrix = self.matrix.clone().ok_or(SolverError::NoMatrix)?;
        self.by_signs = false;
        (self.by_lu, self.scaled) = (true, None); // LU has a scaling of its own
        self.share_analysis();
        let start = Instant::now();
        let result = self.lu.set_matrix(matrix);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        self.report.lu_factorisations += usize::from(result.is_ok());
        result
    }

    fn solve_by_lu(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let start = Instant::now();
        let solution = self.lu.solve_with(b, absolute_tolerance, transpose);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        solution
    }

    /// Solves with the matrix as it was given; the factor's system is a scaled one.
    fn solve_scaled(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        if self.symmetric {
            return self.solve_symmetric(&[b], transpose)?.swap_remove(0);
        }
        match self.scaling.clone().filter(|_| self.scaled.is_some()) {
            None => self.solve_iteratively(b, absolute_tolerance, transpose),
            Some(scaling) => {
                let scaled = scaling.times(b);
                // One number is no tolerance for equations of different units.
                let found = self.solve_iteratively(&scaled, 0.0, transpose)?;
                self.unscaled(&scaling, (b, &scaled), found, transpose)
            }
        }
    }

    /// A solution of the matrix as it was given, from that of the scaled system.
    fn unscaled(
        &self,
        scaling: &Equilibration,
        (b, scaled): (&[f64], &[f64]),
        found: LinearSolution,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let side = Side::of(self.system()?, transpose);
        let residual = Residual::of(&side, self.options.threads, &found.solution, scaled)?;
        let scale = norm(b);
        Ok(LinearSolution {
            solution: scaling.times(&found.solution),
            relative_residual: if scale == 0.0 {
                0.0
            } else {
                norm(&scaling.divided(&residual.rest)) / scale
            },
            iterations: found.iterations,
        })
    }
}

/// Analyses the pattern of a symmetric matrix, and completes the matrix where entries are stored on one side only.
fn analyse(
    matrix: &CsrMatrix,
    options: &TangentSolverOptions,
    report: &mut SolverReport,
) -> Result<(Arc<Analysis>, Option<CsrMatrix>), SolverError> {
    let (analysis, completed) = Analysis::of_symmetric_on(options.threads, matrix, &options.ordering, &[])?;
    report.analyses += 1;
    report.analysis_seconds += analysis.seconds();
    report.factor_entries = analysis.factor_entries();
    report.factorisation_work = Some(analysis.factorisation_work());
    report.solve_work = Some(analysis.solve_work());
    report.orderings = analysis.candidates().to_vec();
    Ok((Arc::new(analysis), completed))
}

impl LinearSolver for TangentSolver {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        if (self.factor_is_fresh || self.by_lu) && self.matrix.as_ref() == Some(&matrix) {
            return Ok(()); // an adjoint problem with the tangent that is already factored
        }
        (self.matrix, self.scaled, self.factor_is_fresh, self.by_lu) = (None, None, false, false);
        (self.proved_singular, self.by_signs) = (false, false);
        check_size("the set of columns of a square matrix", matrix.rows(), matrix.columns())?;
        matrix.check_finite()?;
        let asymmetry = matrix.asymmetry()?;
        (self.symmetric, self.equals_transposed) =
            (asymmetry <= self.options.symmetry_tolerance, asymmetry == 0.0);
        let known = self.lu_size == Some(matrix.rows());
        let diagonal = matrix.diagonal_above_rounding();
        let saddle = diagonal.contains(&0.0);
        if self.symmetric && !known && diagonal.iter().any(|value| *value <= 0.0) {
            let found = self.factor_with_signs(&matrix);
            match found {
                Ok(()) => {
                    self.matrix = Some(matrix);
                    return Ok(());
                }
                Err(error) if !error.is_for_lu() => return Err(error),
                // It does not help the next matrix, either.
                Err(_) if saddle => self.lu_size = Some(matrix.rows()),
                Err(_) => {}
            }
        }
        if !self.symmetric && !known && self.factor_unpivoted(&matrix) {
            self.matrix = Some(matrix);
            return Ok(());
        }
        let fits = self.factor.as_ref().is_some_and(|factor| factor.analysis().size() == matrix.rows());
        // LU scales by itself.
        let scales = !known && !saddle;
        let scaling = if scales { Equilibration::of(&matrix) } else { None };
        // A factor that is kept asks for the scaling that it was made with.
        let keeps = fits && !self.symmetric && !self.refresh_wanted;
        let refactors = !keeps || scaling.is_some() != self.scaling.is_some();
        if refactors && scales {
            self.scaling = scaling;
        }
        self.scaled = self.scaling.as_ref().filter(|_| scales).map(|scaling| scaling.of_matrix(&matrix));
        self.matrix = Some(matrix);
        let mut result = Ok(());
        if known || saddle {
            result = self.factor_by_lu();
        } else if refactors {
            result = self.refactor();
            if result.as_ref().is_err_and(SolverError::is_for_lu) && !self.proved_singular {
                self.lu_size = self.matrix.as_ref().map(CsrMatrix::rows);
                result = self.factor_by_lu();
            }
        }
        if result.is_err() {
            (self.matrix, self.scaled) = (None, None);
        }
        result
    }

    fn pattern(&self) -> Option<&Arc<SparsityPattern>> {
        self.analysis.as_ref().map(|analysis| analysis.pattern())
    }

    fn report(&self) -> Option<SolverReport> {
        Some(TangentSolver::report(self).clone())
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
        let matrix = self.matrix.as_ref().ok_or(SolverError::NoMatrix)?;
        check_size("the right-hand side", matrix.rows(), b.len())?;
        let found = if self.by_lu {
            self.solve_by_lu(b, absolute_tolerance, transpose)
        } else {
            self.solve_scaled(b, absolute_tolerance, transpose)
        };
        let solution = match found {
            Err(error) if !self.by_lu && error.is_for_lu() => {
                self.lu_size = Some(b.len());
                self.factor_by_lu()?;
                self.solve_by_lu(b, absolute_tolerance, transpose)?
            }
            found => found?,
        };
        self.count(&solution);
        Ok(solution)
    }

    fn solve_each(
        &mut self,
        sides: &[&[f64]],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<Vec<LinearSolution>, SolverError> {
        let count = sides.len();
        let mut found = match self.symmetric && !self.by_lu && count > 1 {
            true => self.solve_symmetric(sides, transpose).unwrap_or_default(),
            false => vec![],
        };
        found.resize_with(count, || Err(SolverError::NoMatrix));
        let mut solutions = vec![];
        for (number, (found, b)) in found.into_iter().zip(sides).enumerate() {
            solutions.push(match found {
                Ok(solution) => {
                    self.count(&solution);
                    solution
                }
                // Those that have no solution yet, or need LU.
                Err(_) => self
                    .solve_with(b, absolute_tolerance, transpose)
                    .map_err(|error| error.of_side(number, count))?,
            });
        }
        Ok(solutions)
    }
}

#[cfg(test)]
mod tests;
