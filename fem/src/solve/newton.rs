//! Semismooth Newton on the free unknowns: undamped, or with a line search on the potential where there is one.

mod few;
mod history;
mod line_search;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

use super::elimination::Elimination;
use super::linear_solver::LinearSolver;
use crate::linear_algebra::vector::{add_scaled, norm};
use crate::linear_algebra::{BlockMatrix, CsrMatrix};
use few::changed_entries;
pub use history::{NewtonError, NewtonFailure, NewtonOptions, NewtonSolution, NewtonStep};
pub use line_search::LineSearch;
use line_search::{check_potential, line_search};

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
    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, Self::Error>;

    /// The part of every tangent that does not depend on u, if the problem knows it and tells of each tangent where
    /// it differs.
    ///
    /// # Errors
    /// If assembly fails.
    fn linear_part(&mut self) -> Result<Option<&BlockMatrix>, Self::Error> {
        Ok(None)
    }

    /// What R(u) has beyond an affine function with the linear part for its matrix, if the problem knows it. It reads
    /// the unknowns alone in whose rows or columns some tangent differs from the linear part.
    ///
    /// # Errors
    /// If assembly fails.
    fn nonlinear_residual(&mut self, _u: &[f64]) -> Result<Option<Vec<f64>>, Self::Error> {
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

/// A tangent, lent by the problem that keeps it.
#[derive(Clone, Debug)]
pub struct Tangent<'a> {
    /// All rows and columns.
    pub matrix: Cow<'a, BlockMatrix>,
    /// Places among the matrix's values, as ascending ranges of whole blocks, outside of which it is equal to the
    /// problem's linear part; none where the problem does not know them.
    pub changed: Option<&'a [Range<usize>]>,
}

impl From<CsrMatrix> for Tangent<'_> {
    /// A tangent of which nothing else is known.
    fn from(matrix: CsrMatrix) -> Self {
        Tangent { matrix: Cow::Owned(matrix.into()), changed: None }
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

/// Linear systems are solved to this part of Newton's own target, so that the converged residual is at rounding
/// level and not just below the target.
const LINEAR_ACCURACY: f64 = 1e-4;

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
    match Elimination::new(start.len(), prescribed) {
        Ok(elimination) => {
            newton_eliminating(problem, elimination, Start::at(start), solver, options, progress)
        }
        Err(why) => Err(NewtonError { why: NewtonFailure::Mismatch(why), history: vec![], u: start }),
    }
}

/// Where Newton's method starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// The first iterate, before the prescribed values are imposed.
    pub u: Vec<f64>,
    /// A guess at the iterates to come. A solver that condenses learns from the tangent there which unknowns the
    /// nonlinearity may touch; a wrong guess costs time and nothing else.
    pub guess: Option<Vec<f64>>,
}

impl Start {
    /// This start, without a guess.
    pub fn at(u: Vec<f64>) -> Self {
        Start { u, guess: None }
    }
}

/// [`newton()`] with any elimination: u = C y + d, residual Cᵀ R, tangent Cᵀ K C.
///
/// # Errors
/// As [`newton()`].
pub fn newton_eliminating<P: NonlinearProblem>(
    problem: &mut P,
    elimination: Elimination,
    start: Start,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError<P::Error>> {
    let Start { u, guess } = start;
    let mut iteration = Iteration { u, history: Vec::new(), active: Vec::new(), options, progress };
    match iteration.run(problem, elimination, guess, solver) {
        Ok(residual) => Ok(NewtonSolution { u: iteration.u, residual, history: iteration.history }),
        Err(why) => Err(NewtonError { why, history: iteration.history, u: iteration.u }),
    }
}

/// The state of the iteration.
struct Iteration<'a> {
    u: Vec<f64>,
    history: Vec<NewtonStep>,
    active: Vec<Option<ActivePoints>>,
    options: &'a NewtonOptions,
    progress: &'a mut dyn FnMut(&NewtonStep),
}

/// The residual on all unknowns, and on the free ones.
type Residuals = (Vec<f64>, Vec<f64>);

/// How an iterate was reached.
#[derive(Clone, Copy, Default)]
struct Step {
    length: Option<f64>,
    damping: Option<f64>,
    linear_iterations: Option<usize>,
    condensed_unknowns: Option<usize>,
}

impl Iteration<'_> {
    fn run<P: NonlinearProblem>(
        &mut self,
        problem: &mut P,
        mut elimination: Elimination,
        guess: Option<Vec<f64>>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Vec<f64>, NewtonFailure<P::Error>> {
        elimination.impose(&mut self.u).map_err(NewtonFailure::Mismatch)?;
        let mut linear_part = None;
        // With related unknowns the reduced matrix is no submatrix, and is made anew for each tangent.
        if elimination.only_prescribes()
            && let Some(matrix) = problem.linear_part().map_err(NewtonFailure::Assembly)?
        {
            let reduced = Arc::new(elimination.reduce_matrix(matrix).map_err(NewtonFailure::Mismatch)?);
            solver.set_linear_part(&reduced).map_err(NewtonFailure::LinearSolver)?;
            linear_part = Some(reduced);
        }
        let (mut residual, mut rest) = self.look(problem, &elimination, Step::default())?;
        if !self.finished()?
            && let Some(linear_part) = &linear_part
        {
            if let Some(guess) = guess {
                let entries = changed_entries(problem, &mut elimination, &guess)?;
                solver.expect_changed(linear_part, &entries).map_err(NewtonFailure::LinearSolver)?;
            }
            if self.options.line_search == LineSearch::Off
                && let Some(solver) = solver.condensing()
                && self.iterate_on_few(problem, &mut elimination, linear_part, &residual, solver)?
            {
                residual = problem.residual(&self.u).map_err(NewtonFailure::Assembly)?;
                rest = elimination.reduce(&residual).map_err(NewtonFailure::Mismatch)?;
                self.judge_again(norm(&rest));
            }
        }
        while !self.finished()? {
            let options = self.options;
            let tangent = problem.tangent(&self.u).map_err(NewtonFailure::Assembly)?;
            if options.line_search == LineSearch::OnPotential {
                check_potential(&mut elimination, &tangent.matrix)?;
            }
            match (&linear_part, tangent.changed) {
                (Some(linear_part), Some(changed)) => {
                    let entries = elimination.reduce_places(&tangent.matrix, changed);
                    let entries = entries.map_err(NewtonFailure::Mismatch)?;
                    solver.set_changed(linear_part, &entries)
                }
                _ => {
                    let reduced = elimination.reduce_matrix(&tangent.matrix);
                    let reduced = reduced.map_err(NewtonFailure::Mismatch)?;
                    drop(tangent);
                    solver.set_matrix(reduced)
                }
            }
            .map_err(NewtonFailure::LinearSolver)?;
            for value in &mut rest {
                *value = -*value;
            }
            let solution =
                solver.solve(&rest, LINEAR_ACCURACY * self.target()).map_err(NewtonFailure::LinearSolver)?;
            let step = Step {
                linear_iterations: Some(solution.iterations),
                condensed_unknowns: solver.condensed_unknowns(),
                ..Step::default()
            };
            let change = elimination.extend_by_zero(&solution.solution).map_err(NewtonFailure::Mismatch)?;
            let damping = match options.line_search {
                LineSearch::Off => 1.0,
                LineSearch::OnPotential => line_search(problem, &self.u, &change)?,
            };
            add_scaled(&mut self.u, damping, &change);
            let step =
                Step { damping: Some(damping), length: Some(damping * norm(&solution.solution)), ..step };
            (residual, rest) = self.look(problem, &elimination, step)?;
        }
        Ok(residual)
    }

    /// The residual at the current iterate, on all unknowns and on the free ones; the iterate enters the history.
    fn look<P: NonlinearProblem>(
        &mut self,
        problem: &mut P,
        elimination: &Elimination,
        step: Step,
    ) -> Result<Residuals, NewtonFailure<P::Error>> {
        let residual = problem.residual(&self.u).map_err(NewtonFailure::Assembly)?;
        let rest = elimination.reduce(&residual).map_err(NewtonFailure::Mismatch)?;
        let active = problem.active_points(&self.u).map_err(NewtonFailure::Assembly)?;
        self.record(norm(&rest), active, step);
        Ok((residual, rest))
    }

    /// The residual that counts as zero.
    fn target(&self) -> f64 {
        let first = self.history.first().map_or(0.0, |start| start.residual);
        (self.options.relative_tolerance * first).max(self.options.absolute_tolerance)
    }

    /// Whether the last iterate is the solution; an error if there is no sense in going on.
    fn finished<E>(&self) -> Result<bool, NewtonFailure<E>> {
        let Some(last) = self.history.last() else { return Ok(false) };
        if !last.residual.is_finite() {
            return Err(NewtonFailure::NotFinite);
        }
        if last.residual <= self.target() {
            return Ok(true);
        }
        if let Some((first, period)) = self.cycle() {
            return Err(NewtonFailure::Cycling { first, period });
        }
        if self.stagnates() {
            return Err(NewtonFailure::Stagnated);
        }
        let iterations = self.history.len() - 1;
        if iterations >= self.options.max_iterations {
            return Err(NewtonFailure::NotConverged { iterations });
        }
        Ok(false)
    }

    /// The last iterate was judged by its condensed residual; this is the whole one.
    fn judge_again(&mut self, residual: f64) {
        let first = self.history.first().map_or(residual, |start| start.residual);
        if let Some(last) = self.history.last_mut() {
            last.residual = residual;
            last.relative_residual = if residual == 0.0 { 0.0 } else { residual / first };
        }
    }

    fn record(&mut self, residual: f64, active: Option<ActivePoints>, step: Step) {
        let first = self.history.first().map_or(residual, |start| start.residual);
        let before = self.active.last().copied().flatten();
        self.active.push(active);
        let step = NewtonStep {
            iteration: self.history.len(),
            residual,
            relative_residual: if residual == 0.0 { 0.0 } else { residual / first },
            active_points: active.map(|set| set.count),
            active_set_changed: active.zip(before).map(|(now, before)| now != before),
            step: step.length,
            damping: step.damping,
            linear_iterations: step.linear_iterations,
            condensed_unknowns: step.condensed_unknowns,
        };
        (self.progress)(&step);
        self.history.push(step);
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
mod tests;
