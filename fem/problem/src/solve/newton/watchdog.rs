//! Whole steps that may raise the residual's norm for a while (Chamberlain, Powell, Lemaréchal and Pedersen 1982).

use super::line_search::{Taken, Way};
use super::{FreeEquations, NewtonFailure};

/// Number of whole steps after the first one that raised the norm. One of them has to bring it below the value before that one; the last is taken only if it does.
const PATIENCE: usize = 3;

/// The state of the watchdog.
#[derive(Default)]
pub(super) enum Watchdog {
    /// A whole step may raise the norm.
    #[default]
    Ready,
    /// One did, from this place.
    Watching(Reference),
    /// The steps after it did not lower the norm enough. It has to fall with each step now, until a whole one lowers it.
    Resting,
}

impl Watchdog {
    pub fn is_watching(&self) -> bool {
        matches!(self, Watchdog::Watching(_))
    }
}

/// The place before a step that raised the residual's norm.
pub(super) struct Reference {
    u: Vec<f64>,
    step: Vec<f64>,
    before: f64,
    scales: Vec<f64>,
    /// Whole steps from there.
    steps: usize,
}

impl Reference {
    fn way(&self) -> Way<'_> {
        Way { u: &self.u, step: &self.step, before: self.before, scales: &self.scales }
    }
}

impl FreeEquations<'_> {
    /// The whole step where the watchdog allows it; else the part of this step, or of the one from its reference, with which the residual's norm falls.
    pub(super) fn under_watch(&mut self, step: &[f64]) -> Result<Taken, NewtonFailure> {
        match std::mem::take(&mut self.watchdog) {
            Watchdog::Watching(reference) => self.go_on_or_back(reference, step),
            state => {
                let scales = self.scales(step)?;
                let before = self.iterates.merit(&self.residuals.reduced, &scales);
                let u = self.iterates.u.clone();
                let way = Way { u: &u, step, before, scales: &scales };
                let (residuals, merit) = self.at_part(&way, 1.0)?;
                let falls = merit <= way.allowed(1.0);
                if falls || (merit.is_finite() && matches!(state, Watchdog::Ready)) {
                    if !falls {
                        let step = step.to_vec();
                        self.watchdog = Watchdog::Watching(Reference { u, step, before, scales, steps: 1 });
                    }
                    return Ok(Taken { part: 1.0, residuals: Some(residuals), elsewhere: None });
                }
                self.watchdog = state;
                self.falling_part(&way, 1)
            }
        }
    }

    /// Another whole step from a reference, or the way back to it.
    fn go_on_or_back(&mut self, mut reference: Reference, step: &[f64]) -> Result<Taken, NewtonFailure> {
        let u = self.iterates.u.clone();
        let (residuals, merit) = self.at_part(&Way { u: &u, step, ..reference.way() }, 1.0)?;
        let falls = merit <= reference.way().allowed(1.0);
        reference.steps += 1;
        if falls || (merit.is_finite() && reference.steps <= PATIENCE) {
            if !falls {
                self.watchdog = Watchdog::Watching(reference);
            }
            return Ok(Taken { part: 1.0, residuals: Some(residuals), elsewhere: None });
        }
        self.watchdog = Watchdog::Resting;
        let taken = self.falling_part(&reference.way(), 1)?;
        let Reference { u, step, .. } = reference;
        Ok(Taken { elsewhere: Some((u, step)), ..taken })
    }
}
