//! Iterates of Newton's method so far: what is reported of them, and what tells progress from a standstill.

use super::convergence::{Fields, Norms};
use super::{ActivePoints, NewtonOptions, NewtonStep};
use crate::solve::elimination::Elimination;

/// Linear systems are solved to this part of Newton's own target for the field with the smallest one, and of the residual
/// itself, so that the converged residual is at rounding level and not just below the target.
const LINEAR_ACCURACY: f64 = 1e-4;

/// The last iterate, and the history up to it.
pub(in crate::solve) struct Iterates<'a> {
    /// The last iterate, all unknowns.
    pub u: Vec<f64>,
    pub fields: Fields,
    pub history: Vec<NewtonStep>,
    /// Of each iterate, field by field.
    pub(super) norms: Vec<Norms>,
    pub(super) active: Vec<Option<ActivePoints>>,
    pub options: &'a NewtonOptions,
    progress: &'a mut dyn FnMut(&NewtonStep),
}

/// Length and kind of the step to an iterate.
#[derive(Clone, Copy, Default)]
pub(in crate::solve) struct Step {
    pub length: Option<f64>,
    pub damping: Option<f64>,
    pub linear_iterations: Option<usize>,
    pub condensed_unknowns: Option<usize>,
    pub held: Option<usize>,
}

impl<'a> Iterates<'a> {
    /// No iterate yet, but the start.
    pub fn new(
        u: Vec<f64>,
        fields: Fields,
        options: &'a NewtonOptions,
        progress: &'a mut dyn FnMut(&NewtonStep),
    ) -> Self {
        Iterates { u, fields, history: vec![], norms: vec![], active: vec![], options, progress }
    }

    /// The norm of the residual at the last iterate, and norms by fields there, without those of a step.
    pub fn norms_at(&self, elimination: &Elimination, reduced_residual: &[f64]) -> (f64, Norms) {
        let free: Vec<f64> = elimination.free().iter().map(|unknown| self.u[*unknown]).collect();
        self.fields.norms_at(reduced_residual, &free)
    }

    /// The residual to which a linear system is to be solved.
    pub fn linear_target(&self) -> f64 {
        let smallest = self.targets().fold(f64::INFINITY, f64::min).max(self.options.absolute_tolerance);
        LINEAR_ACCURACY * self.history.last().map_or(smallest, |last| smallest.min(last.residual))
    }

    /// Whether the last step changed the active set.
    pub fn switched(&self) -> bool {
        self.history.last().is_some_and(|last| last.active_set_changed == Some(true))
    }

    /// Entry of an iterate into the history.
    pub fn record(&mut self, residual: f64, norms: Norms, active: Option<ActivePoints>, step: Step) {
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
            held_unknowns: step.held,
        };
        self.norms.push(norms);
        (self.progress)(&step);
        self.history.push(step);
    }

    /// New residual of the last iterate, which was known in part.
    pub fn replace_last_residual(&mut self, elimination: &Elimination, reduced: &[f64]) {
        let first = self.history.first().map_or(0.0, |start| start.residual);
        let (residual, found) = self.norms_at(elimination, reduced);
        if let (Some(last), Some(norms)) = (self.history.last_mut(), self.norms.last_mut()) {
            last.residual = residual;
            last.relative_residual = if residual == 0.0 { 0.0 } else { residual / first };
            last.field_residuals.clone_from(&found.residual);
            *norms = Norms { step: norms.step.take(), ..found };
        }
    }
}
