//! Friction with a flat obstacle by multipliers at the points of Γ_C, which are updated outside of Newton's method: the law of
//! Uzawa's iteration, small strains.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::uzawa::*;

/// a(u,v) − ∫ T(λ, u)·v = ℓ(v) for a given multiplier λ, T = −\[P_n\]₋ n_y + Π_s(P_t) with P = λ − γ ((u_n − g) n_y + (u − u₀)_t):
/// the penalty method, shifted by λ. [`solve_by_uzawa`](crate::uzawa::solve_by_uzawa) repeats λ ← T(λ, u); where λ = T(λ, u)
/// holds at each point the conditions of contact and friction do, for any γ = γ₀/h_T, without a threshold. λ is a
/// [`History`](forms_fem::prelude::History) at the quadrature points of Γ_C, which hold T as it is: no space is in between. θ is
/// not read.
///
/// Contact is then exact at each of these points. With a rule of more points than Γ_C has nodes λ is not unique, u is; with
/// linear displacements take one point per facet.
#[forms]
pub mod uzawa {
    pub use super::super::frictional_nitsche::{Boundary, GammaC, GammaN, Omega, criterion};
    use super::super::frictional_nitsche::{augmented, elasticity, law, loads};

    /// Data of the body and of friction, with the multiplier.
    #[includes(crate::laws::frictional_nitsche::Data)]
    pub struct Data {
        /// λ, the traction of the obstacle on the body as far as it is known \[stress\].
        #[doc(alias = "λ")]
        pub multiplier: History<Vector>,
    }

    /// T(λ, u), the traction of the obstacle on the body, and the next multiplier.
    pub fn obstacle_traction(w: Vector) -> Vector {
        law(augmented(multiplier, w))
    }

    /// The direct problem for a given multiplier.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - loads(v) - integral(GammaC, dot(obstacle_traction(u), v))
    }
}

contact_law!(uzawa {
    direct: direct,
    region: gamma_c,
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
    coefficient: friction,
    line_search: OnResidual,
});
