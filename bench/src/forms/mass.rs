//! ∫ u·v.

use forms_fem::prelude::*;

/// The mass matrix of a vector field.
#[forms]
pub mod inertia {
    /// No data.
    pub struct Data {}

    /// Ω.
    #[cells]
    pub struct Omega;

    /// ∫ u·v.
    pub fn vector(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
}
