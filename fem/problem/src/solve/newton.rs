//! Semismooth Newton on the free unknowns: undamped, or with a line search on the potential or on the residual. Its loop is
//! `iterate`: judge the last iterate, find a change of it, take the change.

mod active_points;
mod bounded;
mod condensation;
mod convergence;
mod cycles;
mod free_equations;
mod imposed;
mod iterates;
mod judgement;
mod line_search;
mod nonlinear_problem;
mod oscillation;
mod partly_linear;
mod report;
mod tangent;
mod watchdog;

use std::collections::BTreeMap;

pub use self::active_points::ActivePoints;
pub use self::bounded::{BoundFailure, HeldUnknown, UnknownBounds};
use super::divided::Together;
use super::elimination::Elimination;
use super::linear_solver::LinearSolver;
use bounded::ActiveSet;
use condensation::WithLinearPart;
pub use convergence::FieldUnknowns;
use convergence::{Fields, Norms};
use free_equations::{FreeEquations, Residuals};
use iterates::{Iterates, Step};
pub use line_search::LineSearch;
pub use nonlinear_problem::NonlinearProblem;
pub use oscillation::{Oscillation, Remedy, SwitchingPoint};
pub use partly_linear::{LinearPart, NonlinearTangent, PartlyLinear};
pub use report::{
    NewtonError, NewtonFailure, NewtonOptions, NewtonSolution, NewtonStep, PrescribedValues, WorstEquation,
};
pub use tangent::{Products, Tangent};

/// Newton's method for R(u) = 0 on the free unknowns from `start`, with the prescribed values imposed on it. `progress` is called once
/// per iterate. Afterwards the solver still holds the last tangent that it was given. [`NewtonOptions`] says when an iterate
/// is the solution.
///
/// # Errors
/// [`NewtonError`] with the reason, the history and the last iterate.
pub fn newton(
    problem: &mut dyn NonlinearProblem,
    prescribed: &BTreeMap<usize, f64>,
    start: Vec<f64>,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError> {
    match Elimination::new(start.len(), prescribed) {
        Ok(elimination) => {
            newton_eliminating(problem, elimination, Start::at(start), solver, options, progress)
        }
        Err(why) => {
            let why = NewtonFailure::Mismatch(why);
            Err(NewtonError { u: start, ..why.into() })
        }
    }
}

/// The start of Newton's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// The first iterate, before the prescribed values are imposed.
    pub u: Vec<f64>,
    /// A guess at the iterates to come. A solver that condenses learns from the tangent there which unknowns the
    /// nonlinearity may touch; a wrong guess costs time and nothing else.
    pub guess: Option<Vec<f64>>,
    /// Unknowns that the nonlinearity is expected to touch, in this problem or in later ones with the same solver. They are as harmless.
    pub expected: Vec<usize>,
}

impl Start {
    /// This start, without a guess.
    pub fn at(u: Vec<f64>) -> Self {
        Start { u, guess: None, expected: vec![] }
    }
}

/// [`newton()`] with any elimination: u = C y + d, residual Cᵀ R, tangent Cᵀ K C.
///
/// # Errors
/// As [`newton()`].
pub fn newton_eliminating(
    problem: &mut dyn NonlinearProblem,
    elimination: Elimination,
    start: Start,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError> {
    newton_bounded(problem, elimination, None, start, solver, options, progress)
}

/// [`newton_eliminating()`] with bounds on unknowns, where there are any: see [`UnknownBounds`].
///
/// # Errors
/// As [`newton()`]; [`NewtonFailure::Bounds`] where a bound does not fit its unknown.
pub fn newton_bounded(
    problem: &mut dyn NonlinearProblem,
    elimination: Elimination,
    bounds: Option<&UnknownBounds>,
    start: Start,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError> {
    let Start { u, guess, expected } = start;
    let together = Together::new(problem.divided(), elimination.free());
    let fields = Fields::new(&problem.fields(), &elimination, &together);
    let set = bounds.map(|bounds| ActiveSet::new(bounds, &elimination, &fields, options.line_search));
    let set = match set.transpose() {
        Ok(set) => set,
        Err(why) => return Err(NewtonError { u, ..why.into() }),
    };
    let iterates = Iterates::new(u, fields, options, progress);
    let mut equations = FreeEquations::new(problem, elimination, solver, iterates);
    equations.bounds = set;
    let found = condensation::begin(&mut equations).and_then(|linear_part| match linear_part {
        Some(linear_part) => {
            WithLinearPart { free: &mut equations, linear_part }.iterate_from(guess, &expected)
        }
        None => iterate(&mut equations),
    });
    let found = found.and_then(|()| equations.unknowns_at_bounds());
    let (Iterates { u, history, .. }, residual, worst) = equations.into_parts();
    // A judgement without an exchange is none.
    match together.check().map_err(NewtonFailure::Exchange).and(found) {
        Ok(held) => Ok(NewtonSolution { u, residual, history, held }),
        Err(why) => Err(NewtonError { history, u, worst: worst.map(Box::new), ..why.into() }),
    }
}

/// Newton's method: K δ = −R is solved, and the step or a part of it is taken, until an iterate is the solution.
///
/// # Errors
/// [`NewtonFailure`].
fn iterate(equations: &mut dyn Equations) -> Result<(), NewtonFailure> {
    loop {
        let change = match equations.judge()? {
            Verdict::Solution => return Ok(()),
            Verdict::Correct(values) => Change { values, origin: Origin::Judgement },
            Verdict::GoOn => equations.newton_change()?,
        };
        equations.take(change)?;
    }
}

/// The outcome of a judgement.
pub(in crate::solve) enum Verdict {
    /// The last iterate is the solution.
    Solution,
    /// It is to be changed by this, on all unknowns, and judged again.
    Correct(Vec<f64>),
    /// It is not the solution.
    GoOn,
}

/// A change of the unknowns of some equations.
pub(in crate::solve) struct Change {
    /// One entry per unknown of the equations.
    pub values: Vec<f64>,
    pub origin: Origin,
}

/// The origin of a change.
#[derive(Clone, Copy)]
pub(in crate::solve) enum Origin {
    /// −K⁻¹R with the tangent at the last iterate.
    Tangent { linear_iterations: usize, condensed_unknowns: Option<usize> },
    /// A correction from the judgement of the last iterate. It says nothing of the progress of Newton's method.
    Judgement,
}

/// Equations on which Newton's loop iterates: those of all free unknowns, or fewer. They keep their iterates.
pub(in crate::solve) trait Equations {
    /// Whether the last iterate is the solution, or what to do.
    ///
    /// # Errors
    /// If there is no sense in going on.
    fn judge(&mut self) -> Result<Verdict, NewtonFailure>;

    /// −K⁻¹R at the last iterate.
    ///
    /// # Errors
    /// If assembly or the linear solver fails.
    fn newton_change(&mut self) -> Result<Change, NewtonFailure>;

    /// Takes a change, or a part of it, and enters the next iterate into the history.
    ///
    /// # Errors
    /// If assembly fails, or no part of the change serves.
    fn take(&mut self, change: Change) -> Result<(), NewtonFailure>;
}

#[cfg(test)]
mod tests;
