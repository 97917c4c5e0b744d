//! ∫ σ(u):ε(v) of isotropic elasticity.

use forms_fem::prelude::*;

/// Isotropic linear elasticity.
#[forms(matrix_free)]
pub mod linear_elastic {
    /// The two moduli.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
    }

    /// Ω.
    #[cells]
    pub struct Omega;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * div(w) * I
    }

    /// ∫ σ(u):ε(v).
    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
}
