//! Prescribed values that move so far, with all else at rest, that nothing can be computed or a quantity is no longer positive: the rest then follows
//! by the tangent, part by part of the way if need be.

use super::free_equations::hand_over;
use super::{FreeEquations, NewtonFailure, Step};
use crate::linear_algebra::vector::{add_scaled, is_finite};

/// A change of all unknowns to the prescribed values, with the rest following.
struct Jump {
    values: Vec<f64>,
    /// Krylov iterations.
    linear_iterations: usize,
}

impl FreeEquations<'_> {
    /// A first step from the start as it was given to the prescribed values, with the rest following by the tangent. None is taken where there is
    /// nothing to impose, or nothing can be computed after it.
    pub(super) fn step_to_prescribed_values(&mut self, given: &[f64]) -> Result<(), NewtonFailure> {
        let imposed = self.iterates.u.clone();
        let Some(jump) = self.jump_from(given)? else { return Ok(()) };
        self.go_along(given, &jump, 1.0)?;
        let found = self.residuals_at_last()?;
        if !self.iterates.fields.norm(&found.reduced).is_finite() || !self.may_begin() {
            self.iterates.u = imposed;
            return Ok(());
        }
        self.residuals = found;
        let free = self.elimination.free().iter();
        let moved: Vec<f64> = free.map(|unknown| self.iterates.u[*unknown] - imposed[*unknown]).collect();
        self.enter_jump(&jump, 1.0, &moved)
    }

    /// Steps from the start as it was given, each with all that is left to the prescribed values in it, and shortened so that what is kept
    /// positive stays so: a gap that the prescribed values close, or a body that they crush. The history begins with the first one. Whether they
    /// led to the prescribed values; if not, the last iterate is as it was.
    pub(super) fn impose_in_parts(&mut self, given: &[f64]) -> Result<bool, NewtonFailure> {
        let imposed = std::mem::replace(&mut self.iterates.u, given.to_vec());
        for number in 0..self.iterates.options.max_iterations.max(1) {
            let from = self.iterates.u.clone();
            let Some(jump) = self.jump_from(&from)? else { break };
            let part = match self.problem.largest_step(&from, &jump.values) {
                Ok(part) => part,
                // The whole jump may lead out of a start that is not feasible itself.
                Err(_) if number == 0 => 1.0,
                Err(_) => break,
            };
            self.go_along(&from, &jump, part)?;
            let found = self.residuals_at_last()?;
            if !self.iterates.fields.norm(&found.reduced).is_finite() || part >= 1.0 && !self.may_begin() {
                break;
            }
            self.residuals = found;
            if number == 0 {
                let damping = (part < 1.0).then_some(part);
                self.enter(Step { damping, ..Step::default() }, None)?;
            } else {
                let free = self.elimination.free().iter();
                let moved: Vec<f64> = free.map(|unknown| jump.values[*unknown]).collect();
                self.enter_jump(&jump, part, &moved)?;
            }
            if part >= 1.0 {
                return Ok(true);
            }
        }
        self.iterates.u = imposed;
        Ok(false)
    }

    /// Enters the iterate at a part of a jump, whose change of the free unknowns is known.
    fn enter_jump(&mut self, jump: &Jump, part: f64, moved: &[f64]) -> Result<(), NewtonFailure> {
        let (length, lengths) = self.iterates.fields.norm_and_norms(moved);
        let step = Step {
            length: Some(part * length),
            damping: Some(part),
            linear_iterations: Some(jump.linear_iterations),
            condensed_unknowns: None,
            held: None,
        };
        self.enter(step, Some(lengths))
    }

    /// Moves the last iterate to a part of a jump.
    fn go_along(&mut self, from: &[f64], jump: &Jump, part: f64) -> Result<(), NewtonFailure> {
        let u = &mut self.iterates.u;
        u.copy_from_slice(from);
        add_scaled(u, part, &jump.values);
        if part >= 1.0 {
            self.elimination.impose(u)?;
        }
        Ok(())
    }

    /// A change from u with the jump w to the prescribed values in it: K(u) (w + C δ) = −R(u) on the free unknowns. A body whose one face is moved
    /// by more than a cell has cells turned inside out next to that face, and no energy, unless the cells behind go along. None where there
    /// is nothing to impose, or no such change.
    fn jump_from(&mut self, u: &[f64]) -> Result<Option<Jump>, NewtonFailure> {
        let mut imposed = u.to_vec();
        self.elimination.impose(&mut imposed)?;
        let mut values: Vec<f64> = imposed.iter().zip(u).map(|(imposed, u)| imposed - u).collect();
        let together = self.iterates.fields.together.clone();
        let moves = values.iter().any(|value| *value != 0.0);
        // One exchange for both questions.
        let wrong =
            together.largest_of_each([moves, !is_finite(&values)].map(|is| f64::from(u8::from(is))).to_vec());
        if wrong[0] == 0.0 || wrong[1] != 0.0 {
            return Ok(None);
        }
        let mut forces = self.problem.residual(u)?;
        if !together.all(is_finite(&forces)) {
            return Ok(None);
        }
        let tangent = self.problem.tangent(u)?;
        let taken = hand_over(self.solver, &mut self.elimination, &tangent.matrix);
        add_scaled(&mut forces, 1.0, &self.problem.products(u, &values)?.sums);
        let load: Vec<f64> = self.elimination.reduce(&forces)?.iter().map(|force| -force).collect();
        // A tangent that cannot be solved with is no reason to fail: that nothing can be computed is.
        let Ok(solution) = taken.and_then(|()| self.solver.solve(&load, 0.0)) else {
            return Ok(None);
        };
        add_scaled(&mut values, 1.0, &self.elimination.extend_by_zero(&solution.solution)?);
        Ok(Some(Jump { values, linear_iterations: solution.iterations }))
    }
}
