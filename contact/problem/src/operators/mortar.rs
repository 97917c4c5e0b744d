//! Contact between bodies by multipliers on the own facets: conditions that hold against every function of the multipliers' space.

use forms_fem::forms;

/// Complementarity functions of multipliers, the pressure p and in the plane the traction t of friction. Each vanishes where the conditions of
/// contact and friction hold, for any γ, which decides only how Newton's method tells what touches and what slides.
#[forms]
pub mod multipliers {
    /// The parameter of the method, friction, and what holds multipliers that nothing faces.
    #[includes(super::super::friction::Data)]
    pub struct Data {
        /// γ₀ \[stress\]; γ = γ₀ / h_T.
        pub gamma0: Given<Scalar>,
        /// δ, the part with which the equation p = 0 counts at each node, so that what is not covered has no pressure. A mean gap is off by δ p/γ.
        #[doc(alias = "δ")]
        #[default(0.000000000000000001)]
        pub uncovered: Param,
    }

    /// \[p − γ g\]₊, the pressure that contact allows.
    pub fn allowed_pressure(p: Scalar, g: Scalar, gamma: Scalar) -> Scalar {
        pos_part(p - gamma * g)
    }

    /// (p − \[p − γ g\]₊)/γ: g where the surfaces press, with δ p/γ, and p/γ where they are apart.
    pub fn normal_condition(p: Scalar, g: Scalar, gamma: Scalar) -> Scalar {
        if p > gamma * g { g + uncovered * p / gamma } else { p / gamma }
    }

    /// (t − Π_s(t − γ s_t))/γ with the bound s of |t|: the slip s_t where the surfaces stick, with δ t/γ, and t/γ where s ≤ 0. In the plane.
    pub fn tangential_condition(t: Scalar, slip: Scalar, bound: Scalar, gamma: Scalar) -> Scalar {
        let trial = t - gamma * slip;
        let slides = (t - if trial > 0 { bound } else { -bound }) / gamma;
        let bears = if abs(trial) > bound { slides } else { slip + uncovered * t / gamma };
        if bound > 0 { bears } else { t / gamma }
    }
}
