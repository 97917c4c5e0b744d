//! Frictionless contact by Nitsche's method with the first Piola-Kirchhoff stress of a neo-Hookean solid, θ = −1.

use forms_fem::prelude::*;

/// The integral over the contact boundary alone; its tangent has the second derivative of the stress.
#[forms]
pub mod finite_strain_contact {
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

    /// Γ_C, undeformed.
    #[facets]
    pub struct GammaC;

    fn normal_stress(w: Vector) -> Scalar {
        let F = I + grad(w);
        let J = det(F);
        let density = mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2);
        dot(n, diff(density, F) * n)
    }

    /// As `small_strain_contact::nitsche`, with σ_n(u) = n·P(F) n and its derivative along v for σ_n(v).
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = gamma0 * facet_area / cell_volume;
        let varied = derivative(normal_stress(u), u, v);
        let pressure = min(normal_stress(u) - gamma * (dot(u, n) - gap), 0);
        let tested = -varied - gamma * dot(v, n);
        integral(GammaC, normal_stress(u) * varied / gamma + pressure * tested / gamma)
    }
}
