//! Semismooth Newton on the free unknowns: undamped, or with a line search on the potential or on the residual.

mod active_points;
mod condensed;
mod convergence;
mod cycles;
mod imposed;
mod judgement;
mod line_search;
mod report;
mod tangent;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use self::active_points::ActivePoints;
use super::elimination::Elimination;
use super::linear_solver::LinearSolver;
use crate::assemble::{AssemblyError, Terms};
use crate::linear_algebra::vector::{add_scaled, norm};
use crate::linear_algebra::{BlockMatrix, CsrMatrix};
use condensed::{nonlinear_changes, share_linear_part};
pub use convergence::FieldUnknowns;
use convergence::{Fields, Norms, mark};
use judgement::{Corrections, Verdict};
pub use line_search::LineSearch;
use line_search::{Forced, Taken, along_potential, along_residual, check_potential};
pub use report::{NewtonError, NewtonFailure, NewtonOptions, NewtonSolution, NewtonStep, WorstEquation};
pub use tangent::{NonlinearTangent, Products, Tangent};

/// A system R(u) = 0 with a (generalised) derivative. Vectors and matrices have all unknowns, the prescribed
/// ones included. A problem that is not assembled from a form reports its errors by [`AssemblyError::other`].
pub trait NonlinearProblem {
    /// R(u), one entry per unknown.
    ///
    /// # Errors
    /// If assembly fails.
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError>;

    /// An element of the generalised derivative of R at u.
    ///
    /// # Errors
    /// If assembly fails.
    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError>;

    /// The part of every tangent that does not depend on u, if the problem knows it and tells of each tangent where
    /// it differs.
    ///
    /// # Errors
    /// If assembly fails.
    fn linear_part(&mut self) -> Result<Option<&BlockMatrix>, AssemblyError> {
        Ok(None)
    }

    /// Whether the linear part is proved to be symmetric, except for rounding.
    fn has_symmetric_linear_part(&self) -> bool {
        false
    }

    /// The part of R(u) beyond an affine function with the linear part for its matrix, if the problem knows it. It reads
    /// the unknowns alone in whose rows or columns some tangent differs from the linear part.
    ///
    /// # Errors
    /// If assembly fails.
    fn nonlinear_residual(&mut self, _u: &[f64]) -> Result<Option<Vec<f64>>, AssemblyError> {
        Ok(None)
    }

    /// The derivative of [`NonlinearProblem::nonlinear_residual`] at u alone, if the problem has it apart from the linear part, as
    /// where the positions of its entries follow the iterate. The tangent is the sum of the two.
    ///
    /// # Errors
    /// If assembly fails.
    fn nonlinear_tangent(&mut self, _u: &[f64]) -> Result<Option<NonlinearTangent<'_>>, AssemblyError> {
        Ok(None)
    }

    /// The quadrature points that are active at u, if the problem has such a notion: where a switch of a piecewise law is
    /// on.
    ///
    /// # Errors
    /// If assembly fails.
    fn active_points(&mut self, _u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        Ok(None)
    }

    /// The fields of the unknowns, one after the other. What is left over is one more field, and all unknowns are one field of one
    /// component if none is named. Each component is judged by its own size.
    fn fields(&self) -> Vec<FieldUnknowns> {
        vec![]
    }

    /// K x, and Σ_j |K_ij x_j| of each row, with a tangent K at u or at an iterate near it: the forces that balance where unknown j
    /// is of the size x_j \[unit of R\]. Rounding of R is a small multiple of those of u.
    ///
    /// # Errors
    /// If assembly fails.
    fn products(&mut self, u: &[f64], x: &[f64]) -> Result<Products, AssemblyError> {
        Ok(self.tangent(u)?.products(x))
    }

    /// The sum of a vector whose parts the processes have, as where its tangent is of its own cells alone.
    ///
    /// # Errors
    /// If another process fails.
    fn summed_up(&mut self, own: Vec<f64>) -> Result<Vec<f64>, AssemblyError> {
        Ok(own)
    }

    /// The size of the terms that are summed in each entry of R(u) \[unit of R\], if the problem knows it. They may be large
    /// where u is zero, as the stresses of a body that was deformed permanently.
    ///
    /// # Errors
    /// If assembly fails.
    fn sizes_of_terms(&mut self, _u: &[f64], _terms: Terms) -> Result<Option<Vec<f64>>, AssemblyError> {
        Ok(None)
    }
}

/// Linear systems are solved to this part of Newton's own target for the field with the smallest one, and of the residual
/// itself, so that the converged residual is at rounding level and not just below the target.
const LINEAR_ACCURACY: f64 = 1e-4;

/// Solves R(u) = 0 on the free unknowns from `start`, with the prescribed values imposed on it. `progress` is called once
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
pub fn newton_eliminating(
    problem: &mut dyn NonlinearProblem,
    elimination: Elimination,
    start: Start,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError> {
    let Start { u, guess } = start;
    let mut iteration = Iteration {
        u,
        fields: Fields::new(&problem.fields(), &elimination),
        history: vec![],
        norms: vec![],
        active: vec![],
        forced: None,
        last_step: None,
        corrections: None,
        corrected_long_step: false,
        last_is_correction: false,
        polished: false,
        zeroings: 0,
        worst: None,
        options,
        progress,
    };
    let found = iteration.run(problem, elimination, guess, solver);
    let Iteration { u, history, worst, .. } = iteration;
    match found {
        Ok(residual) => Ok(NewtonSolution { u, residual, history }),
        Err(why) => Err(NewtonError { why, history, u, worst: worst.map(Box::new), notes: vec![] }),
    }
}

/// The state of the iteration.
struct Iteration<'a> {
    u: Vec<f64>,
    fields: Fields,
    history: Vec<NewtonStep>,
    /// Of each iterate, field by field.
    norms: Vec<Norms>,
    active: Vec<Option<ActivePoints>>,
    forced: Option<Forced>,
    /// The change of all unknowns in the last step, where it is known.
    last_step: Option<Vec<f64>>,
    corrections: Option<Corrections>,
    /// The last step was a correction, which says nothing of the progress of Newton's method.
    last_is_correction: bool,
    /// The correction that a tolerance below rounding asks for was made.
    polished: bool,
    /// The rounding of a long step was corrected.
    corrected_long_step: bool,
    /// Number of times that components of rounding only were made zero.
    zeroings: usize,
    /// The equation that is off by the most of its terms, where one was.
    worst: Option<WorstEquation>,
    options: &'a NewtonOptions,
    progress: &'a mut dyn FnMut(&NewtonStep),
}

/// The residual on all unknowns, and on the free ones.
struct Residuals {
    full: Vec<f64>,
    reduced: Vec<f64>,
}

impl Residuals {
    fn of(full: Vec<f64>, elimination: &Elimination) -> Result<Self, NewtonFailure> {
        let reduced = elimination.reduce(&full)?;
        Ok(Residuals { full, reduced })
    }

    fn at(
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        u: &[f64],
    ) -> Result<Self, NewtonFailure> {
        Self::of(problem.residual(u)?, elimination)
    }
}

/// Length and kind of the step to an iterate.
#[derive(Clone, Copy, Default)]
struct Step {
    length: Option<f64>,
    damping: Option<f64>,
    linear_iterations: Option<usize>,
    condensed_unknowns: Option<usize>,
}

impl Iteration<'_> {
    /// Newton's method: solve K δ = −R, take the step or a part of it, until an iterate is the solution.
    fn run(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        mut elimination: Elimination,
        guess: Option<Vec<f64>>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Vec<f64>, NewtonFailure> {
        let given = self.u.clone();
        elimination.impose(&mut self.u)?;
        let linear_part = share_linear_part(problem, &mut elimination, solver)?;
        let mut residuals = Residuals::at(problem, &elimination, &self.u)?;
        if !norm(&residuals.reduced).is_finite()
            && let Some(found) = self.impose_by_tangent(problem, &mut elimination, &given, solver)?
        {
            residuals = found;
        }
        self.enter(problem, &elimination, &residuals, Step::default(), None)?;
        let mut verdict = self.judge(problem, &elimination, &residuals.reduced, solver)?;
        if let (Some(linear_part), Verdict::GoOn) = (&linear_part, &verdict) {
            residuals = self.condense(problem, &mut elimination, linear_part, guess, residuals, solver)?;
            verdict = self.judge(problem, &elimination, &residuals.reduced, solver)?;
        }
        loop {
            residuals = match verdict {
                Verdict::Solution => return Ok(residuals.full),
                Verdict::Correct(change) => self.correct(problem, &elimination, change)?,
                Verdict::GoOn => {
                    self.step(problem, &mut elimination, linear_part.as_ref(), &residuals, solver)?
                }
            };
            verdict = self.judge(problem, &elimination, &residuals.reduced, solver)?;
        }
    }

    /// One Newton step, whole or shortened.
    fn step(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &mut Elimination,
        linear_part: Option<&Arc<CsrMatrix>>,
        residuals: &Residuals,
        solver: &mut dyn LinearSolver,
    ) -> Result<Residuals, NewtonFailure> {
        self.set_tangent(problem, elimination, linear_part, solver)?;
        let load: Vec<f64> = residuals.reduced.iter().map(|value| -value).collect();
        let solution = solver.solve(&load, self.linear_target())?;
        let mut change = elimination.extend_by_zero(&solution.solution)?;
        let Taken { part, residuals: found } = match self.options.line_search {
            LineSearch::Off => Taken::whole(),
            LineSearch::OnPotential => along_potential(problem, &self.u, &change)?,
            LineSearch::OnResidual => along_residual(self, problem, elimination, &change)?,
        };
        add_scaled(&mut self.u, part, &change);
        let found = match found {
            Some(found) => found,
            None => Residuals::at(problem, elimination, &self.u)?,
        };
        let step = Step {
            length: Some(part * norm(&solution.solution)),
            damping: Some(part),
            linear_iterations: Some(solution.iterations),
            condensed_unknowns: solver.as_condensing().and_then(|solver| solver.condensed_unknowns()),
        };
        let lengths = self.fields.norms(&solution.solution);
        change.iter_mut().for_each(|change| *change *= part);
        self.last_step = Some(change);
        self.last_is_correction = false;
        self.enter(problem, elimination, &found, step, Some(lengths))?;
        Ok(found)
    }

    /// A step by a correction that is known.
    fn correct(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        change: Vec<f64>,
    ) -> Result<Residuals, NewtonFailure> {
        add_scaled(&mut self.u, 1.0, &change);
        let found = Residuals::at(problem, elimination, &self.u)?;
        let reduced: Vec<f64> = elimination.free().iter().map(|unknown| change[*unknown]).collect();
        let step = Step {
            length: Some(norm(&reduced)),
            damping: Some(1.0),
            linear_iterations: Some(0),
            condensed_unknowns: None,
        };
        let lengths = self.fields.norms(&reduced);
        self.last_step = Some(change);
        self.last_is_correction = true;
        self.enter(problem, elimination, &found, step, Some(lengths))?;
        Ok(found)
    }

    /// Hands the tangent at the current iterate to the solver: what differs from the linear part, or the whole.
    fn set_tangent(
        &self,
        problem: &mut dyn NonlinearProblem,
        elimination: &mut Elimination,
        linear_part: Option<&Arc<CsrMatrix>>,
        solver: &mut dyn LinearSolver,
    ) -> Result<(), NewtonFailure> {
        if let (Some(linear_part), Some(solver)) = (linear_part, solver.as_condensing())
            && solver.condenses()
            && self.options.line_search != LineSearch::OnPotential
            && let Some(changes) = nonlinear_changes(problem, elimination, &self.u)?
        {
            let set = solver.set_added(linear_part, changes.additions, &changes.near);
            return Ok(set?);
        }
        let tangent = problem.tangent(&self.u)?;
        if self.options.line_search == LineSearch::OnPotential {
            check_potential(elimination, &tangent.matrix)?;
        }
        let set = match (linear_part, tangent.changed, solver.as_condensing()) {
            (Some(linear_part), Some(changed), Some(solver)) => {
                let entries = elimination.reduce_places(&tangent.matrix, changed);
                let entries = entries?;
                solver.set_changed(linear_part, &entries)
            }
            _ => {
                let reduced = elimination.reduce_matrix(&tangent.matrix);
                let reduced = reduced?;
                drop(tangent);
                solver.set_matrix(reduced)
            }
        };
        Ok(set?)
    }

    /// Enters the current iterate into the history, with its residual and the norms of the whole step that led to it.
    fn enter(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        residuals: &Residuals,
        step: Step,
        lengths: Option<Vec<f64>>,
    ) -> Result<(), NewtonFailure> {
        let active = problem.active_points(&self.u)?;
        let norms = Norms { step: lengths, ..self.norms_at(elimination, &residuals.reduced) };
        self.record(norm(&residuals.reduced), norms, active, step);
        Ok(())
    }

    /// Norms at the current iterate, without those of a step.
    fn norms_at(&self, elimination: &Elimination, reduced_residual: &[f64]) -> Norms {
        let free: Vec<f64> = elimination.free().iter().map(|unknown| self.u[*unknown]).collect();
        let (residual, u) = (self.fields.norms(reduced_residual), self.fields.norms(&free));
        Norms { residual, u, step: None, mark: mark(&free) }
    }

    /// The residual to which a linear system is to be solved.
    fn linear_target(&self) -> f64 {
        let smallest = self.targets().fold(f64::INFINITY, f64::min).max(self.options.absolute_tolerance);
        LINEAR_ACCURACY * self.history.last().map_or(smallest, |last| smallest.min(last.residual))
    }

    /// The last iterate was judged by its condensed residual; this is the whole one.
    fn replace_last_residual(&mut self, elimination: &Elimination, reduced: &[f64]) {
        let first = self.history.first().map_or(0.0, |start| start.residual);
        let (residual, found) = (norm(reduced), self.norms_at(elimination, reduced));
        if let (Some(last), Some(norms)) = (self.history.last_mut(), self.norms.last_mut()) {
            last.residual = residual;
            last.relative_residual = if residual == 0.0 { 0.0 } else { residual / first };
            last.field_residuals.clone_from(&found.residual);
            *norms = Norms { step: norms.step.take(), ..found };
        }
    }

    fn record(&mut self, residual: f64, norms: Norms, active: Option<ActivePoints>, step: Step) {
        let first = self.history.first().map_or(residual, |start| start.residual);
        let before = self.active.last().copied().flatten();
        self.active.push(active);
        let step = NewtonStep {
            iteration: self.history.len(),
            residual,
            relative_residual: if residual == 0.0 { 0.0 } else { residual / first },
            field_residuals: norms.residual.clone(),
            active_points: active.map(|set| set.count),
            active_set_changed: active.zip(before).map(|(now, before)| now != before),
            step: step.length,
            damping: step.damping,
            linear_iterations: step.linear_iterations,
            condensed_unknowns: step.condensed_unknowns,
        };
        self.norms.push(norms);
        (self.progress)(&step);
        self.history.push(step);
    }
}

#[cfg(test)]
mod tests;
