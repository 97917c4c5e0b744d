//! Conjugate gradients with a preconditioner, for symmetric positive definite operators.

use super::krylov::{Goal, KrylovError, KrylovOptions, KrylovReport, by_equations, goal, residual};
use super::operator::{LinearOperator, Preconditioner};
use super::vector::{add_scaled_on, dot_on, in_pieces, norm_on};

/// Solution of A x = b by conjugate gradients, from the given x.
///
/// # Errors
/// [`KrylovError`], with the history of residuals; it tells whether the operator or the preconditioner is not positive
/// definite.
pub fn cg(
    operator: &impl LinearOperator,
    preconditioner: &mut impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    options: &KrylovOptions,
) -> Result<KrylovReport, KrylovError> {
    by_equations(operator, b, x, options, |b, x, options| run(operator, preconditioner, b, x, options))
}

/// Until the tolerances are met in the norm.
fn run(
    operator: &impl LinearOperator,
    preconditioner: &mut impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    options: &KrylovOptions,
) -> Result<KrylovReport, KrylovError> {
    let (size, threads, mut report) = (operator.size(), options.threads, KrylovReport::default());
    let Some(Goal { b_norm, target }) = goal(size, b, x, options)? else {
        report.history.push(0.0);
        return Ok(report);
    };
    let mut r = vec![0.0; size];
    let (mut z, mut image) = (vec![0.0; size], vec![0.0; size]);
    let mut p: Vec<f64> = Vec::new();
    // The residual is computed from x when the recurrence has met the target, and the method starts again from there
    // if rounding has parted the two.
    let mut earlier = f64::INFINITY;
    loop {
        let mut r_norm = residual(operator, b, x, &mut r, threads)?;
        report.relative_residual = r_norm / b_norm;
        if report.history.is_empty() {
            report.history.push(report.relative_residual);
        }
        if !r_norm.is_finite() {
            return Err(KrylovError::NotFinite(report));
        }
        if r_norm <= target {
            return Ok(report);
        }
        if r_norm > 0.5 * earlier {
            return Err(KrylovError::Stagnated(report));
        }
        if report.iterations >= options.max_iterations {
            return Err(KrylovError::NotConverged(report));
        }
        earlier = r_norm;
        p.clear();
        let mut product = 0.0;
        while r_norm > target && report.iterations < options.max_iterations {
            preconditioner.precondition(&r, &mut z).map_err(KrylovError::Operator)?;
            let next = dot_on(threads, &r, &z);
            if !next.is_finite() {
                return Err(KrylovError::NotFinite(report));
            }
            if next <= 0.0 {
                return Err(KrylovError::IndefinitePreconditioner { product: next, report });
            }
            match p.is_empty() {
                true => p.clone_from(&z),
                false => {
                    let beta = next / product;
                    in_pieces(threads, &mut p, 1, |first, p| {
                        p.iter_mut().zip(&z[first..]).for_each(|(p, z)| *p = z + beta * *p);
                    });
                }
            }
            product = next;
            operator.apply(&p, &mut image).map_err(KrylovError::Operator)?;
            let curvature = dot_on(threads, &p, &image);
            if !curvature.is_finite() {
                return Err(KrylovError::NotFinite(report));
            }
            if curvature <= 0.0 {
                return Err(KrylovError::NotPositiveDefinite { curvature, report });
            }
            let step = product / curvature;
            add_scaled_on(threads, x, step, &p);
            add_scaled_on(threads, &mut r, -step, &image);
            r_norm = norm_on(threads, &r);
            report.iterations += 1;
            report.history.push(r_norm / b_norm);
            if !r_norm.is_finite() {
                return Err(KrylovError::NotFinite(report));
            }
        }
    }
}

#[cfg(test)]
mod tests;
