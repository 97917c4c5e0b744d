//! Forms of contact whose pressure is a function of the gap: a log barrier, an exponential law.

use forms_fem::forms;

/// A barrier that keeps a gap positive. Nothing acts at gaps above ĝ, and the pressure grows without bound as the gap closes.
#[forms]
pub mod barrier {
    /// The barrier's parameters.
    pub struct Data {
        /// κ, the barrier's stiffness \[stress per length\].
        #[doc(alias = "κ")]
        pub barrier_stiffness: Param,
        /// ĝ, the gap at which the barrier begins to act \[length\].
        #[doc(alias = "ĝ")]
        pub activation_gap: Param,
        /// c, the penetration that is never reached: the barrier acts on g + c \[length\].
        #[default(0)]
        pub clearance: Param,
    }

    /// b(g) = −(g − ĝ)² ln(g/ĝ) below ĝ, else 0: twice continuously differentiable. It is not a number where g ≤ 0.
    pub fn barrier(g: Scalar) -> Scalar {
        if g < activation_gap { -sqr(g - activation_gap) * ln(g / activation_gap) } else { 0 }
    }

    /// −κ b′(g), the pressure.
    pub fn barrier_pressure(g: Scalar) -> Scalar {
        -barrier_stiffness * diff(barrier(g), g)
    }
}

/// A pressure that falls exponentially with the gap, as that of asperities.
#[forms]
pub mod exponential_closure {
    /// The law's parameters.
    pub struct Data {
        /// p₀, the pressure at a gap of zero \[stress\].
        #[doc(alias = "p₀")]
        pub closed_pressure: Param,
        /// c, the gap over which the pressure falls to 1/e of itself \[length\].
        pub closure_length: Param,
    }

    /// p₀ exp(−g/c), the pressure.
    pub fn exponential_pressure(g: Scalar) -> Scalar {
        closed_pressure * exp(-g / closure_length)
    }

    /// p₀ c exp(−g/c), the energy per area.
    pub fn exponential_energy(g: Scalar) -> Scalar {
        closure_length * exponential_pressure(g)
    }
}
