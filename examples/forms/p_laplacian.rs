//! A nonlinear diffusion, stated by its energy.

use forms_fem::prelude::*;

/// The p-Laplacian, regularised.
#[forms]
pub mod diffusion {
    /// The two numbers of the law, and the load.
    pub struct Data {
        /// p > 1.
        pub exponent: Param,
        /// s \[the unit of ∇u\]: where |∇u| ≪ s the law is linear.
        pub regularisation: Param,
        /// f.
        pub source: Given<Scalar>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;

    /// ∫ (s² + |∇u|²)^(p/2) / p − f u.
    pub fn energy(u: Unknown<Scalar>) -> Energy {
        let size = pow(regularisation, 2) + dot(grad(u), grad(u));
        integral(Omega, pow(size, exponent / 2) / exponent - source * u)
    }
}
