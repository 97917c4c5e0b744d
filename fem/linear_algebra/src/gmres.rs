//! Restarted GMRES with right preconditioning, for unsymmetric systems.

use super::vector::{add_scaled_on, dot_on, in_pieces, largest, norm_on};
use crate::threads::Threads;

/// Conditions to stop and to restart.
#[derive(Clone, Debug, PartialEq)]
pub struct GmresOptions {
    /// Stop at ‖b − A x‖₂ ≤ `tolerance` ‖b‖₂.
    pub tolerance: f64,
    /// Stop also at ‖b − A x‖₂ ≤ `absolute_tolerance` \[unit of b\].
    pub absolute_tolerance: f64,
    /// Basis vectors kept before a restart; each costs one vector of memory.
    pub restart: usize,
    /// Most iterations in all.
    pub max_iterations: usize,
    /// ‖A‖∞ if it is known: a solution whose backward error ‖b − A x‖∞ / (‖A‖∞ ‖x‖∞ + ‖b‖∞) is at
    /// rounding level is then accepted even if `tolerance` asks for more than rounding allows.
    pub operator_norm: Option<f64>,
    /// Whether the preconditioner may differ from one application to the next (flexible GMRES, Saad 1993), as an
    /// inner iteration does. It costs a second vector per basis vector.
    pub flexible: bool,
    /// Threads for operations on vectors, with the same numbers for any number of them. The operator and the
    /// preconditioner choose their own number.
    pub threads: Threads,
}

impl Default for GmresOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-13,
            absolute_tolerance: 0.0,
            restart: 60,
            max_iterations: 300,
            operator_norm: None,
            flexible: false,
            threads: Threads::ONE,
        }
    }
}

/// Backward error that counts as rounding level.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Report of GMRES.
#[derive(Clone, Default, PartialEq)]
pub struct GmresReport {
    /// Applications of the operator inside Krylov cycles.
    pub iterations: usize,
    /// ‖b − A x‖₂ / ‖b‖₂, computed from x and not from the recurrence (0 if b = 0).
    pub relative_residual: f64,
    /// Relative residual at the start and after each iteration, as the recurrence estimates it.
    pub history: Vec<f64>,
    /// Whether the solution was accepted because its backward error is at rounding level.
    pub at_rounding: bool,
}

impl From<GmresReport> for super::krylov::KrylovReport {
    fn from(report: GmresReport) -> Self {
        let GmresReport { iterations, relative_residual, history, .. } = report;
        super::krylov::KrylovReport { iterations, relative_residual, history }
    }
}

/// Failures of GMRES. The best solution found so far is in `x`.
#[derive(Debug, thiserror::Error)]
pub enum GmresError<E> {
    /// The operator or the preconditioner failed.
    #[error(transparent)]
    Operator(#[from] E),
    /// The iterations are used up.
    #[error("GMRES did not converge: relative residual {:e} after {} iterations", .0.relative_residual, .0.iterations)]
    NotConverged(GmresReport),
    /// A whole cycle did not halve the residual.
    #[error("GMRES stagnates at relative residual {:e} after {} iterations", .0.relative_residual, .0.iterations)]
    Stagnated(GmresReport),
    /// A vector became NaN or infinite.
    #[error("GMRES met a value that is not finite after {} iterations", .0.iterations)]
    NotFinite(GmresReport),
    /// `b` and `x` have different sizes, or the restart length is zero.
    #[error(
        "GMRES: the solution has size {solution}, the right-hand side {right_hand_side}; restart {restart}"
    )]
    BadArguments {
        /// Size of `x`.
        solution: usize,
        /// Size of `b`.
        right_hand_side: usize,
        /// Restart length.
        restart: usize,
    },
}

/// Solution of A x = b by GMRES, from the given x. `operator(v, w)` writes A v to w; `preconditioner(v)` replaces v by an
/// approximation of A⁻¹ v. Arnoldi's basis is orthogonalised by modified Gram–Schmidt, twice where
/// cancellation asks for it.
///
/// # Errors
/// [`GmresError`], with the history of residuals.
pub fn gmres<E>(
    mut operator: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    mut preconditioner: impl FnMut(&mut [f64]) -> Result<(), E>,
    b: &[f64],
    x: &mut [f64],
    options: &GmresOptions,
) -> Result<GmresReport, GmresError<E>> {
    let size = b.len();
    if x.len() != size || options.restart == 0 {
        return Err(GmresError::BadArguments {
            solution: x.len(),
            right_hand_side: size,
            restart: options.restart,
        });
    }
    let mut report = GmresReport::default();
    let b_norm = norm_on(options.threads, b);
    if b_norm == 0.0 {
        x.fill(0.0);
        report.history.push(0.0);
        return Ok(report);
    }
    let target = (options.tolerance * b_norm).max(options.absolute_tolerance);
    let mut residual = vec![0.0; size];
    let mut previous = f64::INFINITY;
    loop {
        operator(x, &mut residual)?;
        in_pieces(options.threads, &mut residual, 1, |first, piece| {
            piece.iter_mut().zip(&b[first..]).for_each(|(value, given)| *value = given - *value);
        });
        let residual_norm = norm_on(options.threads, &residual);
        report.relative_residual = residual_norm / b_norm;
        if report.history.is_empty() {
            report.history.push(report.relative_residual);
        }
        if !residual_norm.is_finite() {
            return Err(GmresError::NotFinite(report));
        }
        if residual_norm <= target {
            return Ok(report);
        }
        if let Some(operator_norm) = options.operator_norm
            && largest(&residual) <= ROUNDING * (operator_norm * largest(x) + largest(b))
        {
            report.at_rounding = true;
            return Ok(report);
        }
        if report.iterations >= options.max_iterations {
            return Err(GmresError::NotConverged(report));
        }
        if residual_norm > 0.5 * previous {
            return Err(GmresError::Stagnated(report));
        }
        previous = residual_norm;
        let cycle = Cycle { target, b_norm, options };
        let mut correction = cycle.run(&mut operator, &mut preconditioner, &residual, &mut report)?;
        if !options.flexible {
            preconditioner(&mut correction)?;
        }
        add_scaled_on(options.threads, x, 1.0, &correction);
    }
}

/// One Krylov cycle between restarts.
struct Cycle<'a> {
    target: f64,
    b_norm: f64,
    options: &'a GmresOptions,
}

impl Cycle<'_> {
    /// The combination of basis vectors that minimises the residual; it is still to be preconditioned, unless the
    /// method is flexible and has kept the preconditioned vectors.
    fn run<E>(
        &self,
        operator: &mut impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
        preconditioner: &mut impl FnMut(&mut [f64]) -> Result<(), E>,
        residual: &[f64],
        report: &mut GmresReport,
    ) -> Result<Vec<f64>, GmresError<E>> {
        let beta = norm_on(self.options.threads, residual);
        let mut basis: Vec<Vec<f64>> = vec![residual.iter().map(|value| value / beta).collect()];
        let mut preconditioned: Vec<Vec<f64>> = Vec::new();
        // Columns of the triangular factor of Hessenberg's matrix, its rotations, the rotated right-hand side.
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        let mut rotations: Vec<(f64, f64)> = Vec::new();
        let mut rotated = vec![beta];
        while triangle.len() < self.options.restart && report.iterations < self.options.max_iterations {
            let step = triangle.len();
            let mut direction = basis[step].clone();
            preconditioner(&mut direction)?;
            let mut image = vec![0.0; direction.len()];
            operator(&direction, &mut image)?;
            if self.options.flexible {
                preconditioned.push(direction);
            }
            report.iterations += 1;
            let (mut column, next_norm, broke_down) = orthogonalise(&mut image, &basis, self.options.threads);
            for (row, &(cosine, sine)) in rotations.iter().enumerate() {
                let (upper, lower) = (column[row], column[row + 1]);
                column[row] = cosine * upper + sine * lower;
                column[row + 1] = cosine * lower - sine * upper;
            }
            let length = column[step].hypot(next_norm);
            if !length.is_finite() {
                return Err(GmresError::NotFinite(report.clone()));
            }
            if length == 0.0 {
                // The operator is singular on this Krylov space: use the columns before this one.
                break;
            }
            let (cosine, sine) = (column[step] / length, next_norm / length);
            column[step] = length;
            column.truncate(step + 1);
            rotations.push((cosine, sine));
            triangle.push(column);
            let last = rotated[step];
            rotated[step] = cosine * last;
            rotated.push(-sine * last);
            let estimate = rotated[step + 1].abs();
            report.history.push(estimate / self.b_norm);
            if estimate <= self.target || broke_down {
                break;
            }
            in_pieces(self.options.threads, &mut image, 1, |_, piece| {
                piece.iter_mut().for_each(|value| *value /= next_norm);
            });
            basis.push(image);
        }
        let coefficients = back_substitute(&triangle, &rotated);
        let mut combination = vec![0.0; residual.len()];
        let vectors = if self.options.flexible { &preconditioned } else { &basis };
        for (coefficient, vector) in coefficients.iter().zip(vectors) {
            add_scaled_on(self.options.threads, &mut combination, *coefficient, vector);
        }
        Ok(combination)
    }
}

/// Makes `image` orthogonal to the basis. Returns the coefficients (with room for one rotation's result), the
/// norm of what is left, and whether nothing but rounding is left.
fn orthogonalise(image: &mut [f64], basis: &[Vec<f64>], threads: Threads) -> (Vec<f64>, f64, bool) {
    let initial = norm_on(threads, image);
    let mut column = vec![0.0; basis.len() + 1];
    let mut before = initial;
    let mut after = initial;
    for _ in 0..2 {
        for (coefficient, vector) in column.iter_mut().zip(basis) {
            let part = dot_on(threads, image, vector);
            *coefficient += part;
            add_scaled_on(threads, image, -part, vector);
        }
        after = norm_on(threads, image);
        // Without much cancellation one pass is enough.
        if after > 0.7 * before {
            break;
        }
        before = after;
    }
    let broke_down = after <= 10.0 * f64::EPSILON * initial;
    if let Some(last) = column.last_mut() {
        *last = after;
    }
    (column, after, broke_down)
}

fn back_substitute(triangle: &[Vec<f64>], right_hand_side: &[f64]) -> Vec<f64> {
    let mut solution = right_hand_side[..triangle.len()].to_vec();
    for column in (0..triangle.len()).rev() {
        solution[column] /= triangle[column][column];
        for row in 0..column {
            solution[row] -= triangle[column][row] * solution[column];
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// Upwind convection–diffusion–reaction: tridiagonal with −1 − c, 3 + c, −1.
    fn convection(c: f64) -> impl FnMut(&[f64], &mut [f64]) -> Result<(), Infallible> {
        move |x, y| {
            for i in 0..x.len() {
                let before = if i > 0 { x[i - 1] } else { 0.0 };
                let after = x.get(i + 1).copied().unwrap_or(0.0);
                y[i] = (3.0 + c) * x[i] - (1.0 + c) * before - after;
            }
            Ok(())
        }
    }

    fn identity(_: &mut [f64]) -> Result<(), Infallible> {
        Ok(())
    }

    #[test]
    fn convection_and_diffusion_is_solved_with_and_without_restart() {
        let exact: Vec<f64> = (0..40).map(|i| (0.3 * f64::from(i)).sin() + 1.0).collect();
        let mut b = vec![0.0; 40];
        convection(0.5)(&exact, &mut b).unwrap();
        for (restart, max_iterations) in [(60, 41), (20, 2000)] {
            let mut x = vec![0.0; 40];
            let options =
                GmresOptions { restart, max_iterations, tolerance: 1e-12, ..GmresOptions::default() };
            let report = gmres(convection(0.5), identity, &b, &mut x, &options).unwrap();
            assert!(report.relative_residual <= 1e-12);
            assert_eq!(report.history.len(), report.iterations + 1);
            let error = x.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-9, "restart {restart}: {error:e}");
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let size = 50_000;
        let b: Vec<f64> = (0..size).map(|i| (0.7 * f64::from(i)).cos()).collect();
        let solve = |threads| {
            let mut x = vec![0.0; b.len()];
            let options = GmresOptions {
                tolerance: 1e-10,
                restart: 8,
                threads: Threads::new(threads),
                ..GmresOptions::default()
            };
            let report = gmres(convection(0.5), identity, &b, &mut x, &options).unwrap();
            (x, report)
        };
        let one = solve(1);
        for threads in [2, 3, 7, 16] {
            assert!(solve(threads) == one, "{threads}");
        }
    }

    #[test]
    fn an_exact_preconditioner_needs_one_iteration_and_two_eigenvalues_need_two() {
        let diagonal = [1.0, 5.0, 5.0, 1.0, 5.0];
        let scale = |x: &[f64], y: &mut [f64]| {
            for i in 0..5 {
                y[i] = diagonal[i] * x[i];
            }
            Ok::<(), Infallible>(())
        };
        let b = [1.0, 2.0, 3.0, 4.0, 5.0];
        let exact = |v: &mut [f64]| {
            v.iter_mut().zip(&diagonal).for_each(|(value, d)| *value /= d);
            Ok(())
        };
        let mut x = [0.0; 5];
        assert_eq!(gmres(scale, exact, &b, &mut x, &GmresOptions::default()).unwrap().iterations, 1);
        for i in 0..5 {
            assert!((x[i] * diagonal[i] - b[i]).abs() < 1e-14);
        }
        let mut x = [0.0; 5];
        assert_eq!(gmres(scale, identity, &b, &mut x, &GmresOptions::default()).unwrap().iterations, 2);
    }

    #[test]
    fn a_preconditioner_that_changes_asks_for_the_flexible_method() {
        let exact: Vec<f64> = (0..60).map(|i| (0.3 * f64::from(i)).sin() + 1.0).collect();
        let mut b = vec![0.0; 60];
        convection(0.5)(&exact, &mut b).unwrap();
        let solve = |flexible| {
            let (mut x, mut calls) = (vec![0.0; 60], 0);
            let changing = |v: &mut [f64]| {
                calls += 1;
                v.iter_mut().enumerate().for_each(|(i, v)| *v /= 3.0 + f64::from((i + calls) as u32 % 4));
                Ok(())
            };
            let options = GmresOptions { flexible, tolerance: 1e-11, ..GmresOptions::default() };
            gmres(convection(0.5), changing, &b, &mut x, &options).map(|report| (report, x))
        };
        let (report, x) = solve(true).unwrap();
        assert!(report.relative_residual <= 1e-11);
        assert!(x.iter().zip(&exact).all(|(a, b)| (a - b).abs() < 1e-8));
        let plain = solve(false).map_or(usize::MAX, |(report, _)| report.iterations);
        assert!(plain > report.iterations, "{plain}");
    }

    #[test]
    fn a_zero_right_hand_side_has_the_zero_solution() {
        let mut x = [3.0; 4];
        let report = gmres(convection(1.0), identity, &[0.0; 4], &mut x, &GmresOptions::default()).unwrap();
        assert_eq!((report.iterations, x), (0, [0.0; 4]));
    }

    #[test]
    fn stagnation_failure_and_nan_are_told_apart() {
        // A cyclic shift: GMRES makes no progress before the last step, so a short restart stagnates.
        let shift = |x: &[f64], y: &mut [f64]| {
            for i in 0..x.len() {
                y[i] = x[(i + 1) % x.len()];
            }
            Ok::<(), Infallible>(())
        };
        let mut b = [0.0; 10];
        b[0] = 1.0;
        let short = GmresOptions { restart: 5, ..GmresOptions::default() };
        let error = gmres(shift, identity, &b, &mut [0.0; 10], &short).unwrap_err();
        assert!(matches!(error, GmresError::Stagnated(report) if report.history.len() == 6));
        let mut x = [0.0; 10];
        assert_eq!(gmres(shift, identity, &b, &mut x, &GmresOptions::default()).unwrap().iterations, 10);
        let few = GmresOptions { max_iterations: 3, ..GmresOptions::default() };
        let mut b = vec![0.0; 40];
        convection(0.0)(&vec![1.0; 40], &mut b).unwrap();
        let error = gmres(convection(10.0), identity, &b, &mut [0.0; 40], &few).unwrap_err();
        assert!(matches!(error, GmresError::NotConverged(report) if report.iterations == 3));
        let broken = |_: &[f64], y: &mut [f64]| {
            y.fill(f64::NAN);
            Ok::<(), Infallible>(())
        };
        let error = gmres(broken, identity, &[1.0], &mut [0.0], &GmresOptions::default()).unwrap_err();
        assert!(matches!(error, GmresError::NotFinite(_)));
        let error = gmres(shift, identity, &[1.0], &mut [0.0; 2], &GmresOptions::default()).unwrap_err();
        assert!(matches!(error, GmresError::BadArguments { .. }));
    }
}
