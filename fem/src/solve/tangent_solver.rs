//! Solver for tangents that are symmetric, or unsymmetric on few unknowns.

use std::sync::Arc;
use std::time::Instant;

use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{
    Analysis, CsrMatrix, GmresError, GmresOptions, GmresReport, Ordering, SymmetricFactor, gmres,
};

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
}

impl Default for TangentSolverOptions {
    fn default() -> Self {
        Self {
            ordering: Ordering::MinimumDegree,
            symmetry_tolerance: 1e-12,
            tolerance: 1e-13,
            accepted: 1e-11,
            restart: 60,
            max_iterations: 300,
            refresh_after: None,
            refinement_steps: 3,
        }
    }
}

/// What a [`TangentSolver`] did since it was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverReport {
    /// Symbolic analyses.
    pub analyses: usize,
    /// Numeric factorisations that succeeded.
    pub factorisations: usize,
    /// Those of them that were LBLᵀ because the symmetric part was not positive definite.
    pub indefinite_factorisations: usize,
    /// Systems solved.
    pub solves: usize,
    /// GMRES iterations of each solve, in order; 0 for a direct one.
    pub iterations: Vec<usize>,
    /// Seconds in symbolic analysis.
    pub analysis_seconds: f64,
    /// Seconds in numeric factorisation, failed attempts included.
    pub factorisation_seconds: f64,
    /// Seconds in solves, without factorisations.
    pub solve_seconds: f64,
    /// Largest relative residual of a solve.
    pub largest_residual: f64,
    /// Numbers stored in the factor.
    pub factor_entries: usize,
    /// Unknowns to which a [`super::CondensedSolver`] condensed; none where no Schur complement was used.
    pub condensed_unknowns: Option<usize>,
}

/// Which of the two systems is meant.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Matrix,
    Transposed,
}

/// A symmetric matrix is factored (LLᵀ, or LBLᵀ if it is indefinite) and solved directly with refinement. An
/// unsymmetric one is solved by GMRES, preconditioned with the factor of the symmetric part of itself or of an
/// earlier matrix; its transpose too, with the same factor. Analysis and factor are kept between matrices.
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
                self.fresh_iterations = None;
                analysis
            }
        };
        self.analysis = Some(analysis.clone());
        let start = Instant::now();
        let result = SymmetricFactor::cholesky_or_indefinite(&analysis, part, storage);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let factor = result?;
        self.report.factorisations += 1;
        self.report.indefinite_factorisations += usize::from(!factor.is_positive_definite());
        self.factor = Some(factor);
        self.factor_is_fresh = true;
        self.refresh_wanted = false;
        Ok(())
    }

    fn solve_side(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        side: Side,
    ) -> Result<LinearSolution, SolverError> {
        let matrix = self.matrix.as_ref().ok_or(SolverError::NoMatrix)?;
        check_size("the right-hand side", matrix.rows(), b.len())?;
        let solution = if self.symmetric {
            self.solve_directly(b)?
        } else {
            self.solve_iteratively(b, absolute_tolerance, side)?
        };
        self.report.solves += 1;
        self.report.iterations.push(solution.iterations);
        self.report.largest_residual = self.report.largest_residual.max(solution.relative_residual);
        Ok(solution)
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
        side: Side,
    ) -> Result<LinearSolution, SolverError> {
        loop {
            let mut x = vec![0.0; b.len()];
            let start = Instant::now();
            let result = self.run_gmres(b, &mut x, absolute_tolerance, side);
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
        side: Side,
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
            operator_norm: Some(match side {
                Side::Matrix => matrix.row_sum_norm(),
                Side::Transposed => matrix.column_sum_norm(),
            }),
        };
        gmres(
            |v, w| match side {
                Side::Matrix => matrix.multiply_into(v, w).map_err(SolverError::from),
                Side::Transposed => matrix.multiply_transposed_into(v, w).map_err(SolverError::from),
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
        if self.factor_is_fresh && self.matrix.as_ref() == Some(&matrix) {
            return Ok(()); // an adjoint problem with the tangent that is already factored
        }
        self.matrix = None;
        self.factor_is_fresh = false;
        check_size("the set of columns of a square matrix", matrix.rows(), matrix.columns())?;
        matrix.check_finite()?;
        self.symmetric = matrix.is_symmetric(self.options.symmetry_tolerance)?;
        let fits = self.factor.as_ref().is_some_and(|factor| factor.analysis().size() == matrix.rows());
        self.matrix = Some(matrix);
        if self.symmetric || self.refresh_wanted || !fits {
            let result = self.refactor();
            if result.is_err() {
                self.matrix = None;
            }
            return result;
        }
        Ok(())
    }

    fn solve(&mut self, b: &[f64], absolute_tolerance: f64) -> Result<LinearSolution, SolverError> {
        self.solve_side(b, absolute_tolerance, Side::Matrix)
    }

    fn solve_transposed(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
    ) -> Result<LinearSolution, SolverError> {
        self.solve_side(b, absolute_tolerance, Side::Transposed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_algebra::LinearAlgebraError;

    /// A chain of n springs of stiffness 1, clamped at both ends, whose last two unknowns are coupled by an
    /// extra block [0 s; −s p].
    fn chain(n: usize, s: f64, p: f64) -> CsrMatrix {
        let mut triplets = vec![(0, 0, 2.0)];
        for i in 1..n {
            triplets.extend([(i, i, 2.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
        }
        triplets.extend([(n - 2, n - 1, s), (n - 1, n - 2, -s), (n - 1, n - 1, p)]);
        CsrMatrix::from_triplets(n, n, &triplets).unwrap()
    }

    fn error(found: &[f64], expected: &[f64]) -> f64 {
        found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn parabola(n: usize) -> Vec<f64> {
        (1..=n).map(|i| 0.5 * (i * (n + 1 - i)) as f64).collect()
    }

    #[test]
    fn a_symmetric_chain_is_solved_directly() {
        let mut solver = TangentSolver::default();
        assert_eq!(solver.solve(&[1.0], 0.0).unwrap_err(), SolverError::NoMatrix);
        solver.set_matrix(chain(50, 0.0, 0.0)).unwrap();
        let found = solver.solve(&[1.0; 50], 0.0).unwrap();
        assert!(error(&found.solution, &parabola(50)) < 1e-10);
        assert_eq!(found.iterations, 0);
        solver.set_matrix(chain(50, 0.0, 0.0)).unwrap();
        assert_eq!(solver.report().factorisations, 1);
        assert_eq!(solver.is_positive_definite(), Some(true));
        assert!(solver.solve(&[1.0; 3], 0.0).is_err());
    }

    #[test]
    fn one_factor_serves_unsymmetric_matrices_and_their_transposes() {
        let options = TangentSolverOptions { refresh_after: Some(10), ..TangentSolverOptions::default() };
        let mut solver = TangentSolver::new(options);
        let exact: Vec<f64> = (0..50).map(|i| (0.2 * f64::from(i)).cos()).collect();
        for (s, p) in [(0.0, 0.0), (0.7, 1.0), (0.9, 1.5), (0.9, 1.5)] {
            let matrix = chain(50, s, p);
            solver.set_matrix(matrix.clone()).unwrap();
            let found = solver.solve(&matrix.multiply(&exact).unwrap(), 0.0).unwrap();
            assert!(error(&found.solution, &exact) < 1e-11);
            let found = solver.solve_transposed(&matrix.multiply_transposed(&exact).unwrap(), 0.0).unwrap();
            assert!(error(&found.solution, &exact) < 1e-11);
            assert!(found.iterations <= 4, "a change of rank 2 took {} iterations", found.iterations);
        }
        let report = solver.report();
        assert_eq!((report.analyses, report.factorisations, report.solves), (1, 1, 8));
        assert!(report.largest_residual <= 1e-13);
    }

    #[test]
    fn an_indefinite_symmetric_part_is_factored_all_the_same() {
        let mut solver = TangentSolver::default();
        let exact: Vec<f64> = (0..30).map(|i| f64::from(i % 7) - 3.0).collect();
        for s in [0.0, 0.5] {
            let matrix = chain(30, s, -9.0);
            solver.set_matrix(matrix.clone()).unwrap();
            let found = solver.solve_transposed(&matrix.multiply_transposed(&exact).unwrap(), 0.0).unwrap();
            assert!(error(&found.solution, &exact) < 1e-11);
            assert_eq!(solver.is_positive_definite(), Some(false));
        }
        assert_eq!(solver.report().indefinite_factorisations, 1);
    }

    #[test]
    fn a_poor_factor_is_refreshed() {
        let options = TangentSolverOptions { refresh_after: Some(2), ..TangentSolverOptions::default() };
        let mut solver = TangentSolver::new(options);
        let n = 60;
        solver.set_matrix(chain(n, 0.1, 0.0)).unwrap();
        solver.solve(&vec![1.0; n], 0.0).unwrap();
        // Different everywhere: the old factor is a poor preconditioner.
        let mut other = chain(n, 0.1, 0.0);
        let pattern = other.pattern().clone();
        for row in 0..n {
            let position = pattern.find(row, row).unwrap();
            other.values_mut()[position] += (1.0 + (row as f64).sin()) * 3.0;
        }
        let b = other.multiply(&vec![2.0; n]).unwrap();
        for expected_factorisations in [1, 2, 2] {
            solver.set_matrix(other.clone()).unwrap();
            assert!(error(&solver.solve(&b, 0.0).unwrap().solution, &vec![2.0; n]) < 1e-11);
            assert_eq!(solver.report().factorisations, expected_factorisations);
        }
    }

    #[test]
    fn singular_and_nan_matrices_are_errors_and_leave_no_matrix() {
        let mut solver = TangentSolver::default();
        let mut matrix = chain(5, 0.0, 0.0);
        matrix.values_mut()[3] = f64::NAN;
        assert!(matches!(
            solver.set_matrix(matrix),
            Err(SolverError::LinearAlgebra(LinearAlgebraError::EntryNotFinite { .. }))
        ));
        let zero = CsrMatrix::zero(chain(5, 0.0, 0.0).pattern());
        assert!(matches!(
            solver.set_matrix(zero),
            Err(SolverError::LinearAlgebra(LinearAlgebraError::Singular { .. }))
        ));
        assert_eq!(solver.solve(&[1.0; 5], 0.0).unwrap_err(), SolverError::NoMatrix);
        solver.set_matrix(chain(5, 0.3, 0.0)).unwrap();
        assert!(solver.solve(&[f64::NAN, 0.0, 0.0, 0.0, 0.0], 0.0).is_err());
    }
}
