//! Affine problems: one assembly, one linear system.

use std::sync::Arc;

use super::Problem;
use super::solution::Found;
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
        let found = solve_reduced(&tangent.matrix, &load, elimination, solver, Transpose::No);
        let found = match found {
            Ok(found) if alone => {
                check_equations(&tangent.matrix, &load, elimination, solver, &found, Transpose::No)
                    .map(|()| found)
            }
            found => found,
        };
        let found = found.map_err(|error| NewtonFailure::LinearSolver(self.named(error, elimination)))?;
        for (&unknown, &value) in elimination.free().iter().zip(&found.solution) {
            u[unknown] = value;
        }
        elimination.impose(&mut u).map_err(NewtonFailure::Mismatch)?;
        let residual = self.residual(&u)?;
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
