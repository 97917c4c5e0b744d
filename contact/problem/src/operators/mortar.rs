//! Contact between bodies by multipliers on the own facets: conditions that hold against every function of the multipliers' space.

use forms_fem::forms;

/// Gaps and slips that multipliers allow, the pressure p and in the plane the traction t of friction. Contact and friction hold where the mean gap and
/// the mean slip are these, for any γ, which decides only how Newton's method tells what touches and what slides.
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

    /// (\[p − γ g\]₊ − p)/γ + g = \[g − p/γ\]₊, less δ p/γ: the mean gap that contact allows, 0 where the surfaces press. If it is the mean gap g, then p ≥ 0,
    /// g ≥ 0 and p g = 0.
    pub fn allowed_gap(p: Scalar, g: Scalar, gamma: Scalar) -> Scalar {
        pos_part(g - p / gamma) - uncovered * p / gamma
    }

    /// (Π_b(t − γ s) − t)/γ + s, less δ t/γ, with the bound b of |t|: the mean slip that friction allows, 0 where the surfaces stick. In the plane.
    pub fn allowed_slip(t: Scalar, s: Scalar, bound: Scalar, gamma: Scalar) -> Scalar {
        let trial = t - gamma * s;
        let traction = if bound > 0 { max(-bound, min(trial, bound)) } else { 0 };
        (traction - trial) / gamma - uncovered * t / gamma
    }
}
