//! Slow viscous flow: two unknowns with spaces of their own.

use forms_fem::prelude::*;

/// Stokes' equations. Stable with a velocity of degree 2 and a pressure of degree 1 (Taylor and Hood).
#[forms]
pub mod flow {
    /// The fluid and its load.
    pub struct Data {
        /// μ, dynamic viscosity.
        pub viscosity: Param,
        /// f, force per volume.
        pub force: Given<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;

    /// ∫ 2μ ε(u):ε(v) − p div v − q div u − f·v. The sign of the last but one makes the system symmetric.
    pub fn equilibrium(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * viscosity * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - dot(force, v))
    }
}
