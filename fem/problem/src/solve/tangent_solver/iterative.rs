//! GMRES with the factor of a symmetric part, run until each equation holds relative to its own terms.

use std::time::Instant;

use super::TangentSolver;
use crate::linear_algebra::Transpose;
use crate::linear_algebra::backward_error::{ACCEPTED, Refinement, rough};
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::krylov::{BESIDE_TERMS, ROUNDS};
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{GmresError, GmresOptions, GmresReport, LinearAlgebraError, gmres};
use crate::solve::linear_solver::{LinearSolution, SolverError};

impl TangentSolver {
    pub(super) fn solve_iteratively(
        &mut self,
        b: &[f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        loop {
            let mut x = vec![0.0; b.len()];
            let start = Instant::now();
            let result = self.run_gmres_by_rows(b, &mut x, absolute_tolerance, transpose);
            self.report.solve_seconds += start.elapsed().as_secs_f64();
            let report = match result {
                Ok(report) => report,
                Err(GmresError::Operator(error)) if self.factor_is_fresh || !error.is_for_lu() => {
                    return Err(error);
                }
                Err(GmresError::Operator(_)) => {
                    self.refactor()?;
                    continue;
                }
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
                self.consider_lu(b.len(), report.iterations);
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

    /// Iterations that cost as much as a factorisation.
    fn worthwhile_excess(&self) -> usize {
        self.options.refresh_after.unwrap_or_else(|| self.factorisation_in_iterations())
    }

    /// Runs GMRES, and again from its residual until each equation holds relative to its own terms: the norm of the whole
    /// residual does not see those of small numbers.
    fn run_gmres_by_rows(
        &self,
        b: &[f64],
        x: &mut [f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<GmresReport, GmresError<SolverError>> {
        let failed = |error: LinearAlgebraError| GmresError::Operator(error.into());
        let side = Side::of(self.system().map_err(GmresError::Operator)?, transpose);
        // Rounding may keep it from its tolerance.
        let found = self.run_gmres(b, x, absolute_tolerance, transpose);
        let mut report = stopped(found, self.options.accepted)?;
        let mut found = Refinement::new(&side, self.options.threads, b, x.to_vec()).map_err(failed)?;
        // What is good enough for the caller need not be exact, but no equation may be left aside.
        let target = absolute_tolerance / norm(b);
        let is_enough = report.relative_residual <= target;
        let exact = BESIDE_TERMS * self.options.tolerance;
        let level = if is_enough { exact.max(rough(target)) } else { exact };
        for _ in 0..ROUNDS {
            let error = found.residual.worst().error;
            if error <= level {
                return Ok(report);
            }
            let further = found.go_on(|rest, change| -> Result<GmresReport, Failed> {
                // Part of a residual is better than nothing.
                Ok(stopped(self.run_gmres(rest, change, 0.0, transpose), f64::INFINITY)?)
            });
            report.iterations += further.map_err(|Failed(error)| error)?.iterations;
            let next_error = found.next.worst().error;
            if next_error >= error {
                break;
            }
            found.accept();
            x.copy_from_slice(&found.x);
            if next_error > 0.5 * error {
                break;
            }
        }
        let scale = norm(b);
        report.relative_residual = if scale == 0.0 { 0.0 } else { norm(&found.residual.rest) / scale };
        found.check(level.max(ACCEPTED)).map_err(failed)?;
        Ok(report)
    }

    fn run_gmres(
        &self,
        b: &[f64],
        x: &mut [f64],
        absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<GmresReport, GmresError<SolverError>> {
        let matrix = self.system().map_err(GmresError::Operator)?;
        let factor = self.factor.as_ref().ok_or(GmresError::Operator(SolverError::NoMatrix))?;
        if !norm(b).is_finite() {
            crate::linear_algebra::error::check_finite("the right-hand side", b)
                .map_err(|error| GmresError::Operator(error.into()))?;
        }
        let options = GmresOptions {
            tolerance: self.options.tolerance,
            absolute_tolerance,
            restart: self.options.restart,
            max_iterations: self.options.max_iterations,
            operator_norm: Some(if transpose == Transpose::Yes {
                matrix.column_sum_norm()
            } else {
                matrix.row_sum_norm()
            }),
            flexible: false,
            threads: self.options.threads,
        };
        gmres(
            |v, w| match transpose {
                Transpose::No => matrix.multiply_on(self.options.threads, v, w).map_err(SolverError::from),
                Transpose::Yes => matrix.multiply_transposed_into(v, w).map_err(SolverError::from),
            },
            |v| factor.solve_in_place(v).map_err(SolverError::from),
            b,
            x,
            &options,
        )
    }
}

/// A run that stopped at a residual of at most this size, relative to the right-hand side, is as good as one that met its
/// tolerance.
fn stopped(
    found: Result<GmresReport, GmresError<SolverError>>,
    accepted: f64,
) -> Result<GmresReport, GmresError<SolverError>> {
    match found {
        Err(GmresError::Stagnated(report) | GmresError::NotConverged(report))
            if report.relative_residual <= accepted =>
        {
            Ok(report)
        }
        found => found,
    }
}

/// A failure of GMRES.
struct Failed(GmresError<SolverError>);

impl From<GmresError<SolverError>> for Failed {
    fn from(error: GmresError<SolverError>) -> Self {
        Failed(error)
    }
}

impl From<LinearAlgebraError> for Failed {
    fn from(error: LinearAlgebraError) -> Self {
        Failed(GmresError::Operator(error.into()))
    }
}
