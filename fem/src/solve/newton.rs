//! Undamped semismooth Newton on the free unknowns.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::elimination::Elimination;
use super::linear_solver::{LinearSolver, SolverError};
use crate::linear_algebra::vector::{add_scaled, norm};
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError};

/// A system R(u) = 0 with a (generalised) derivative. Vectors and matrices have all unknowns, the prescribed
/// ones included.
pub trait NonlinearProblem {
    /// What can go wrong in assembly.
    type Error: std::error::Error;

    /// R(u), one entry per unknown.
    ///
    /// # Errors
    /// If assembly fails.
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// An element of the generalised derivative of R at u.
    ///
    /// # Errors
    /// If assembly fails.
    fn tangent(&mut self, u: &[f64]) -> Result<CsrMatrix, Self::Error>;

    /// The part of every tangent that does not depend on u, if the problem knows it.
    ///
    /// # Errors
    /// If assembly fails.
    fn linear_part(&mut self) -> Result<Option<CsrMatrix>, Self::Error> {
        Ok(None)
    }

    /// The quadrature points that are active (in contact) at u, if the problem has such a notion.
    ///
    /// # Errors
    /// If assembly fails.
    fn active_points(&mut self, _u: &[f64]) -> Result<Option<ActivePoints>, Self::Error> {
        Ok(None)
    }
}

/// A set of active quadrature points: how many, and a fingerprint that tells sets apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActivePoints {
    /// Number of active points.
    pub count: usize,
    /// Hash of their numbers.
    pub fingerprint: u64,
}

impl ActivePoints {
    /// The set of these point numbers, which must come in the same order for the same set.
    pub fn from_numbers(numbers: impl IntoIterator<Item = usize>) -> Self {
        let mut hasher = DefaultHasher::new();
        let mut count = 0;
        for number in numbers {
            number.hash(&mut hasher);
            count += 1;
        }
        Self { count, fingerprint: hasher.finish() }
    }
}

/// When Newton's method stops.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Converged at ‖R‖₂ ≤ `relative_tolerance` × ‖R‖₂ at the start (free unknowns, prescribed values imposed).
    pub relative_tolerance: f64,
    /// Converged also at ‖R‖₂ ≤ `absolute_tolerance` \[unit of R\].
    pub absolute_tolerance: f64,
    /// Most steps.
    pub max_iterations: usize,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self { relative_tolerance: 1e-10, absolute_tolerance: 1e-300, max_iterations: 50 }
    }
}

/// Linear systems are solved to this part of Newton's own target, so that the converged residual is at rounding
/// level and not just below the target.
const LINEAR_ACCURACY: f64 = 1e-4;

/// One iterate in Newton's history, and the step that led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonStep {
    /// 0 for the start.
    pub iteration: usize,
    /// ‖R‖₂ on free unknowns \[unit of R\].
    pub residual: f64,
    /// Residual divided by the residual at the start (0 if that is 0).
    pub relative_residual: f64,
    /// Number of active quadrature points at this iterate.
    pub active_points: Option<usize>,
    /// Whether the active set differs from that of the iterate before.
    pub active_set_changed: Option<bool>,
    /// ‖δu‖₂ of the step that led here; none at the start.
    pub step: Option<f64>,
    /// Krylov iterations of that step (0 for a direct solution).
    pub linear_iterations: Option<usize>,
}

/// The solution and how it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonSolution {
    /// All unknowns, with the prescribed values.
    pub u: Vec<f64>,
    /// R(u) on all unknowns: the reactions on the prescribed ones, about zero on the others.
    pub residual: Vec<f64>,
    /// The start and each iterate.
    pub history: Vec<NewtonStep>,
}

impl NewtonSolution {
    /// Number of Newton steps.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }
}

/// Why Newton's method failed.
#[derive(Debug, thiserror::Error)]
pub enum NewtonFailure<E> {
    /// The iterations are used up.
    #[error("no convergence within {iterations} iterations")]
    NotConverged {
        /// Steps made.
        iterations: usize,
    },
    /// The active set and the residual of an earlier iterate came back.
    #[error(
        "the active set of iteration {first} came back after {period} iterations, and no residual decreased"
    )]
    Cycling {
        /// Iterate that was reached again.
        first: usize,
        /// Steps in between.
        period: usize,
    },
    /// Steps no longer change u beyond rounding, but the residual is above the tolerance. A tolerance that the
    /// residual's own rounding allows (large stiffnesses, a small load) would have been met.
    #[error("the residual stagnates at rounding level, above the tolerance")]
    Stagnated,
    /// The residual became NaN or infinite.
    #[error("the residual is not finite")]
    NotFinite,
    /// The linear solver failed.
    #[error("the linear solver failed: {0}")]
    LinearSolver(#[source] SolverError),
    /// Sizes disagree, or prescribed values are unfit.
    #[error("the problem does not fit together: {0}")]
    Mismatch(#[source] LinearAlgebraError),
    /// Assembly of the residual, the tangent or the active set failed.
    #[error("assembly failed: {0}")]
    Assembly(#[source] E),
}

/// A failure of Newton's method with the history up to it.
#[derive(thiserror::Error)]
#[error("Newton's method failed at iteration {}: {why}", .history.len().saturating_sub(1))]
pub struct NewtonError<E: std::error::Error> {
    /// The reason.
    pub why: NewtonFailure<E>,
    /// The iterates before the failure.
    pub history: Vec<NewtonStep>,
    /// The last iterate.
    pub u: Vec<f64>,
}

// A derived one would print every unknown.
impl<E: std::error::Error> std::fmt::Debug for NewtonError<E> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NewtonError")
            .field("why", &self.why)
            .field("history", &self.history)
            .field("unknowns", &self.u.len())
            .finish()
    }
}

/// Solves R(u) = 0 on the free unknowns from `start`, with the prescribed values imposed on it. Steps are not
/// damped. `progress` is called once per iterate. Afterwards the solver still holds the last tangent.
///
/// # Errors
/// [`NewtonError`] with the reason, the history and the last iterate.
pub fn newton<P: NonlinearProblem>(
    problem: &mut P,
    prescribed: &BTreeMap<usize, f64>,
    start: Vec<f64>,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError<P::Error>> {
    let mut iteration = Iteration { u: start, history: Vec::new(), active: Vec::new() };
    match iteration.run(problem, prescribed, solver, options, progress) {
        Ok(residual) => Ok(NewtonSolution { u: iteration.u, residual, history: iteration.history }),
        Err(why) => Err(NewtonError { why, history: iteration.history, u: iteration.u }),
    }
}

/// The state of the iteration.
struct Iteration {
    u: Vec<f64>,
    history: Vec<NewtonStep>,
    active: Vec<Option<ActivePoints>>,
}

impl Iteration {
    fn run<P: NonlinearProblem>(
        &mut self,
        problem: &mut P,
        prescribed: &BTreeMap<usize, f64>,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<Vec<f64>, NewtonFailure<P::Error>> {
        let mut elimination = Elimination::new(self.u.len(), prescribed).map_err(NewtonFailure::Mismatch)?;
        elimination.impose(&mut self.u).map_err(NewtonFailure::Mismatch)?;
        if let Some(linear_part) = problem.linear_part().map_err(NewtonFailure::Assembly)? {
            let reduced = elimination.reduce_matrix(&linear_part).map_err(NewtonFailure::Mismatch)?;
            drop(linear_part);
            solver.set_linear_part(reduced).map_err(NewtonFailure::LinearSolver)?;
        }
        let mut step = None;
        let mut linear_iterations = None;
        loop {
            let residual = problem.residual(&self.u).map_err(NewtonFailure::Assembly)?;
            let mut rest = elimination.reduce(&residual).map_err(NewtonFailure::Mismatch)?;
            let residual_norm = norm(&rest);
            let active = problem.active_points(&self.u).map_err(NewtonFailure::Assembly)?;
            self.record(residual_norm, active, step, linear_iterations);
            if let Some(last) = self.history.last() {
                progress(last);
            }
            if !residual_norm.is_finite() {
                return Err(NewtonFailure::NotFinite);
            }
            let target = options.relative_tolerance * self.history[0].residual;
            if residual_norm <= target.max(options.absolute_tolerance) {
                return Ok(residual);
            }
            if let Some((first, period)) = self.cycle() {
                return Err(NewtonFailure::Cycling { first, period });
            }
            if self.stagnates() {
                return Err(NewtonFailure::Stagnated);
            }
            let iterations = self.history.len() - 1;
            if iterations >= options.max_iterations {
                return Err(NewtonFailure::NotConverged { iterations });
            }
            let tangent = problem.tangent(&self.u).map_err(NewtonFailure::Assembly)?;
            let reduced = elimination.reduce_matrix(&tangent).map_err(NewtonFailure::Mismatch)?;
            drop(tangent);
            solver.set_matrix(reduced).map_err(NewtonFailure::LinearSolver)?;
            for value in &mut rest {
                *value = -*value;
            }
            let solution =
                solver.solve(&rest, LINEAR_ACCURACY * target).map_err(NewtonFailure::LinearSolver)?;
            step = Some(norm(&solution.solution));
            linear_iterations = Some(solution.iterations);
            let change = elimination.extend_by_zero(&solution.solution).map_err(NewtonFailure::Mismatch)?;
            add_scaled(&mut self.u, 1.0, &change);
        }
    }

    fn record(
        &mut self,
        residual: f64,
        active: Option<ActivePoints>,
        step: Option<f64>,
        linear_iterations: Option<usize>,
    ) {
        let first = self.history.first().map_or(residual, |start| start.residual);
        let before = self.active.last().copied().flatten();
        self.history.push(NewtonStep {
            iteration: self.history.len(),
            residual,
            relative_residual: if residual == 0.0 { 0.0 } else { residual / first },
            active_points: active.map(|set| set.count),
            active_set_changed: active.zip(before).map(|(now, before)| now != before),
            step,
            linear_iterations,
        });
        self.active.push(active);
    }

    /// Whether the last step was lost in rounding and the residual did not fall.
    fn stagnates(&self) -> bool {
        let [.., before, last] = &self.history[..] else { return false };
        last.step.is_some_and(|step| step <= 4.0 * f64::EPSILON * norm(&self.u))
            && last.residual > 0.5 * before.residual
    }

    /// The earlier iterate that has the same active set as the last one, with other sets in between, and whose
    /// residual was not larger. For a piecewise linear problem the iterates then repeat for ever.
    fn cycle(&self) -> Option<(usize, usize)> {
        let last = self.history.len() - 1;
        let active = self.active[last]?;
        let first = (0..last).rev().find(|&k| {
            self.active[k] == Some(active)
                && self.active[k..last].iter().any(|&between| between != Some(active))
        })?;
        // Equal up to rounding counts as not decreasing.
        (self.history[last].residual >= self.history[first].residual * (1.0 - 1e-6))
            .then_some((first, last - first))
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::solve::{TangentSolver, TangentSolverOptions};

    /// −u'' = f on (0, 1) with an elastic bed below ψ. With p_i = [u_i − ψ]₋,
    /// R_i = (2 u_i − u_{i−1} − u_{i+1}) / h − h f − h k p_i + h c p_{i−1}; the drag c makes it unsymmetric.
    struct Membrane {
        n: usize,
        f: f64,
        stiffness: f64,
        drag: f64,
        obstacle: f64,
    }

    impl Membrane {
        fn h(&self) -> f64 {
            1.0 / self.n as f64
        }

        fn contact(&self, u: &[f64]) -> Vec<f64> {
            u.iter().map(|value| (self.obstacle - value).max(0.0)).collect()
        }
    }

    impl NonlinearProblem for Membrane {
        type Error = Infallible;

        fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, Infallible> {
            let (h, contact) = (self.h(), self.contact(u));
            Ok((0..=self.n)
                .map(|i| {
                    if i == 0 || i == self.n {
                        return 12345.0; // prescribed rows must not matter
                    }
                    (2.0 * u[i] - u[i - 1] - u[i + 1]) / h - h * self.f - h * self.stiffness * contact[i]
                        + h * self.drag * contact[i - 1]
                })
                .collect())
        }

        fn tangent(&mut self, u: &[f64]) -> Result<CsrMatrix, Infallible> {
            let (h, contact) = (self.h(), self.contact(u));
            let active = |i: usize| if contact[i] > 0.0 { h } else { 0.0 };
            let mut triplets = vec![(0, 0, 1.0), (self.n, self.n, 1.0)];
            for i in 1..self.n {
                triplets.push((i, i, 2.0 / h + self.stiffness * active(i)));
                triplets.push((i, i - 1, -1.0 / h - self.drag * active(i - 1)));
                triplets.push((i, i + 1, -1.0 / h));
            }
            triplets.extend([(0, 1, 0.0), (self.n, self.n - 1, 0.0)]);
            Ok(CsrMatrix::from_triplets(self.n + 1, self.n + 1, &triplets).unwrap())
        }

        fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, Infallible> {
            let contact = self.contact(u);
            Ok(Some(ActivePoints::from_numbers((0..=self.n).filter(|&i| contact[i] > 0.0))))
        }
    }

    fn ends(n: usize) -> BTreeMap<usize, f64> {
        BTreeMap::from([(0, 0.0), (n, 0.0)])
    }

    #[test]
    fn an_obstacle_problem_meets_its_closed_form() {
        // −u'' = −8 above ψ = −1/4: u touches at distance a = √(2 · ¼ / 8) = ¼ from the ends, and outside
        // the contact zone u = 4 (x − a)² − ¼. Quadratics are exact in finite differences.
        let n = 64;
        let mut problem = Membrane { n, f: -8.0, stiffness: 1e6, drag: 0.0, obstacle: -0.25 };
        let mut solver = TangentSolver::default();
        let mut seen = Vec::new();
        let solution = newton(
            &mut problem,
            &ends(n),
            vec![0.0; n + 1],
            &mut solver,
            &NewtonOptions::default(),
            &mut |step| seen.push(step.clone()),
        )
        .unwrap();
        for (i, value) in solution.u.iter().enumerate() {
            let x = i as f64 / n as f64;
            let from_end = x.min(1.0 - x);
            let exact = if from_end < 0.25 { 4.0 * (from_end - 0.25).powi(2) - 0.25 } else { -0.25 };
            // The bed yields by f / stiffness.
            assert!((value - exact).abs() < 1.01 * 8e-6, "u({x}) = {value}, expected {exact}");
        }
        assert_eq!(seen, solution.history);
        assert_eq!(seen[0].step, None);
        let last = seen.last().unwrap();
        assert!(last.relative_residual <= 1e-10 && last.active_set_changed == Some(false));
        assert_eq!(last.linear_iterations, Some(0));
        // Contact on [¼, ¾]: 33 nodes; those on the rim carry half a node's load or none.
        assert!((31..=33).contains(&last.active_points.unwrap()));
        assert!(solution.iterations() <= 15, "{} iterations", solution.iterations());
        // A stiffer bed makes the tolerance unreachable: h k ε is 1e-9 of the load. That is said at once.
        problem.stiffness = 1e9;
        let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
        let error =
            newton(&mut problem, &ends(n), vec![0.0; n + 1], &mut solver, &options, &mut |_| ()).unwrap_err();
        assert!(matches!(error.why, NewtonFailure::Stagnated), "{error}");
        assert!(error.history.len() <= 18 && error.history.last().unwrap().relative_residual < 1e-8);
    }

    #[test]
    fn an_unsymmetric_problem_is_solved_to_rounding_with_few_factorisations() {
        let n = 64;
        let mut problem = Membrane { n, f: -8.0, stiffness: 2000.0, drag: 500.0, obstacle: -0.25 };
        let mut solver = TangentSolver::new(TangentSolverOptions::default());
        let run = |problem: &mut Membrane, solver: &mut TangentSolver| {
            newton(problem, &ends(n), vec![0.0; n + 1], solver, &NewtonOptions::default(), &mut |_| ())
                .unwrap()
        };
        let solution = run(&mut problem, &mut solver);
        let residual = problem.residual(&solution.u).unwrap();
        assert!(norm(&residual[1..n]) < 1e-11 * solution.history[0].residual);
        assert!(solution.history.iter().any(|step| step.linear_iterations > Some(0)));
        assert!(solver.report().factorisations <= solution.iterations());
        // An affine problem takes one step: the same obstacle far away.
        problem.obstacle = -100.0;
        let straight = run(&mut problem, &mut solver);
        assert_eq!(straight.iterations(), 1);
        for (i, value) in straight.u.iter().enumerate() {
            let x = i as f64 / n as f64;
            assert!((value + 4.0 * x * (1.0 - x)).abs() < 1e-12);
        }
    }

    #[test]
    fn prescribed_values_are_imposed_and_reactions_returned() {
        let mut problem = Membrane { n: 4, f: 0.0, stiffness: 1.0, drag: 0.0, obstacle: -100.0 };
        let prescribed = BTreeMap::from([(0, 1.0), (4, 3.0)]);
        let mut solver = TangentSolver::default();
        let options = NewtonOptions::default();
        let run = |problem: &mut Membrane, solver: &mut TangentSolver, start: Vec<f64>| {
            newton(problem, &prescribed, start, solver, &options, &mut |_| ())
        };
        let solution = run(&mut problem, &mut solver, vec![0.0; 5]).unwrap();
        for (value, exact) in solution.u.iter().zip([1.0, 1.5, 2.0, 2.5, 3.0]) {
            assert!((value - exact).abs() < 1e-14);
        }
        assert_eq!(solution.residual[0], 12345.0);
        // Start at the solution: no step. A start of the wrong size is an error.
        let again = run(&mut problem, &mut solver, vec![1.0, 1.5, 2.0, 2.5, 3.0]).unwrap();
        assert_eq!(again.iterations(), 0);
        let error = run(&mut problem, &mut solver, vec![0.0; 3]).unwrap_err();
        assert!(matches!(error.why, NewtonFailure::Mismatch(_)));
    }

    /// A scalar function, given as (value, slope); active where u > 0.
    struct Scalar<F: FnMut(f64) -> (f64, f64)>(F);

    impl<F: FnMut(f64) -> (f64, f64)> NonlinearProblem for Scalar<F> {
        type Error = LinearAlgebraError;

        fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
            Ok(vec![(self.0)(u[0]).0])
        }

        fn tangent(&mut self, u: &[f64]) -> Result<CsrMatrix, LinearAlgebraError> {
            CsrMatrix::from_triplets(1, 1, &[(0, 0, (self.0)(u[0]).1)])
        }

        fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, LinearAlgebraError> {
            Ok(Some(ActivePoints::from_numbers((u[0] > 0.0).then_some(0))))
        }
    }

    fn scalar(
        f: impl FnMut(f64) -> (f64, f64),
        start: f64,
    ) -> Result<NewtonSolution, NewtonError<LinearAlgebraError>> {
        let mut solver = TangentSolver::default();
        let options = NewtonOptions { max_iterations: 8, ..NewtonOptions::default() };
        newton(&mut Scalar(f), &BTreeMap::new(), vec![start], &mut solver, &options, &mut |_| ())
    }

    #[test]
    fn a_cycle_is_recognised() {
        // R(u) = u + 1 for u > 0 (root −1) and u − 1 for u ≤ 0 (root 1): Newton goes 1 → −1 → 1.
        let error = scalar(|u| if u > 0.0 { (u + 1.0, 1.0) } else { (u - 1.0, 1.0) }, 1.0).unwrap_err();
        assert!(matches!(error.why, NewtonFailure::Cycling { first: 0, period: 2 }), "{error}");
        assert_eq!(error.history.len(), 3);
        assert_eq!(error.u, [1.0]);
    }

    #[test]
    fn failures_are_told_apart() {
        // R = arctan u diverges from |u| > 1.39; from 1.2 it converges.
        assert!(scalar(|u| (u.atan(), 1.0 / (1.0 + u * u)), 1.2).unwrap().u[0].abs() < 1e-10);
        let error = scalar(|u| (u * u, 2.0 * u), 1.0).unwrap_err(); // a double root: halving only
        assert!(matches!(error.why, NewtonFailure::NotConverged { iterations: 8 }));
        assert_eq!(error.history.len(), 9);
        let error = scalar(|u| (1.0 / u, 1.0), 0.0).unwrap_err();
        assert!(matches!(error.why, NewtonFailure::NotFinite));
        let error = scalar(|_| (1.0, 0.0), 0.0).unwrap_err();
        assert!(matches!(
            error.why,
            NewtonFailure::LinearSolver(SolverError::LinearAlgebra(LinearAlgebraError::Singular {
                unknown: 0,
                ..
            }))
        ));
    }
}
