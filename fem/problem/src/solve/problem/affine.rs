//! Affine problems: one assembly, one linear system.

use std::cell::OnceCell;
use std::sync::Arc;
use std::time::Instant;

use super::Problem;
use super::solution::Found;
use crate::assemble::AssemblyError;
use crate::solve::divided::Together;
use crate::solve::linear_system::{check_equations, solve_reduced};
use crate::solve::{
    Elimination, LinearSolution, LinearSolver, NewtonFailure, NewtonStep, NonlinearProblem, SolveError,
    Transpose,
};
use crate::space::Space;

/// The right-hand side of an affine problem.
pub(super) struct AffineLoad {
    /// The prescribed values, with zero elsewhere.
    pub lifted: Vec<f64>,
    /// The residual there, on all unknowns.
    pub residual: Vec<f64>,
    /// The right-hand side of the reduced system.
    pub load: Arc<[f64]>,
}

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// One assembly, one linear system.
    pub(super) fn solve_affine(
        &mut self,
        elimination: &mut Elimination,
        solver: &mut dyn LinearSolver,
    ) -> Result<Found, SolveError> {
        let AffineLoad { lifted: mut u, load, .. } = self.affine_load(elimination)?;
        // Of several processes each has a part of the matrix alone: the solver has to judge there.
        let alone = self.communicator.is_none();
        let tangent = self.tangent(&u)?;
        let found = if alone {
            solve_reduced(&tangent.matrix, &load, elimination, solver, Transpose::No).and_then(|found| {
                check_equations(&tangent.matrix, &load, elimination, solver, &found, Transpose::No)
                    .map(|()| found)
            })
        } else {
            let taken = solver.set_reduced(&tangent.matrix, elimination);
            // The solver has its own by now: twice the matrix would be most of the memory.
            self.assembled = None;
            self.system.pattern = OnceCell::new();
            taken.and_then(|()| solver.solve_with(&load, 0.0, Transpose::No))
        };
        let found = found.map_err(|error| NewtonFailure::LinearSolver(self.named(error, elimination)))?;
        complete(elimination, &found, &mut u)?;
        let residual = if alone { self.residual(&u)? } else { self.residual_by_integrals(&u)? };
        let history = self.affine_history(elimination, &load, &found, &residual)?;
        Ok((u, residual, history))
    }

    pub(super) fn affine_load(&mut self, elimination: &Elimination) -> Result<AffineLoad, SolveError> {
        let lifted = elimination.lifted().map_err(NewtonFailure::Mismatch)?;
        let residual = self.residual(&lifted)?;
        let reduced = elimination.reduce(&residual).map_err(NewtonFailure::Mismatch)?;
        Ok(AffineLoad { lifted, residual, load: reduced.iter().map(|value| -value).collect() })
    }

    /// The start and the solution as the iterates of a history, for the listener of each step, too.
    pub(super) fn affine_history(
        &mut self,
        elimination: &Elimination,
        load: &[f64],
        found: &LinearSolution,
        residual: &[f64],
    ) -> Result<Vec<NewtonStep>, SolveError> {
        let together = Together::new(self.divided.clone(), elimination.free());
        let norm = |reduced: &[f64]| together.norm(reduced, 0..reduced.len());
        let reduced = elimination.reduce(residual).map_err(NewtonFailure::Mismatch)?;
        let (first, last) = (norm(load), norm(&reduced));
        let history = vec![
            NewtonStep {
                field_residuals: self.field_norms(elimination, load, &together),
                ..NewtonStep::start(first)
            },
            NewtonStep {
                iteration: 1,
                relative_residual: if first == 0.0 { 0.0 } else { last / first },
                step: Some(norm(&found.solution)),
                linear_iterations: Some(found.iterations),
                damping: Some(1.0),
                field_residuals: self.field_norms(elimination, &reduced, &together),
                ..NewtonStep::start(last)
            },
        ];
        together.check().map_err(NewtonFailure::Exchange)?;
        if let Some(progress) = &mut self.progress {
            history.iter().for_each(progress);
        }
        Ok(history)
    }

    /// The residual of all processes' integrals, without a matrix.
    fn residual_by_integrals(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let start = Instant::now();
        let own = self.system.whole_residual(u);
        self.seconds += start.elapsed().as_secs_f64();
        self.added_up(own)
    }

    /// The norm of each field's part of a reduced vector.
    fn field_norms(&self, elimination: &Elimination, reduced: &[f64], together: &Together) -> Vec<f64> {
        let place = |end: usize| elimination.free().partition_point(|free| *free < end);
        let mut end = 0;
        let of_space = |space: &Arc<Space<D>>| {
            let start = end;
            end += space.unknowns();
            together.norm(reduced, place(start)..place(end))
        };
        self.system.spaces.iter().map(of_space).collect()
    }
}

/// Writes what was found for the free unknowns into the vector of all, and what follows from it.
pub(super) fn complete(
    elimination: &Elimination,
    found: &LinearSolution,
    u: &mut [f64],
) -> Result<(), SolveError> {
    for (&unknown, &value) in elimination.free().iter().zip(&found.solution) {
        u[unknown] = value;
    }
    Ok(elimination.impose(u).map_err(NewtonFailure::Mismatch)?)
}
