//! A tensor of rank 4 among the data.

use forms_fem::prelude::*;

/// Linear elasticity of an anisotropic solid.
#[forms]
pub mod solid {
    /// The material.
    pub struct Data {
        /// C_ijkl \[stress\], with σ_ij = C_ijkl ε_kl.
        pub constants: Param<Tensor4>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;

    /// C : ε(w).
    pub fn stress(w: Vector) -> Tensor {
        ddot(constants, eps(w))
    }

    /// ∫ σ(u):ε(v).
    pub fn equilibrium(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
}
