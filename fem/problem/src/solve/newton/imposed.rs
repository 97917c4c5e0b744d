//! Prescribed values that move so far, with all else at rest, that nothing can be computed: the rest then follows by the tangent.

use super::{FreeEquations, NewtonFailure, Residuals, Step};
use crate::linear_algebra::vector::{add_scaled, norm};

/// Prescribed values that were imposed with the rest following.
pub(super) struct Imposed {
    pub residuals: Residuals,
    /// Krylov iterations.
    linear_iterations: usize,
}

impl FreeEquations<'_> {
    /// A first step from the start as it was given to the prescribed values, with the rest following by the tangent. None is taken where there is
    /// nothing to impose, or nothing can be computed after it.
    pub(super) fn step_to_prescribed_values(&mut self, given: &[f64]) -> Result<(), NewtonFailure> {
        let imposed = self.iterates.u.clone();
        let Some(found) = self.impose_by_tangent(given)? else { return Ok(()) };
        if !self.may_begin() {
            self.iterates.u = imposed;
            return Ok(());
        }
        self.residuals = found.residuals;
        let free = self.elimination.free().iter();
        let moved: Vec<f64> = free.map(|unknown| self.iterates.u[*unknown] - imposed[*unknown]).collect();
        let step = Step {
            length: Some(norm(&moved)),
            damping: Some(1.0),
            linear_iterations: Some(found.linear_iterations),
            condensed_unknowns: None,
            held: None,
        };
        let lengths = self.iterates.fields.norms(&moved);
        self.enter(step, Some(lengths))
    }

    /// The residual after a step from the start as it was given, u₀, with the jump w of the prescribed values a part of it:
    /// K(u₀) (w + C δ) = −R(u₀) on the free unknowns. A body whose one face is moved by more than a cell has cells turned
    /// inside out next to that face, and no energy, unless the cells behind go along. None where that does not help.
    pub(super) fn impose_by_tangent(&mut self, given: &[f64]) -> Result<Option<Imposed>, NewtonFailure> {
        let imposed = &self.iterates.u;
        let jump: Vec<f64> = imposed.iter().zip(given).map(|(imposed, given)| imposed - given).collect();
        if jump.iter().all(|value| *value == 0.0) || !jump.iter().all(|value| value.is_finite()) {
            return Ok(None);
        }
        let mut forces = self.problem.residual(given)?;
        if !norm(&forces).is_finite() {
            return Ok(None);
        }
        let tangent = self.problem.tangent(given)?;
        let matrix = self.elimination.reduce_matrix(&tangent.matrix)?;
        drop(tangent);
        add_scaled(&mut forces, 1.0, &self.problem.products(given, &jump)?.sums);
        let load: Vec<f64> = self.elimination.reduce(&forces)?.iter().map(|force| -force).collect();
        // A tangent that cannot be solved with is no reason to fail: that nothing can be computed is.
        let Ok(solution) = self.solver.set_matrix(matrix).and_then(|()| self.solver.solve(&load, 0.0)) else {
            return Ok(None);
        };
        let change = self.elimination.extend_by_zero(&solution.solution)?;
        let moved: Vec<f64> = imposed.iter().zip(&change).map(|(imposed, change)| imposed + change).collect();
        let found = Residuals::at(self.problem, &self.elimination, &moved)?;
        if !norm(&found.reduced).is_finite() {
            return Ok(None);
        }
        self.iterates.u = moved;
        Ok(Some(Imposed { residuals: found, linear_iterations: solution.iterations }))
    }
}
