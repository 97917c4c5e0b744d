//! ∫ ∇u·∇v.

use forms_fem::prelude::*;

/// The Laplacian's stiffness.
#[forms]
pub mod diffusion {
    /// No data.
    pub struct Data {}

    /// Ω.
    #[cells]
    pub struct Omega;

    /// ∫ ∇u·∇v.
    pub fn stiffness(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
}
