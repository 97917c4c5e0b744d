//! The direct problem with friction, from a state in which whatever presses sticks.

use std::borrow::Cow;

use forms_fem::prelude::*;
use forms_fem::solve::NewtonFailure;

use crate::contact_problem::ContactProblem;
use crate::law::{ContactLaw, WithFriction};

/// The direct problem of [`ContactProblem::from_stick`], with the choices of a [`Problem`].
pub struct FromStick<'a, const D: usize, L> {
    problem: &'a ContactProblem<D, L>,
    /// The same with stick wherever something presses.
    sticking: ContactProblem<D, L>,
    start: Cow<'a, Field<D>>,
    solver: Option<&'a mut dyn LinearSolver>,
    progress: Option<Progress<'a>>,
}

/// A listener to Newton's iterates.
type Progress<'a> = Box<dyn FnMut(&NewtonStep) + 'a>;

/// Most steps towards a state in which all sticks.
const STEPS_TO_STICK: usize = 10;

/// Whether Newton's method went on without an end, and nothing else is wrong.
fn has_not_converged(error: &SolveError) -> bool {
    matches!(
        error.why,
        NewtonFailure::NotConverged { .. }
            | NewtonFailure::Cycling { .. }
            | NewtonFailure::Stagnated
            | NewtonFailure::NoDescent
    )
}

impl<const D: usize, L: WithFriction<D>> ContactProblem<D, L> {
    /// The direct problem from a state in which whatever presses sticks, for which a few steps are made first. Newton's method
    /// finds the places that slip from there; from u = 0, where nothing presses and nothing is held, it may go back and forth
    /// for ever, also by a line search. If it does so from stick, it is tried from the start.
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn from_stick(&self) -> Result<FromStick<'_, D, L>, AssemblyError> {
        self.law.check(self.law.direct().name())?;
        // Both problems have one pattern.
        self.pattern()?;
        let sticking = self.with_law(self.law.sticking());
        let start = Cow::Owned(Field::zero(&self.space));
        Ok(FromStick { problem: self, sticking, start, solver: None, progress: None })
    }
}

impl<'a, const D: usize, L: ContactLaw<D>> FromStick<'a, D, L> {
    /// The first iterate of the steps towards stick; zero unless it is given.
    pub fn start(mut self, start: &'a Field<D>) -> Self {
        self.start = Cow::Borrowed(start);
        self
    }

    /// The linear solver of all steps, in place of a [`TangentSolver`].
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = Some(solver);
        self
    }

    /// Is called with each iterate, of the steps towards stick as well.
    pub fn each_step(mut self, progress: impl FnMut(&NewtonStep) + 'a) -> Self {
        self.progress = Some(Box::new(progress));
        self
    }

    /// The solution; its history is that of the last run of Newton's method.
    ///
    /// # Errors
    /// [`SolveError`]; a parameter out of its range.
    pub fn solve(self) -> Result<Solved<D>, SolveError> {
        let FromStick { problem, sticking, start, solver, progress } = self;
        let start: &Field<D> = &start;
        let mut own = TangentSolver::default();
        let solver: &mut dyn LinearSolver = match solver {
            Some(lent) => lent,
            None => &mut own,
        };
        let mut progress = progress.unwrap_or_else(|| Box::new(|_| ()));
        let options = NewtonOptions {
            line_search: problem.law.line_search(),
            max_iterations: STEPS_TO_STICK,
            ..NewtonOptions::default()
        };
        let stuck = sticking.direct()?.options(options).start(start).solver(&mut *solver);
        let first = match stuck.each_step(&mut progress).solve() {
            Ok(solved) => solved.into_field(),
            // The steps lead somewhere near, which is all that they are for.
            Err(error) if has_not_converged(&error) => {
                Field::from_values(&problem.space, error.u).unwrap_or_else(|_| start.clone())
            }
            Err(error) => return Err(error),
        };
        let direct = problem.direct()?.start(&first).solver(&mut *solver);
        let direct = direct.each_step(&mut progress).solve();
        match direct {
            Err(error) if has_not_converged(&error) => {
                problem.direct()?.start(start).solver(solver).each_step(progress).solve()
            }
            other => other,
        }
    }
}
