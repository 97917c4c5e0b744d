//! The one-step-θ method for first order in time: Euler's implicit method, and Crank and Nicolson's.

use super::scheme::{Combination, Formulas, Scheme, SchemeError, within};

/// The rate (u₁ − u₀)/Δt, all else at θ u₁ + (1 − θ) u₀. Second order for θ = ½, else first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneStepTheta {
    theta: f64,
}

impl OneStepTheta {
    /// θ from ½ to 1, where the method is stable for each step.
    ///
    /// # Errors
    /// [`SchemeError`] for another θ.
    pub fn new(theta: f64) -> Result<Self, SchemeError> {
        Ok(OneStepTheta { theta: within(("the one-step-θ method", "θ"), theta, [0.5, 1.0])? })
    }

    /// θ = ½.
    pub fn crank_nicolson() -> Self {
        OneStepTheta { theta: 0.5 }
    }

    /// θ = 1.
    pub fn implicit_euler() -> Self {
        OneStepTheta { theta: 1.0 }
    }
}

impl Scheme for OneStepTheta {
    fn reads_second_rates(&self) -> bool {
        false
    }

    fn formulas(&self, steps: &[f64]) -> Formulas {
        let (step, theta) = (steps[0], self.theta);
        let value = Combination::new(1.0, [0.0; 3]);
        let rate = Combination::new(1.0 / step, [-1.0 / step, 0.0, 0.0]);
        let none = Combination::default();
        Formulas {
            evaluated: [Combination::new(theta, [1.0 - theta, 0.0, 0.0]), rate.clone(), none.clone()],
            end: [value, rate, none],
            load_at: theta,
        }
    }
}
