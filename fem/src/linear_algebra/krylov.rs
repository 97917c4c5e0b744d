//! What the Krylov methods for symmetric operators share: when they stop, and what they report.

use super::error::{LinearAlgebraError, check_finite, check_size};
use super::operator::{LinearOperator, OperatorError};
use super::vector::norm_on;
use crate::threads::Threads;

/// When a Krylov method stops.
#[derive(Clone, Debug, PartialEq)]
pub struct KrylovOptions {
    /// Stop at ‖b − A x‖₂ ≤ `tolerance` ‖b‖₂.
    pub tolerance: f64,
    /// Stop also at ‖b − A x‖₂ ≤ `absolute_tolerance` \[unit of b\].
    pub absolute_tolerance: f64,
    /// Most iterations.
    pub max_iterations: usize,
    /// Threads for dot products, which are the same for each number of them. What the operator and the
    /// preconditioner use is theirs.
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

/// What a Krylov method did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KrylovReport {
    /// Applications of the preconditioned operator.
    pub iterations: usize,
    /// ‖b − A x‖₂ / ‖b‖₂, computed from x and not from the recurrence (0 if b = 0).
    pub relative_residual: f64,
    /// Relative residual at the start and after each iteration, as the recurrence has it. MINRES measures it in the
    /// norm of the preconditioner.
    pub history: Vec<f64>,
}

/// Why a Krylov method failed. The last iterate is in `x`.
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
        /// What was done before.
        report: KrylovReport,
    },
    /// There is a residual r with rᵀ M⁻¹ r ≤ 0.
    #[error("the preconditioner is not positive definite: rᵀM⁻¹r = {product:e} in iteration {}", .report.iterations)]
    IndefinitePreconditioner {
        /// rᵀ M⁻¹ r.
        product: f64,
        /// What was done before.
        report: KrylovReport,
    },
    /// A vector became NaN or infinite.
    #[error("a value is not finite after {} iterations", .0.iterations)]
    NotFinite(KrylovReport),
}

impl KrylovError {
    /// What was done before the failure, where there was an iteration.
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

/// What a residual is measured by.
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
        for (r, b) in r.iter_mut().zip(b) {
            *r = b - *r;
        }
    }
    Ok(norm_on(threads, r))
}
