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
    Elimination, LinearSolver, NewtonFailure, NewtonStep, NonlinearProblem, SolveError, Transpose,
};
use crate::space::Space;

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// One assembly, one linear system.
    pub(super) fn solve_affine(
        &mut self,
        elimination: &mut Elimination,
        solver: &mut dyn LinearSolver,
    ) -> Result<Found, SolveError> {
        let mut u = elimination.lifted().map_err(NewtonFailure::Mismatch)?;
        let residual = self.residual(&u)?;
        let load = elimination.reduce(&residual).map_err(NewtonFailure::Mismatch)?;
        let load: Vec<f64> = load.iter().map(|value| -value).collect();
        let together = Together::new(self.divided.clone(), elimination.free());
        let norm = |reduced: &[f64]| together.norm(reduced, 0..reduced.len());
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
        for (&unknown, &value) in elimination.free().iter().zip(&found.solution) {
            u[unknown] = value;
        }
        elimination.impose(&mut u).map_err(NewtonFailure::Mismatch)?;
        let residual = if alone { self.residual(&u)? } else { self.residual_by_integrals(&u)? };
        let reduced = elimination.reduce(&residual).map_err(NewtonFailure::Mismatch)?;
        let (first, last) = (norm(&load), norm(&reduced));
        let history = vec![
            NewtonStep {
                field_residuals: self.field_norms(elimination, &load, &together),
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
        Ok((u, residual, history))
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
