//! Stopping of the Krylov methods for symmetric operators, and their reports.

use super::backward_error::{ACCEPTED, Refinement, rough};
use super::equations::Equations;
use super::error::{LinearAlgebraError, check_finite, check_size};
use super::operator::{LinearOperator, OperatorError};
use super::vector::{in_pieces, norm_on};
use crate::threads::Threads;

/// Conditions for a Krylov method to stop.
#[derive(Clone, Debug, PartialEq)]
pub struct KrylovOptions {
    /// Stop at ‖b − A x‖₂ ≤ `tolerance` ‖b‖₂. Where the operator is a matrix, each equation has to hold besides, up to a
    /// hundred times this part of its own terms; if one does not, the method goes on from the residual.
    pub tolerance: f64,
    /// Stop also at ‖b − A x‖₂ ≤ `absolute_tolerance` \[unit of b\], if no equation of a matrix is off by more than a
    /// thousandth of its own terms.
    pub absolute_tolerance: f64,
    /// Most iterations; as many again where equations of a matrix are gone on with.
    pub max_iterations: usize,
    /// Threads for dot products, which are the same for each number of them. The operator and the
    /// preconditioner choose their own number.
    pub threads: Threads,
}

impl Default for KrylovOptions {
    fn default() -> Self {
        KrylovOptions {
            tolerance: 1e-10,
            absolute_tolerance: 0.0,
            max_iterations: 1000,
            threads: Threads::ONE,
        }
    }
}

/// Report of a Krylov method.
#[derive(Clone, Default, PartialEq)]
pub struct KrylovReport {
    /// Applications of the preconditioned operator.
    pub iterations: usize,
    /// ‖b − A x‖₂ / ‖b‖₂, computed from x and not from the recurrence (0 if b = 0).
    pub relative_residual: f64,
    /// Relative residual at the start and after each iteration, as the recurrence has it. MINRES measures it in the
    /// norm of the preconditioner.
    pub history: Vec<f64>,
}

/// Failures of a Krylov method. The last iterate is in `x`.
#[derive(Debug, thiserror::Error)]
pub enum KrylovError {
    /// The operator or the preconditioner failed.
    #[error("the operator or its preconditioner failed: {0}")]
    Operator(#[source] OperatorError),
    /// Sizes disagree, or the right-hand side is not finite.
    #[error(transparent)]
    BadArguments(#[from] LinearAlgebraError),
    /// The iterations are used up.
    #[error("no convergence: relative residual {:e} after {} iterations", .0.relative_residual, .0.iterations)]
    NotConverged(KrylovReport),
    /// Rounding keeps the residual above the tolerance.
    #[error(
        "the residual stagnates at rounding level: {:e} relative after {} iterations",
        .0.relative_residual, .0.iterations
    )]
    Stagnated(KrylovReport),
    /// There is a direction p with pᵀ A p ≤ 0, which conjugate gradients cannot pass. MINRES can.
    #[error(
        "the operator is not positive definite: pᵀAp = {curvature:e} in iteration {}", .report.iterations
    )]
    NotPositiveDefinite {
        /// pᵀ A p.
        curvature: f64,
        /// The iterations before.
        report: KrylovReport,
    },
    /// There is a residual r with rᵀ M⁻¹ r ≤ 0.
    #[error("the preconditioner is not positive definite: rᵀM⁻¹r = {product:e} in iteration {}", .report.iterations)]
    IndefinitePreconditioner {
        /// rᵀ M⁻¹ r.
        product: f64,
        /// The iterations before.
        report: KrylovReport,
    },
    /// A vector became NaN or infinite.
    #[error("a value is not finite after {} iterations", .0.iterations)]
    NotFinite(KrylovReport),
}

impl KrylovError {
    /// The iterations before the failure, where there were any.
    pub fn report(&self) -> Option<&KrylovReport> {
        match self {
            KrylovError::Operator(_) | KrylovError::BadArguments(_) => None,
            KrylovError::NotConverged(report)
            | KrylovError::Stagnated(report)
            | KrylovError::NotFinite(report)
            | KrylovError::NotPositiveDefinite { report, .. }
            | KrylovError::IndefinitePreconditioner { report, .. } => Some(report),
        }
    }
}

/// Equations that are off by more than this many times the tolerance, each relative to its own terms, are solved further.
#[doc(hidden)]
pub const BESIDE_TERMS: f64 = 100.0;
/// Most further runs from the residual.
#[doc(hidden)]
pub const ROUNDS: usize = 6;

/// Refinement of a solution that meets the tolerances in the norm, until each equation holds relative to its own terms: the norm
/// does not see equations of small numbers. `further` solves for a residual, from zero. Returns the report with its runs.
///
/// # Errors
/// [`LinearAlgebraError::Inaccurate`] with the equation that stays off, or as the runs.
#[doc(hidden)]
pub fn until_each_equation_holds<E: From<LinearAlgebraError>>(
    equations: &impl Equations,
    b: &[f64],
    x: &mut [f64],
    options: &KrylovOptions,
    mut report: KrylovReport,
    mut further: impl FnMut(&[f64], &mut [f64]) -> Result<KrylovReport, E>,
) -> Result<KrylovReport, E> {
    let b_norm = norm_on(options.threads, b);
    let exact = BESIDE_TERMS * options.tolerance;
    // What a run that stopped at rounding leaves has to fall under the tolerance too.
    let target = options.tolerance.max(options.absolute_tolerance / b_norm);
    let is_exact = options.tolerance == target || report.relative_residual <= options.tolerance;
    let level = if is_exact { exact } else { exact.max(rough(target)) };
    let mut found = Refinement::new(equations, options.threads, b, x.to_vec())?;
    let relative = |rest: &[f64]| norm_on(options.threads, rest) / b_norm;
    let mut helped = true;
    for _ in 0..ROUNDS {
        let error = found.residual.worst().error;
        let holds = error <= level;
        if holds && report.relative_residual <= target || b_norm == 0.0 {
            return Ok(report);
        }
        if !helped {
            break;
        }
        let before = report.relative_residual;
        let run = found.go_on(&mut further)?;
        report.iterations += run.iterations;
        report.history.extend(run.history.iter().skip(1).map(|part| part * before));
        let (next_error, next_relative) = (found.next.worst().error, relative(&found.next.rest));
        if !(next_error < error || holds && next_relative < before) {
            break;
        }
        helped = next_error <= 0.5 * error || next_relative <= target;
        found.accept();
        x.copy_from_slice(&found.x);
        report.relative_residual = next_relative;
    }
    found.check(level.max(ACCEPTED))?;
    Ok(report)
}

/// A method for symmetric operators, run until its tolerances are met in the norm and, where the operator is a matrix, by
/// each equation.
pub(super) fn by_equations<O: LinearOperator>(
    operator: &O,
    b: &[f64],
    x: &mut [f64],
    options: &KrylovOptions,
    mut run: impl FnMut(&[f64], &mut [f64], &KrylovOptions) -> Result<KrylovReport, KrylovError>,
) -> Result<KrylovReport, KrylovError> {
    let found = run(b, x, options);
    let Some(entries) = operator.entries() else { return found };
    let report = match found {
        // Rounding in the recurrences stopped it shortly before: it begins again from the residual.
        Err(KrylovError::Stagnated(report))
            if report.relative_residual <= BESIDE_TERMS * options.tolerance =>
        {
            report
        }
        found => found?,
    };
    let further = KrylovOptions { absolute_tolerance: 0.0, ..options.clone() };
    let report = until_each_equation_holds(&entries, b, x, options, report, |b: &[f64], x: &mut [f64]| {
        match run(b, x, &further) {
            // A part of the residual is better than nothing.
            Err(KrylovError::NotConverged(report) | KrylovError::Stagnated(report)) => Ok(report),
            found => found,
        }
    })?;
    let target = options.tolerance.max(options.absolute_tolerance / norm_on(options.threads, b));
    if report.relative_residual > target * (1.0 + 4.0 * f64::EPSILON) {
        return Err(KrylovError::Stagnated(report));
    }
    Ok(report)
}

/// The measure of a residual.
pub(super) struct Goal {
    /// ‖b‖₂.
    pub(super) b_norm: f64,
    /// ‖b − A x‖₂ of a solution.
    pub(super) target: f64,
}

/// Checks the vectors. For b = 0 there is no goal, and x becomes zero.
pub(super) fn goal(
    size: usize,
    b: &[f64],
    x: &mut [f64],
    options: &KrylovOptions,
) -> Result<Option<Goal>, KrylovError> {
    check_size("the right-hand side", size, b.len())?;
    check_size("the solution", size, x.len())?;
    check_finite("the right-hand side", b)?;
    check_finite("the first guess", x)?;
    let b_norm = norm_on(options.threads, b);
    if b_norm == 0.0 {
        x.fill(0.0);
        return Ok(None);
    }
    let target = (options.tolerance * b_norm).max(options.absolute_tolerance);
    Ok(Some(Goal { b_norm, target }))
}

/// r = b − A x; returns ‖r‖₂.
pub(super) fn residual(
    operator: &impl LinearOperator,
    b: &[f64],
    x: &[f64],
    r: &mut [f64],
    threads: Threads,
) -> Result<f64, KrylovError> {
    if x.iter().all(|value| *value == 0.0) {
        r.copy_from_slice(b);
    } else {
        operator.apply(x, r).map_err(KrylovError::Operator)?;
        in_pieces(threads, r, 1, |first, r| r.iter_mut().zip(&b[first..]).for_each(|(r, b)| *r = b - *r));
    }
    Ok(norm_on(threads, r))
}
