//! The way to a solution through other values of θ.

use forms_fem::prelude::*;
use forms_fem::solve::{LoadPath, LoadStepError, LoadSteps};

use crate::contact_problem::ContactProblem;
use crate::law::WithTheta;

/// The way of [`ContactProblem::solve_through`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThetaPath {
    /// The θ of the first problem.
    pub from: f64,
    /// Equal steps from there to the problem's own θ.
    pub steps: usize,
    /// Line search of the first problem. A search on the potential needs `from` = 1 and a law with a potential.
    pub line_search: LineSearch,
}

impl Default for ThetaPath {
    /// From θ = 1, by a line search on the potential, in two steps.
    fn default() -> Self {
        ThetaPath { from: 1.0, steps: 2, line_search: LineSearch::OnPotential }
    }
}

/// The θ that was not reached, with the last solution.
pub type ThetaPathError<const D: usize> = Box<LoadStepError<Field<D>, SolveError>>;

impl<const D: usize, L: WithTheta<D>> ContactProblem<D, L>
where
    Dim: Dimension<D>,
{
    /// Solution of the direct problem for hard starts: first at another θ (1 has a potential, so that a line search may help), then at
    /// values between it and the problem's own θ, each from the solution before. A step that fails is halved.
    /// `progress` is called with θ and each iterate.
    ///
    /// # Errors
    /// The θ that could not be reached, the last solution, and why Newton's method failed.
    pub fn solve_through(
        &self,
        path: ThetaPath,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        mut progress: impl FnMut(f64, &NewtonStep),
    ) -> Result<LoadPath<Field<D>>, ThetaPathError<D>> {
        let ThetaPath { from, steps, line_search } = path;
        // All problems have one pattern; that it cannot be made is reported by the first.
        let _ = self.pattern();
        let mut solve_at = |theta: f64, line_search, first: &Field<D>| {
            let mut problem = self.clone();
            problem.law = self.law.with_theta(theta);
            let options = NewtonOptions { line_search, ..options.clone() };
            let direct = problem.direct()?.start(first).solver(&mut *solver).options(options);
            let solved = direct.each_step(|step| progress(theta, step)).solve();
            solved.map(Solved::into_field)
        };
        let zero = Field::zero(&self.space);
        let first = match solve_at(from, line_search, &zero) {
            Ok(first) => first,
            Err(why) => {
                let (state, steps) = (zero, vec![]);
                return Err(Box::new(LoadStepError { factor: from, state, failed: from, why, steps }));
            }
        };
        let to = self.law.theta();
        if from == to {
            return Ok(LoadPath { state: first, steps: vec![] });
        }
        let count = steps.max(1);
        let thetas = (1..=count).map(|k| from + (to - from) * k as f64 / count as f64);
        let smallest_increment = (to - from).abs() / (1024.0 * count as f64);
        let steps = LoadSteps { start: from, smallest_increment, ..LoadSteps::through(thetas) };
        let one = |theta: f64, before: &Field<D>| solve_at(theta, self.law.line_search(), before);
        steps.run(first, one).map_err(Box::new)
    }
}
