//! Prescribed values that move so far, with all else at rest, that nothing can be computed: the rest then follows by the tangent.

use super::{Iteration, NewtonFailure, NonlinearProblem, Residuals};
use crate::linear_algebra::vector::{add_scaled, norm};
use crate::solve::elimination::Elimination;
use crate::solve::linear_solver::LinearSolver;

impl Iteration<'_> {
    /// The residual after a step from the start as it was given, u₀, with the jump w of the prescribed values a part of it:
    /// K(u₀) (w + C δ) = −R(u₀) on the free unknowns. A body whose one face is moved by more than a cell has cells turned
    /// inside out next to that face, and no energy, unless the cells behind go along. None where that does not help.
    pub(super) fn impose_by_tangent(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &mut Elimination,
        given: &[f64],
        solver: &mut dyn LinearSolver,
    ) -> Result<Option<Residuals>, NewtonFailure> {
        let jump: Vec<f64> = self.u.iter().zip(given).map(|(imposed, given)| imposed - given).collect();
        if jump.iter().all(|value| *value == 0.0) || !jump.iter().all(|value| value.is_finite()) {
            return Ok(None);
        }
        let mut forces = problem.residual(given)?;
        if !norm(&forces).is_finite() {
            return Ok(None);
        }
        let tangent = problem.tangent(given)?;
        let change = tangent.matrix.multiply(&jump)?;
        let matrix = elimination.reduce_matrix(&tangent.matrix)?;
        drop(tangent);
        add_scaled(&mut forces, 1.0, &problem.summed_up(change)?);
        let load: Vec<f64> = elimination.reduce(&forces)?.iter().map(|force| -force).collect();
        // A tangent that cannot be solved with is no reason to fail: that nothing can be computed is.
        let Ok(change) = solver.set_matrix(matrix).and_then(|()| solver.solve(&load, 0.0)) else {
            return Ok(None);
        };
        let change = elimination.extend_by_zero(&change.solution)?;
        let moved: Vec<f64> = self.u.iter().zip(&change).map(|(imposed, change)| imposed + change).collect();
        let found = Residuals::at(problem, elimination, &moved)?;
        if !norm(&found.reduced).is_finite() {
            return Ok(None);
        }
        self.u = moved;
        Ok(Some(found))
    }
}
