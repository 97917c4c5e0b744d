//! MINRES with a preconditioner, for symmetric operators that may be indefinite (Paige and Saunders 1975).

use super::krylov::{Goal, KrylovError, KrylovOptions, KrylovReport, by_equations, goal, residual};
use super::operator::{LinearOperator, Preconditioner};
use super::vector::{add_scaled_on, dot_on, in_pieces};

/// Solution of A x = b by MINRES, from the given x. The preconditioner must be positive definite. It minimises the residual in the norm
/// of the preconditioner, which the history records; whether it stops is decided by ‖b − A x‖₂, computed from x.
///
/// # Errors
/// [`KrylovError`], with the history of residuals.
pub fn minres(
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
    let mut room = vec![0.0; size];
    let mut r_norm = residual(operator, b, x, &mut room, threads)?;
    report.relative_residual = r_norm / b_norm;
    report.history.push(report.relative_residual);
    if !r_norm.is_finite() {
        return Err(KrylovError::NotFinite(report));
    }
    if r_norm <= target {
        return Ok(report);
    }
    // Lanczos vectors (times M), the preconditioned one, and the last two directions.
    let mut r2 = room.clone();
    let mut r1 = vec![0.0; size];
    let mut y = vec![0.0; size];
    let (mut w, mut w1, mut w2) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
    let mut beta = preconditioned(preconditioner, &r2, &mut y, options, &report)?;
    let (first, start) = (beta, report.relative_residual);
    let mut earlier_beta = 1.0;
    let (mut d_bar, mut epsilon, mut phi_bar, mut cosine, mut sine) = (0.0, 0.0, beta, -1.0_f64, 0.0_f64);
    // The two norms of the residual fall together; x is looked at when the estimate has fallen enough.
    let mut look_at = target / r_norm;
    loop {
        if report.iterations >= options.max_iterations {
            report.relative_residual = residual(operator, b, x, &mut room, threads)? / b_norm;
            return Err(KrylovError::NotConverged(report));
        }
        in_pieces(threads, &mut room, 1, |first, room| {
            room.iter_mut().zip(&y[first..]).for_each(|(v, y)| *v = y / beta);
        });
        operator.apply(&room, &mut y).map_err(KrylovError::Operator)?;
        if report.iterations > 0 {
            add_scaled_on(threads, &mut y, -beta / earlier_beta, &r1);
        }
        let alpha = dot_on(threads, &room, &y);
        add_scaled_on(threads, &mut y, -alpha / beta, &r2);
        std::mem::swap(&mut r1, &mut r2);
        r2.copy_from_slice(&y);
        earlier_beta = beta;
        beta = preconditioned(preconditioner, &r2, &mut y, options, &report)?;
        let earlier_epsilon = epsilon;
        let delta = cosine * d_bar + sine * alpha;
        let gamma_bar = sine * d_bar - cosine * alpha;
        epsilon = sine * beta;
        d_bar = -cosine * beta;
        let gamma = gamma_bar.hypot(beta);
        report.iterations += 1;
        if !gamma.is_finite() {
            return Err(KrylovError::NotFinite(report));
        }
        // The Krylov space is exhausted, and A is singular on it.
        let singular = gamma <= f64::EPSILON * alpha.abs().max(earlier_beta);
        if !singular {
            (cosine, sine) = (gamma_bar / gamma, beta / gamma);
            let phi = cosine * phi_bar;
            phi_bar *= sine;
            std::mem::swap(&mut w1, &mut w2);
            std::mem::swap(&mut w2, &mut w);
            in_pieces(threads, &mut w, 1, |first, w| {
                let earlier = w1[first..].iter().zip(&w2[first..]).zip(&room[first..]);
                for (w, ((w1, w2), v)) in w.iter_mut().zip(earlier) {
                    *w = (v - earlier_epsilon * w1 - delta * w2) / gamma;
                }
            });
            add_scaled_on(threads, x, phi, &w);
        }
        let fallen = phi_bar.abs() / first;
        report.history.push(start * fallen);
        if fallen <= look_at || singular {
            r_norm = residual(operator, b, x, &mut room, threads)?;
            report.relative_residual = r_norm / b_norm;
            if !r_norm.is_finite() {
                return Err(KrylovError::NotFinite(report));
            }
            if r_norm <= target {
                return Ok(report);
            }
            look_at = fallen * (0.5 * target / r_norm).max(0.1);
            if singular || fallen < 1e-3 * f64::EPSILON {
                return Err(KrylovError::Stagnated(report));
            }
        }
    }
}

/// y = M⁻¹ r; returns √(rᵀ y).
fn preconditioned(
    preconditioner: &mut impl Preconditioner,
    r: &[f64],
    y: &mut [f64],
    options: &KrylovOptions,
    report: &KrylovReport,
) -> Result<f64, KrylovError> {
    preconditioner.precondition(r, y).map_err(KrylovError::Operator)?;
    let product = dot_on(options.threads, r, y);
    if !product.is_finite() {
        return Err(KrylovError::NotFinite(report.clone()));
    }
    if product < 0.0 || product == 0.0 && r.iter().any(|value| *value != 0.0) && report.iterations == 0 {
        return Err(KrylovError::IndefinitePreconditioner { product, report: report.clone() });
    }
    // An exhausted space leaves zero; the next step then divides by the smallest number and sees gamma = 0 or inf.
    Ok(product.sqrt().max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transpose;
    use crate::operator::{Identity, OperatorError};
    use crate::threads::Threads;
    use crate::{CsrMatrix, LuFactor, cg};

    /// [A Bᵀ; B 0] with a chain's stiffness A and every third unknown tied to its neighbour by B.
    fn saddle(n: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for i in 0..n {
            triplets.push((i, i, 2.0 + 0.01 * i as f64));
            if i + 1 < n {
                triplets.extend([(i, i + 1, -1.0), (i + 1, i, -1.0)]);
            }
        }
        for (row, i) in (0..n - 1).step_by(3).enumerate() {
            for (column, value) in [(i, 1.0), (i + 1, -1.0)] {
                triplets.extend([(n + row, column, value), (column, n + row, value)]);
            }
        }
        let size = n + (n - 1).div_ceil(3);
        CsrMatrix::from_triplets(size, size, &triplets).unwrap()
    }

    /// Positive diagonal scaling.
    struct Scaling(Vec<f64>);

    impl Preconditioner for Scaling {
        fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
            z.iter_mut().zip(r).zip(&self.0).for_each(|((z, r), s)| *z = r * s);
            Ok(())
        }
    }

    #[test]
    fn a_saddle_point_is_solved_as_by_lu() {
        let matrix = saddle(40);
        let b: Vec<f64> = (0..matrix.rows()).map(|i| (0.7 * i as f64).sin()).collect();
        let mut exact = b.clone();
        LuFactor::new(&matrix, None).unwrap().solve_in_place(&mut exact, Transpose::No).unwrap();
        let options = KrylovOptions { tolerance: 1e-12, ..KrylovOptions::default() };
        let scaling = (0..matrix.rows()).map(|i| if i < 40 { 0.4 } else { 2.0 + (i % 3) as f64 }).collect();
        let mut plain = vec![0.0; b.len()];
        let report = minres(&matrix, &mut Identity, &b, &mut plain, &options).unwrap();
        assert!(report.relative_residual <= 1e-12 && report.history.len() == report.iterations + 1);
        assert!(report.history.windows(2).all(|pair| pair[1] <= pair[0]), "the residual never grows");
        let mut scaled = vec![0.0; b.len()];
        minres(&matrix, &mut Scaling(scaling), &b, &mut scaled, &options).unwrap();
        for solution in [&plain, &scaled] {
            let error = solution.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-9, "{error:e}");
        }
        // Conjugate gradients see that the matrix is indefinite.
        let found = cg(&matrix, &mut Identity, &b, &mut vec![0.0; b.len()], &options);
        assert!(matches!(found, Err(KrylovError::NotPositiveDefinite { .. })), "{found:?}");
    }

    #[test]
    fn threads_change_no_bit() {
        let matrix = saddle(40_000);
        let b: Vec<f64> = (0..matrix.rows()).map(|i| (0.7 * i as f64).sin()).collect();
        let solve = |threads| {
            let threads = Threads::new(threads);
            let options = KrylovOptions { max_iterations: 8, threads, ..KrylovOptions::default() };
            let mut x = vec![0.0; b.len()];
            assert!(minres(&matrix, &mut Identity, &b, &mut x, &options).is_err());
            x
        };
        let one = solve(1);
        for threads in [2, 3, 7, 16] {
            assert!(solve(threads) == one, "{threads}");
        }
    }

    #[test]
    fn failures_have_a_reason() {
        let diagonal = |values: &[f64]| {
            let triplets: Vec<_> = values.iter().enumerate().map(|(i, value)| (i, i, *value)).collect();
            CsrMatrix::from_triplets(values.len(), values.len(), &triplets).unwrap()
        };
        let run = |matrix: &CsrMatrix, b: &[f64], max_iterations| {
            let options = KrylovOptions { max_iterations, threads: Threads::ONE, ..KrylovOptions::default() };
            minres(matrix, &mut Identity, b, &mut vec![0.0; b.len()], &options)
        };
        let nan = run(&diagonal(&[1.0, f64::NAN]), &[1.0, 1.0], 9);
        assert!(matches!(nan, Err(KrylovError::NotFinite(_))), "{nan:?}");
        assert!(matches!(run(&diagonal(&[1.0]), &[f64::NAN], 9), Err(KrylovError::BadArguments(_))));
        let many: Vec<f64> = (1..30).map(f64::from).collect();
        let few = run(&diagonal(&many), &[1.0; 29], 3);
        assert!(matches!(few, Err(KrylovError::NotConverged(report)) if report.history.len() == 4));
        // Not in the range of a singular matrix.
        let singular = run(&diagonal(&[1.0, 2.0, 0.0]), &[1.0, 1.0, 1.0], 50);
        assert!(
            matches!(singular, Err(KrylovError::Stagnated(_) | KrylovError::NotConverged(_))),
            "{singular:?}"
        );
        assert_eq!(run(&diagonal(&[1.0, -1.0]), &[0.0, 0.0], 9).unwrap().iterations, 0);
    }
}
