//! Frictionless contact by Nitsche's method at small strains, θ = −1.

use forms_fem::prelude::*;

/// The integral over the contact boundary, alone and with the body.
#[forms]
pub mod small_strain_contact {
    /// Moduli, penalty, and the gap.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
        /// γ₀ \[stress\]; γ = γ₀ / h with h = |T| / |F|.
        pub gamma0: Param,
        /// g \[length\].
        pub gap: Given<Scalar>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_C.
    #[facets]
    pub struct GammaC;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * div(w) * I
    }

    fn normal_stress(w: Vector) -> Scalar {
        dot(n, stress(w) * n)
    }

    /// With P = σ_n(u) − γ (u_n − g): ∫ (1/γ) σ_n(u) σ_n(v) + (1/γ) min(P, 0) (−σ_n(v) − γ v_n).
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = gamma0 * facet_area / cell_volume;
        let pressure = min(normal_stress(u) - gamma * (dot(u, n) - gap), 0);
        let tested = -normal_stress(v) - gamma * dot(v, n);
        integral(GammaC, normal_stress(u) * normal_stress(v) / gamma + pressure * tested / gamma)
    }
    /// An elastic body in contact: what Newton's method solves.
    pub fn body(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) + nitsche(u, v)
    }
}
