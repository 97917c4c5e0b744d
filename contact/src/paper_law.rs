//! The paper's law: its three adjoint states, and the way to a solution through other values of θ.

use forms_fem::prelude::*;
use forms_fem::solve::{LoadPath, LoadStepError, LoadSteps};

use crate::contact_law;
use crate::contact_problem::{ContactProblem, RESOLUTION};
use crate::forms;

contact_law!(forms {
    direct: direct,
    region: gamma_c,
    indicator: contact_indicator,
    criterion: criterion,
    adjoint: discrete_adjoint,
    shape_gradient: shape_gradient,
    diameter_gradient: diameter_gradient,
    threshold: normal_stress_product(elasticity, gamma0, theta),
    positive: gamma0,
});

/// The paper's three adjoint states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adjoint {
    /// p̃_h of (21): the adjoint of the discrete problem.
    Discrete,
    /// p_h of (22): Nitsche's method for the continuous adjoint.
    Consistent,
    /// p_h of (41): (22) with an extended Neumann zone.
    Extended,
}

/// The way of [`ContactProblem::solve_through`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThetaPath {
    /// The θ of the first problem.
    pub from: f64,
    /// Equal steps from there to the problem's own θ.
    pub steps: usize,
    /// For the first problem; on its potential only where `from` is 1.
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

impl<const D: usize> ContactProblem<D>
where
    Dim: Dimension<D>,
{
    /// Solves for one of the paper's adjoint states at the displacement u; it vanishes on Γ_D. A solver that has solved the
    /// direct problem reuses its analysis and, where it can, its factor.
    ///
    /// # Errors
    /// [`SolveError`], also for data that do not fit.
    pub fn solve_adjoint(
        &self,
        adjoint: Adjoint,
        u: &Field<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Solved<D>, SolveError> {
        match adjoint {
            Adjoint::Discrete => self.adjoint(u)?.solver(solver).solve(),
            Adjoint::Consistent => self.state(self.law.consistent_adjoint(u), u)?.solver(solver).solve(),
            Adjoint::Extended => {
                // Its zone is that of β_h > ξ.
                let assembler = match self.splits_facets() {
                    false => self.assembler.clone(),
                    true => {
                        let (indicator, region) =
                            (self.law.extended_indicator(u), &self.law.regions.gamma_c.0.name);
                        self.assembler.split_at_zeros(&indicator, region, RESOLUTION)?
                    }
                };
                self.state_by(self.law.extended_adjoint(u), assembler)?.solver(solver).solve()
            }
        }
    }

    /// Solves (14) for hard starts: first at another θ (1 has a potential, so that a line search may help), then at
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
        let mut problem = self.clone();
        let mut solve_at = |theta: f64, line_search, first: &Field<D>| {
            problem.law.data.theta = theta;
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
        let to = self.law.data.theta;
        if from == to {
            return Ok(LoadPath { state: first, steps: vec![] });
        }
        let count = steps.max(1);
        let thetas = (1..=count).map(|k| from + (to - from) * k as f64 / count as f64);
        let smallest_increment = (to - from).abs() / (1024.0 * count as f64);
        let steps = LoadSteps { start: from, factors: thetas.collect(), smallest_increment };
        let one = |theta: f64, before: &Field<D>| solve_at(theta, LineSearch::Off, before);
        steps.run(first, one).map_err(Box::new)
    }
}
