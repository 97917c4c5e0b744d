//! Friction with a flat obstacle by the penalty method, small strains.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::frictional_penalty::*;

/// T = −\[P_n\]₋ n_y + Π_s(P_t) with P = −γ ((u_n − g) n_y + (u − u₀)_t): springs of stiffness γ = γ₀/h_T, whose
/// tangential ones slide. The error is of the order 1/γ. θ is not read. T has no stress in it, so that the law is monotone without
/// a threshold of γ₀.
#[forms]
pub mod frictional_penalty {
    pub use super::super::frictional_nitsche::{Boundary, Data, GammaC, GammaN, Omega, criterion};
    use super::super::frictional_nitsche::{augmented, elasticity, law, loads};

    /// T(u), the traction of the obstacle on the body.
    pub fn obstacle_traction(w: Vector) -> Vector {
        law(augmented(0 * w, w))
    }

    /// The direct problem: a(u,v) − ∫ T(u)·v − ℓ(v).
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - loads(v) - integral(GammaC, dot(obstacle_traction(u), v))
    }

    /// The adjoint of the discrete problem, for the criterion (3).
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dκ = ∂R/∂κ (u; p), with p of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1)
    }
}

contact_law!(frictional_penalty {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
    coefficient: friction,
    line_search: OnResidual,
});
