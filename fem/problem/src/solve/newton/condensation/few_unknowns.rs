//! Small nonlinear problem on the condensed unknowns c: S x_c + N_c(x) = L_c y_c, with the iterates of all unknowns, computed only where
//! the nonlinearity reads them.

use super::changes::{Changes, Reduced, changes};
use crate::linear_algebra::vector::{add_scaled, norm};
use crate::linear_algebra::{Entry, LinearAlgebraError};
use crate::solve::condensed_solver::{CondensedSolver, CondensedSystem};
use crate::solve::elimination::Elimination;
use crate::solve::linear_solver::SolverError;
use crate::solve::newton::convergence::{Norms, mark};
use crate::solve::newton::iterates::{Iterates, Step};
use crate::solve::newton::{Change, Equations, NewtonFailure, Origin, PartlyLinear, Verdict};

/// The equations R(u₀ + x) = K x + N(u₀ + x) − b = 0 on the unknowns that N touches, which may become more on the way. The other
/// rows hold for every x_c.
pub(super) struct FewUnknowns<'c, 'a> {
    problem: &'c mut dyn PartlyLinear,
    elimination: &'c mut Elimination,
    solver: &'c mut CondensedSolver,
    linear_part: &'c Reduced,
    iterates: &'c mut Iterates<'a>,
    /// u₀ on the free unknowns.
    start: Vec<f64>,
    b: Vec<f64>,
    /// The increment since u₀, up to date in the watched unknowns.
    x: Vec<f64>,
    /// N at the last iterate, on the free unknowns.
    nonlinear: Vec<f64>,
    /// The free unknowns that N reads, from the first tangent on.
    watched: Vec<u32>,
    /// The tangent at the last iterate less the linear part.
    additions: Vec<Entry>,
    condensed: Option<Condensed>,
}

/// The condensed system of a factor, and the last iterate in it.
struct Condensed {
    system: CondensedSystem,
    x_c: Vec<f64>,
}

impl<'c, 'a> FewUnknowns<'c, 'a> {
    /// The equations at the first iterate, whose residual on all unknowns is given.
    ///
    /// # Errors
    /// If assembly or the linear solver fails.
    pub fn new(
        problem: &'c mut dyn PartlyLinear,
        elimination: &'c mut Elimination,
        solver: &'c mut CondensedSolver,
        (linear_part, residual): (&'c Reduced, &[f64]),
        iterates: &'c mut Iterates<'a>,
    ) -> Result<Self, NewtonFailure> {
        let nonlinear = elimination.reduce(&problem.nonlinear_residual(&iterates.u)?)?;
        let mut b = elimination.reduce(residual)?;
        b.iter_mut().zip(&nonlinear).for_each(|(b, n)| *b = n - *b);
        let start = elimination.free().iter().map(|unknown| iterates.u[*unknown]).collect();
        Ok(FewUnknowns {
            problem,
            elimination,
            solver,
            linear_part,
            iterates,
            start,
            x: vec![0.0; b.len()],
            b,
            nonlinear,
            watched: vec![],
            additions: vec![],
            condensed: None,
        })
    }

    /// Whether the iterates have come to an end. What ends the iteration is judged by the whole residual.
    fn has_ended(&self) -> bool {
        self.iterates.history.last().is_some_and(|last| !last.residual.is_finite())
            || self.iterates.has_dropped_to(self.iterates.options.relative_tolerance)
            || self.iterates.check_progress().is_err()
    }

    /// Makes a condensed system on which a tangent K + `additions` and N live, where the last one does not serve. False: it is not
    /// worth it, or there is none.
    fn cover(&mut self, additions: &[Entry], mut near: Vec<u32>) -> Result<bool, NewtonFailure> {
        let is_touched = |i: &u32| self.nonlinear[*i as usize] != 0.0;
        let touched: Vec<u32> = (0..self.x.len() as u32).filter(is_touched).collect();
        let known = self.condensed.as_ref();
        if known.is_some_and(|known| self.solver.covers(&known.system, additions, &touched)) {
            return Ok(true);
        }
        // The iterate is completed with the factor that it belongs to.
        if self.complete()? {
            let full = self.elimination.free().iter().map(|unknown| self.iterates.u[*unknown]);
            self.x = full.zip(&self.start).map(|(u, start)| u - start).collect();
        }
        near.extend_from_slice(&touched);
        // What may be touched soon is too much where the dense system would cost more than it saves.
        let covered = self.solver.cover(additions, &near)?
            || (near.len() > touched.len() && self.solver.cover(additions, &touched)?);
        if covered {
            let system = self.solver.condensed_system(&self.b, &self.watched)?;
            let x_c = system.condensed(&self.x);
            self.condensed = Some(Condensed { system, x_c });
        }
        Ok(covered)
    }

    /// u = u₀ + x on all free unknowns, by the factor of the condensed system. False: there was none, and u is complete.
    ///
    /// # Errors
    /// If the linear solver fails, or its solution is not finite.
    pub fn complete(&mut self) -> Result<bool, NewtonFailure> {
        let Some(Condensed { system, x_c }) = self.condensed.take() else { return Ok(false) };
        let x = self.solver.complete(system, &x_c)?;
        if let Some(unknown) = x.iter().position(|value| !value.is_finite()) {
            return Err(SolverError::from(LinearAlgebraError::Singular { unknown, ratio: 0.0 }).into());
        }
        for ((unknown, start), x) in self.elimination.free().iter().zip(&self.start).zip(&x) {
            self.iterates.u[*unknown] = start + x;
        }
        self.elimination.impose_relations(&mut self.iterates.u);
        Ok(true)
    }
}

impl Equations for FewUnknowns<'_, '_> {
    fn judge(&mut self) -> Result<Verdict, NewtonFailure> {
        if self.has_ended() {
            return Ok(Verdict::Solution);
        }
        let Changes { additions, watched, near } =
            changes(self.problem, self.elimination, self.linear_part, &self.iterates.u)?;
        if self.condensed.is_none() {
            self.watched = watched;
        }
        let is_covered = self.cover(&additions, near)?;
        self.additions = additions;
        Ok(if is_covered { Verdict::GoOn } else { Verdict::Solution })
    }

    fn newton_change(&mut self) -> Result<Change, NewtonFailure> {
        let Some(Condensed { system, x_c }) = &self.condensed else {
            return Err(SolverError::NoMatrix.into());
        };
        let (residual, additions) =
            (system.residual(x_c, &self.nonlinear), std::mem::take(&mut self.additions));
        let values = self.solver.condensed_step(&self.linear_part.matrix, additions, &residual)?;
        let condensed_unknowns = Some(values.len());
        Ok(Change { values, origin: Origin::Tangent { linear_iterations: 0, condensed_unknowns } })
    }

    fn take(&mut self, change: Change) -> Result<(), NewtonFailure> {
        let Some(Condensed { system, x_c }) = &mut self.condensed else {
            return Err(SolverError::NoMatrix.into());
        };
        let (Iterates { u, fields, .. }, free) = (&mut *self.iterates, self.elimination.free());
        let (start, x) = (&self.start, &mut self.x);
        add_scaled(x_c, 1.0, &change.values);
        system.update(x_c, x)?;
        let lengths = fields.norms_over(&self.watched, |i| start[i] + x[i] - u[free[i]]);
        for &i in &self.watched {
            u[free[i as usize]] = start[i as usize] + x[i as usize];
        }
        self.elimination.impose_relations(u);
        self.nonlinear = self.elimination.reduce(&self.problem.nonlinear_residual(u)?)?;
        // Rows outside of c hold; N may have got beyond c.
        let mut residual = self.nonlinear.clone();
        let reduced_residual = system.residual(x_c, &self.nonlinear);
        let condensed = system.unknowns().iter().zip(&reduced_residual);
        condensed.for_each(|(place, value)| residual[*place as usize] = *value);
        let watched: Vec<f64> = self.watched.iter().map(|i| start[*i as usize] + x[*i as usize]).collect();
        let norms = Norms {
            residual: fields.norms(&residual),
            u: fields.norms_over(&self.watched, |i| start[i] + x[i]),
            step: Some(lengths),
            mark: mark(&watched),
        };
        let step = Step {
            length: norms.step.as_deref().map(norm),
            damping: Some(1.0),
            linear_iterations: Some(0),
            held: None,
            condensed_unknowns: Some(x_c.len()),
        };
        let active = self.problem.active_points(u)?;
        self.iterates.record(norm(&residual), norms, active, step);
        Ok(())
    }
}
