//! Affine problems: one assembly, one linear system.

use super::Problem;
use super::solution::Found;
use crate::linear_algebra::vector::norm;
use crate::solve::linear_system::{check_equations, solve_reduced};
use crate::solve::{
    Elimination, LinearSolver, NewtonFailure, NewtonStep, NonlinearProblem, SolveError, Transpose,
};

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
        let history = vec![
            NewtonStep {
                field_residuals: self.field_norms(elimination, &load),
                ..NewtonStep::start(norm(&load))
            },
            NewtonStep {
                iteration: 1,
                relative_residual: if norm(&load) == 0.0 { 0.0 } else { norm(&reduced) / norm(&load) },
                step: Some(norm(&found.solution)),
                linear_iterations: Some(found.iterations),
                damping: Some(1.0),
                field_residuals: self.field_norms(elimination, &reduced),
                ..NewtonStep::start(norm(&reduced))
            },
        ];
        if let Some(progress) = &mut self.progress {
            history.iter().for_each(progress);
        }
        Ok((u, residual, history))
    }

    /// The norm of each field's part of a reduced vector.
    fn field_norms(&self, elimination: &Elimination, reduced: &[f64]) -> Vec<f64> {
        let mut squares = [0.0; N];
        let ends = self.system.spaces.iter().scan(0, |end, space| {
            *end += space.unknowns();
            Some(*end)
        });
        let ends: Vec<usize> = ends.collect();
        for (unknown, value) in elimination.free().iter().zip(reduced) {
            if let Some(field) = ends.iter().position(|end| unknown < end) {
                squares[field] += value * value;
            }
        }
        squares.iter().map(|square| square.sqrt()).collect()
    }
}
