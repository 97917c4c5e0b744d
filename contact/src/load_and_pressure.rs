//! Criteria other than the paper's (3) by itself: the work of the loads, and functionals of the contact pressure, which (22) as stated
//! does not cover. Their adjoint is that of the discrete problem, (21), and takes any functional.

use forms_fem::forms;

/// J(u) = load ℓ(u) + weight ∫ M(u) + ∫_ΓC (square \[·\]₋² + linear \[·\]₋), with the contact pressure \[σ_n − γ(u_n − g)\]₋.
#[forms]
pub mod load_and_pressure {
    pub use crate::nitsche::{GammaC, GammaN, Omega};
    use crate::nitsche::{cell_criterion, contact_pressure, direct};

    /// The weights of J, in addition to the data of the direct problem of [`crate::forms`].
    #[includes(crate::nitsche::Data)]
    pub struct Data {
        /// Weight of ℓ(u).
        pub load: Param,
        /// Weight of ∫ M(u) = ∫ F·u.
        #[default(0)]
        pub weight: Param,
        /// Weight of ∫ \[·\]₋².
        pub square: Param,
        /// Weight of ∫ \[·\]₋.
        pub linear: Param,
    }

    /// J.
    #[doc(alias = "J")]
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, load * dot(body_force, u) + weight * cell_criterion(u))
            + integral(GammaN, load * dot(traction, u))
            + integral(GammaC, (square * contact_pressure(u) + linear) * contact_pressure(u))
    }

    /// The discrete adjoint (21) of J.
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// The volume form of its shape derivative, as a linear form in Θ: with p of `adjoint` the exact derivative of J_h.
    pub fn shape_gradient(u: State<Vector>, p: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(criterion(u) + direct(u, p), shape, Theta)
    }

    /// The contribution of the diameters h_T in γ = γ₀ / h_T, per cell and unit of growth.
    pub fn diameter_gradient(u: State<Vector>, p: State<Vector>, growth: Test<Scalar>) -> Form {
        derivative(criterion(u) + direct(u, p), h, growth)
    }
}
