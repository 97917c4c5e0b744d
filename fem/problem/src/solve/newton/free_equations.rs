//! Equations on all free unknowns: residual Cᵀ R, tangent Cᵀ K C, and steps that a line search may shorten.

use super::bounded::{ActiveSet, Moved};
use super::judgement::{LastChange, Refinement};
use super::line_search::{Forced, Taken, check_potential};
use super::watchdog::Watchdog;
use super::{
    Change, Equations, Iterates, NewtonFailure, NonlinearProblem, Norms, Origin, PrescribedValues, Products,
    Step, Verdict, WorstEquation,
};
use crate::linear_algebra::BlockMatrix;
use crate::linear_algebra::vector::add_scaled;
use crate::solve::elimination::Elimination;
use crate::solve::linear_solver::{LinearSolver, SolverError};

/// The residual on all unknowns, and on the free ones.
#[derive(Default)]
pub(in crate::solve) struct Residuals {
    pub full: Vec<f64>,
    pub reduced: Vec<f64>,
}

impl Residuals {
    pub fn at(
        problem: &mut dyn NonlinearProblem,
        elimination: &Elimination,
        u: &[f64],
    ) -> Result<Self, NewtonFailure> {
        let full = problem.residual(u)?;
        let reduced = elimination.reduce(&full)?;
        Ok(Residuals { full, reduced })
    }
}

/// A nonlinear problem on its free unknowns, with the solver of its linear systems and the state of the iteration.
pub(in crate::solve) struct FreeEquations<'a> {
    pub problem: &'a mut dyn NonlinearProblem,
    pub elimination: Elimination,
    pub solver: &'a mut dyn LinearSolver,
    pub iterates: Iterates<'a>,
    /// At the last iterate.
    pub residuals: Residuals,
    /// The last change of all unknowns, where it is known.
    pub(super) last_change: Option<LastChange>,
    pub(super) refinement: Refinement,
    /// Whether products need another tangent than the last one. It is assembled when a judgement asks for one.
    pub(super) products_are_old: bool,
    /// Allowed residuals of the free rows, of the last iterate whose terms were summed.
    pub(super) allowed_before: Vec<f64>,
    /// The equation that is off by the most of its terms, where one was.
    pub(super) worst: Option<WorstEquation>,
    pub(super) forced: Option<Forced>,
    pub(super) watchdog: Watchdog,
    /// The unknowns that are held at bounds, where there are bounds.
    pub(in crate::solve) bounds: Option<ActiveSet>,
}

impl<'a> FreeEquations<'a> {
    /// Equations without an iterate yet, but the start.
    pub(super) fn new(
        problem: &'a mut dyn NonlinearProblem,
        elimination: Elimination,
        solver: &'a mut dyn LinearSolver,
        iterates: Iterates<'a>,
    ) -> Self {
        FreeEquations {
            problem,
            elimination,
            solver,
            iterates,
            residuals: Residuals::default(),
            last_change: None,
            refinement: Refinement::default(),
            products_are_old: false,
            allowed_before: vec![],
            worst: None,
            forced: None,
            watchdog: Watchdog::default(),
            bounds: None,
        }
    }

    /// The iterates, R on all unknowns at the last one, and the equation that held worst.
    pub(super) fn into_parts(self) -> (Iterates<'a>, Vec<f64>, Option<WorstEquation>) {
        (self.iterates, self.residuals.full, self.worst)
    }

    /// Start with the prescribed values imposed on it; the one that was given is returned.
    ///
    /// # Errors
    /// Constraints that do not fit the start.
    pub fn impose(&mut self) -> Result<Vec<f64>, NewtonFailure> {
        let given = self.iterates.u.clone();
        self.elimination.impose(&mut self.iterates.u)?;
        if let Some(bounds) = &self.bounds {
            bounds.project(&mut self.iterates.u);
            self.elimination.impose_relations(&mut self.iterates.u);
        }
        Ok(given)
    }

    /// Entry of the first iterate, with the prescribed values imposed on it as it was given.
    ///
    /// # Errors
    /// If assembly fails.
    pub fn enter_start(&mut self, given: &[f64]) -> Result<(), NewtonFailure> {
        self.residuals = self.residuals_at_last()?;
        let is_finite = self.iterates.fields.norm(&self.residuals.reduced).is_finite();
        if !is_finite || !self.may_begin() {
            if self.impose_in_parts(given)? {
                return Ok(());
            }
            // A quantity that is not positive says more than forces that are no numbers.
            self.check_feasible(given)?;
        }
        self.enter(Step::default(), None)?;
        match self.iterates.options.prescribed_values {
            PrescribedValues::AtOnce => Ok(()),
            PrescribedValues::ByTangent => self.step_to_prescribed_values(given),
        }
    }

    /// Whether what is kept positive is so at the last iterate.
    pub(super) fn may_begin(&mut self) -> bool {
        let at_rest = vec![0.0; self.iterates.u.len()];
        self.problem.largest_step(&self.iterates.u, &at_rest).is_ok()
    }

    /// An error where what is kept positive is not so at the last iterate: of the start as it was given, or of the prescribed values.
    fn check_feasible(&mut self, given: &[f64]) -> Result<(), NewtonFailure> {
        let at_rest = vec![0.0; given.len()];
        let Err(imposed) = self.problem.largest_step(&self.iterates.u, &at_rest) else { return Ok(()) };
        self.problem.largest_step(given, &at_rest).map_err(NewtonFailure::InfeasibleStart)?;
        Err(NewtonFailure::InfeasibleConditions(imposed))
    }

    /// The residual at the last iterate.
    ///
    /// # Errors
    /// If assembly fails.
    pub fn residuals_at_last(&mut self) -> Result<Residuals, NewtonFailure> {
        Residuals::at(self.problem, &self.elimination, &self.iterates.u)
    }

    /// Enters the current iterate into the history, with its residual and the norms of the whole step that led to it.
    pub(super) fn enter(&mut self, step: Step, lengths: Option<Vec<f64>>) -> Result<(), NewtonFailure> {
        let active = self.problem.active_points(&self.iterates.u)?;
        self.update_held()?;
        let held = self.bounds.as_ref().map(ActiveSet::count);
        let (size, norms) = self.iterates.norms_at(&self.elimination, &self.residuals.reduced);
        self.iterates.record(size, Norms { step: lengths, ..norms }, active, Step { held, ..step });
        Ok(())
    }

    /// Tangent at the last iterate, handed to the solver.
    ///
    /// # Errors
    /// If assembly or the linear solver fails.
    pub fn set_tangent(&mut self) -> Result<(), NewtonFailure> {
        self.products_are_old = false;
        let tangent = self.problem.tangent(&self.iterates.u)?;
        check_potential(self.iterates.options.line_search, &mut self.elimination, &tangent.matrix)?;
        if self.bounds.is_none() {
            return Ok(hand_over(self.solver, &mut self.elimination, &tangent.matrix)?);
        }
        let mut reduced = self.elimination.reduce_matrix(&tangent.matrix)?;
        drop(tangent);
        if let Some(bounds) = &mut self.bounds {
            bounds.keep_pattern(&reduced);
            bounds.mask_matrix(&mut reduced);
        }
        Ok(self.solver.set_matrix(reduced)?)
    }

    /// K x, and Σ_j |K_ij x_j| of each row, at the last iterate.
    ///
    /// # Errors
    /// If assembly fails.
    pub(super) fn products(&mut self, x: &[f64]) -> Result<Products, NewtonFailure> {
        if std::mem::take(&mut self.products_are_old) {
            self.problem.tangent(&self.iterates.u)?;
        }
        Ok(self.problem.products(&self.iterates.u, x)?)
    }

    /// −K⁻¹R with the tangent that the solver has.
    ///
    /// # Errors
    /// If the linear solver fails.
    pub fn change_by_solver(&mut self) -> Result<Change, NewtonFailure> {
        let mut load: Vec<f64> = self.residuals.reduced.iter().map(|value| -value).collect();
        let lead = self.lead_to_bounds()?;
        if let Some(lead) = &lead {
            add_scaled(&mut load, -1.0, &lead.forces);
        }
        let mut found = self.solver.solve(&load, self.iterates.linear_target())?;
        if let Some(lead) = &lead {
            add_scaled(&mut found.solution, 1.0, &lead.reduced);
        }
        let values = self.elimination.extend_by_zero(&found.solution)?;
        let condensed_unknowns = self.solver.as_condensed().and_then(|solver| solver.condensed_unknowns());
        Ok(Change {
            values,
            origin: Origin::Tangent { linear_iterations: found.iterations, condensed_unknowns },
        })
    }
}

/// Hands a solver the free part of a tangent: without a copy of it, where the solver takes its rows one by one.
pub(super) fn hand_over(
    solver: &mut dyn LinearSolver,
    elimination: &mut Elimination,
    tangent: &BlockMatrix,
) -> Result<(), SolverError> {
    match solver.as_condensed() {
        Some(_) => solver.set_matrix(elimination.reduce_matrix(tangent)?),
        None => solver.set_reduced(tangent, elimination),
    }
}

impl FreeEquations<'_> {
    /// Moves to the next iterate along a change of all unknowns, or along the step from an earlier iterate, which takes the place of the change then.
    /// The part that was taken.
    fn move_along(&mut self, values: &mut Vec<f64>, origin: Origin) -> Result<(f64, Begin), NewtonFailure> {
        if self.bounds.is_some() {
            let Moved { u, residuals, part } = self.move_between_bounds(values, origin)?;
            (self.iterates.u, self.residuals) = (u, residuals);
            return Ok((part, Begin::LastIterate));
        }
        let (Taken { part, residuals, elsewhere }, mut limit) = match origin {
            Origin::Tangent { .. } => self.limited_step(values)?,
            Origin::Judgement => (Taken::whole(), 1.0),
        };
        let mut begin = Begin::LastIterate;
        if let Some((u, step)) = elsewhere {
            // That step was limited when it was taken first.
            (self.iterates.u, *values, limit, begin) = (u, step, 1.0, Begin::EarlierIterate);
        }
        add_scaled(&mut self.iterates.u, limit * part, values);
        self.residuals = match residuals {
            Some(found) => found,
            None => self.residuals_at_last()?,
        };
        Ok((limit * part, begin))
    }
}

/// The place where a step begins.
#[derive(Clone, Copy, PartialEq)]
enum Begin {
    LastIterate,
    EarlierIterate,
}

impl Equations for FreeEquations<'_> {
    fn judge(&mut self) -> Result<Verdict, NewtonFailure> {
        match self.judge_bounds()? {
            Some(verdict) => Ok(verdict),
            None => self.judge_last(),
        }
    }

    fn newton_change(&mut self) -> Result<Change, NewtonFailure> {
        self.peel();
        loop {
            self.set_tangent()?;
            let change = self.change_by_solver()?;
            if !self.hold_hindering(&change) {
                return Ok(change);
            }
        }
    }

    fn take(&mut self, change: Change) -> Result<(), NewtonFailure> {
        let Change { mut values, origin } = change;
        self.products_are_old = false;
        if let Origin::Tangent { .. } = origin {
            let factor = self.problem.factor_of_step(&self.iterates.u, &values);
            values.iter_mut().for_each(|value| *value *= factor);
        }
        let (linear_iterations, condensed_unknowns) = match origin {
            Origin::Tangent { linear_iterations, condensed_unknowns } => {
                (linear_iterations, condensed_unknowns)
            }
            Origin::Judgement => (0, None),
        };
        let (part, begin) = self.move_along(&mut values, origin)?;
        let reduced: Vec<f64> = self.elimination.free().iter().map(|unknown| values[*unknown]).collect();
        let (length, lengths) = self.iterates.fields.norm_and_norms(&reduced);
        let step = Step {
            length: Some(part * length),
            damping: Some(part),
            linear_iterations: Some(linear_iterations),
            condensed_unknowns,
            held: None,
        };
        values.iter_mut().for_each(|value| *value *= part);
        self.last_change = (begin == Begin::LastIterate).then_some(LastChange { values, origin });
        self.enter(step, Some(lengths))
    }
}
