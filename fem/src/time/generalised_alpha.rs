//! The generalised-α method for second order in time, with Newmark's, HHT's, WBZ's and the mid-point rule as cases.

use super::scheme::{Combination, Formulas, Scheme, SchemeError, within};

/// Inertia at (1 − α_m) ü₁ + α_m ü₀, all else at (1 − α_f) u₁ + α_f u₀, and Newmark's formulas with β and γ between the two ends
/// of a step (Chung & Hulbert 1993). Second order where γ = ½ − α_m + α_f.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralisedAlpha {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
}

impl GeneralisedAlpha {
    /// Newmark's β and γ: no average of forces. Unconditionally stable for 2β ≥ γ ≥ ½; second order for γ = ½.
    ///
    /// # Errors
    /// [`SchemeError`] for γ outside ½..1 or β outside γ/2..1.
    pub fn newmark(beta: f64, gamma: f64) -> Result<Self, SchemeError> {
        let gamma = within(("Newmark's method", "γ"), gamma, [0.5, 1.0])?;
        let beta = within(("Newmark's method", "β"), beta, [gamma / 2.0, 1.0])?;
        Ok(GeneralisedAlpha { alpha_m: 0.0, alpha_f: 0.0, beta, gamma })
    }

    /// The trapezoidal rule, Newmark's method with β = ¼ and γ = ½: keeps the energy of linear problems.
    pub fn trapezoidal() -> Self {
        GeneralisedAlpha { alpha_m: 0.0, alpha_f: 0.0, beta: 0.25, gamma: 0.5 }
    }

    /// The mid-point rule: forces at (u₀ + u₁)/2, inertia (u̇₁ − u̇₀)/Δt. It has no accelerations at the ends of a step: the second rate of a state
    /// is (u̇₁ − u̇₀)/Δt, the acceleration in the middle of the step that ends there, and zero in the first state.
    pub fn mid_point() -> Self {
        GeneralisedAlpha { alpha_m: 0.5, alpha_f: 0.5, beta: 0.25, gamma: 0.5 }
    }

    /// The method of Hilber, Hughes and Taylor (1977) with α_f = `alpha` from 0 (no damping) to ⅓.
    ///
    /// # Errors
    /// [`SchemeError`] for another α.
    pub fn hilber_hughes_taylor(alpha: f64) -> Result<Self, SchemeError> {
        let alpha_f = within(("HHT's method", "α"), alpha, [0.0, 1.0 / 3.0])?;
        Ok(Self::of_second_order(0.0, alpha_f))
    }

    /// The method of Wood, Bossak and Zienkiewicz (1980) with ρ_∞, the spectral radius at infinite frequency, from 0 to 1.
    ///
    /// # Errors
    /// [`SchemeError`] for another ρ_∞.
    pub fn wood_bossak_zienkiewicz(rho_infinity: f64) -> Result<Self, SchemeError> {
        let rho = within(("WBZ's method", "ρ_∞"), rho_infinity, [0.0, 1.0])?;
        Ok(Self::of_second_order((rho - 1.0) / (rho + 1.0), 0.0))
    }

    /// Chung and Hulbert's choice: the least damping of low frequencies for ρ_∞, the spectral radius at infinite frequency, from 0 (a
    /// step takes what it cannot resolve away) to 1 (nothing is damped, the [mid-point rule](GeneralisedAlpha::mid_point)).
    ///
    /// # Errors
    /// [`SchemeError`] for another ρ_∞.
    pub fn with_spectral_radius(rho_infinity: f64) -> Result<Self, SchemeError> {
        let rho = within(("the generalised-α method", "ρ_∞"), rho_infinity, [0.0, 1.0])?;
        Ok(Self::of_second_order((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)))
    }

    /// γ and β of second order, with the most damping of high frequencies.
    fn of_second_order(alpha_m: f64, alpha_f: f64) -> Self {
        let gamma = 0.5 - alpha_m + alpha_f;
        let beta = (1.0 - alpha_m + alpha_f).powi(2) / 4.0;
        GeneralisedAlpha { alpha_m, alpha_f, beta, gamma }
    }
}

/// Whether some of the formulas read the second rate of the state before.
fn reads(formulas: [&Combination; 5]) -> bool {
    formulas.iter().any(|combination| combination.states[0][2] != 0.0)
}

impl Scheme for GeneralisedAlpha {
    fn reads_second_rates(&self) -> bool {
        let Formulas { evaluated, end: [value, rate, _], .. } = self.formulas(&[1.0]);
        reads([&evaluated[0], &evaluated[1], &evaluated[2], &value, &rate])
    }

    fn formulas(&self, steps: &[f64]) -> Formulas {
        let GeneralisedAlpha { alpha_m, alpha_f, beta, gamma } = *self;
        let step = steps[0];
        let start = |which: usize| {
            let mut last = [0.0; 3];
            last[which] = 1.0;
            Combination::new(0.0, last)
        };
        let value = Combination::new(1.0, [0.0; 3]);
        let second_rate = Combination::new(
            1.0 / (beta * step * step),
            [-1.0 / (beta * step * step), -1.0 / (beta * step), 1.0 - 0.5 / beta],
        );
        // u̇₁ = u̇₀ + Δt ((1 − γ) ü₀ + γ ü₁)
        let rate = Combination::new(
            gamma / (beta * step),
            [-gamma / (beta * step), 1.0 - gamma / beta, step * (1.0 - gamma / (2.0 * beta))],
        );
        let between = |alpha: f64, end: &Combination, which: usize| {
            Combination::sum(&[(1.0 - alpha, end), (alpha, &start(which))])
        };
        let evaluated =
            [between(alpha_f, &value, 0), between(alpha_f, &rate, 1), between(alpha_m, &second_rate, 2)];
        // Newmark's formula for ü₁ would carry the error of the first ü₀ on for ever, with a sign that changes in each step, where
        // nothing else reads accelerations.
        let all = [&evaluated[0], &evaluated[1], &evaluated[2], &value, &rate];
        let second_rate = if reads(all) { second_rate } else { evaluated[2].clone() };
        Formulas { evaluated, end: [value, rate, second_rate], load_at: 1.0 - alpha_f }
    }

    // u₁ = u₀ + Δt u̇₀ + Δt²/2 ü₀ + β Δt² (ü₁ − ü₀) compared with the ⅙ of Taylor's series (Zienkiewicz & Xie 1991).
    fn error_factor(&self) -> Option<f64> {
        self.reads_second_rates().then_some((self.beta - 1.0 / 6.0).abs())
    }
}
