//! A compressible neo-Hookean solid, stated by its energy.

use forms_fem::prelude::*;

/// Residual and tangent are derived from the energy.
#[forms]
pub mod rubber {
    /// The two moduli.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
    }

    /// Ω, undeformed.
    #[cells]
    pub struct Omega;

    /// ∫ μ/2 (tr FᵀF − d) − μ ln J + λ/2 (ln J)², F = I + ∇u, J = det F.
    pub fn energy(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2))
    }
}
