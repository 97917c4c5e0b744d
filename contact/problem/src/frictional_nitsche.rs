//! Friction with a flat obstacle by Nitsche's method (Chouly 2014), small strains: the direct problem, its adjoints, its
//! energy.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::frictional_nitsche::*;

/// Linear elasticity in contact with friction. With P_n = σ_n − γ (u_n − g) and P_t = σ_t − γ (u − u₀)_t the traction of the
/// obstacle on the body is T = −\[P_n\]₋ n_y + Π_s(P_t), s = s₀ + κ \[P_n\]₋.
///
/// Without friction (s₀ = κ = 0) it keeps −(θ/γ) σ_t(u)·σ_t(v), a consistent term that (14) does not have: the discrete
/// solutions differ unless θ = 0.
#[forms]
pub mod frictional_nitsche {
    pub use crate::nitsche::{
        Boundary, GammaC, GammaN, Omega, boundary_slope, contact_force, contact_indicator, contact_length,
        contact_pressure, criterion, current_gap, elasticity, stress,
    };
    pub use crate::operators::friction::slip_limit;
    use crate::operators::friction::{
        augmented_traction, ball_potential, ball_projection, contact_traction, tangential,
    };
    pub use crate::operators::loads::loads;
    use crate::operators::obstacle::gamma;

    /// Data of all laws of friction with a flat. The slip is counted from u = 0 unless `displacement_before` is given.
    #[includes(crate::nitsche::Data, crate::operators::friction::Data, crate::operators::resultant::Data)]
    pub struct Data {}

    /// P of a traction on Γ_C at the displacement w.
    pub fn augmented(force: Vector, w: Vector) -> Vector {
        augmented_traction(force, current_gap(w), w - displacement_before, gamma(), obstacle_normal)
    }

    /// T(P) = −\[P_n\]₋ n_y + Π_s(P_t).
    pub fn law(P: Vector) -> Vector {
        contact_traction(P, slip_limit(neg_part(dot(P, obstacle_normal))), obstacle_normal)
    }

    fn nitsche(w: Vector) -> Vector {
        augmented(stress(w) * n, w)
    }

    /// T(u), the traction of the obstacle on the body.
    pub fn obstacle_traction(w: Vector) -> Vector {
        law(nitsche(w))
    }

    /// Π_s(P_t), the traction of friction on the body.
    pub fn friction_traction(w: Vector) -> Vector {
        ball_projection(tangential(nitsche(w), obstacle_normal), slip_limit(contact_pressure(w)))
    }

    /// |P_t| − s: the obstacle slips where it is positive.
    pub fn slip_indicator(w: Vector) -> Scalar {
        norm(tangential(nitsche(w), obstacle_normal)) - slip_limit(contact_pressure(w))
    }

    /// The direct problem:
    /// a(u,v) − ∫ (θ/γ) σ(u)n·σ(v)n + ∫ (1/γ) T(u)·(θ σ(v)n − γ v) − ℓ(v).
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - loads(v) - integral(GammaC, theta / gamma() * dot(stress(u) * n, stress(v) * n))
            + integral(GammaC, dot(obstacle_traction(u), theta * (stress(v) * n) - gamma() * v) / gamma())
    }

    /// ∫ σ(u)n·σ(v)n, on which the threshold of γ₀ rests.
    pub fn traction_product(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, dot(stress(u) * n, stress(v) * n))
    }

    /// ½ a(u,u) − ℓ(u) − ∫ |σn|²/2γ + ∫ \[P_n\]₋²/2γ + ∫ η_s₀(P_t)/γ, whose variation is `direct` for Tresca's law with
    /// θ = 1. Coulomb's law has no energy: κ is not read.
    pub fn tresca_energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, inner(stress(u), eps(u)) / 2 - dot(body_force, u))
            - integral(GammaN, dot(traction, u))
            + integral(
                GammaC,
                (sqr(contact_pressure(u)) / 2 - dot(stress(u) * n, stress(u) * n) / 2
                    + ball_potential(tangential(nitsche(u), obstacle_normal), slip_stress))
                    / gamma(),
            )
    }

    /// The adjoint of the discrete problem, for the criterion (3). Exact where no point of Γ_C is at a kink, P_n = 0 or
    /// |P_t| = s.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// The volume form of the shape derivative of the criterion along Θ, with p of `discrete_adjoint` that of J_h, h_T held. u₀
    /// moves with the mesh, as a field of nodal values does.
    pub fn shape_gradient(u: State<Vector>, p: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(criterion(u) + direct(u, p), shape, Theta)
    }

    /// The contribution of the diameters h_T in γ = γ₀/h_T, per cell and unit of growth.
    pub fn diameter_gradient(u: State<Vector>, p: State<Vector>, growth: Test<Scalar>) -> Form {
        derivative(direct(u, p), h, growth)
    }

    /// Dᵀw with D = ∂T/∂P.
    fn transposed_law(P: Vector, w: Vector) -> Vector {
        diff(dot(law(P), w), P)
    }

    /// The continuous adjoint by Nitsche's method with S = σ(p)n + N′: a(p,q) − ∫ (θ/γ) S·σ(q)n
    /// + ∫ (1/γ) Dᵀ(S − γp)·(θ σ(q)n − γq) = −J′, D at P + ξ n_y.
    fn continuous_adjoint(u: Vector, p: Vector, q: Vector, shift: Scalar) -> Form {
        let S = stress(p) * n + boundary_slope(u);
        let pulled = transposed_law(nitsche(u) + shift * obstacle_normal, S - gamma() * p);
        elasticity(p, q) - integral(GammaC, theta / gamma() * dot(S, stress(q) * n))
            + integral(GammaC, dot(pulled, theta * (stress(q) * n) - gamma() * q) / gamma())
            + derivative(criterion(u), u, q)
    }

    /// The consistent adjoint, as (22) with the transposed derivative of the law of contact and friction. At θ = 1 without N′
    /// on Γ_C it is `discrete_adjoint`.
    pub fn consistent_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        continuous_adjoint(u, p, q, 0)
    }

    /// The extended adjoint, as (41): with the law's derivative where the pressure is less by ξ = C √h_T.
    pub fn extended_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        continuous_adjoint(u, p, q, extension * sqrt(h))
    }

    /// dJ/ds₀ = ∂R/∂s₀ (u; p), with p of `discrete_adjoint`.
    pub fn by_slip_stress(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), slip_stress, 1)
    }

    /// dJ/dκ = ∂R/∂κ (u; p), with p of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1)
    }

    /// ∫ e·Π_s(P_t): the force of friction on the body along the unit vector e.
    pub fn tangential_force(u: State<Vector>) -> Functional {
        integral(GammaC, dot(friction_traction(u), force_direction))
    }

    /// The measure of the part of the contact zone that sticks.
    pub fn stick_length(u: State<Vector>) -> Functional {
        integral(GammaC, heaviside(contact_indicator(u)) * (1 - heaviside(slip_indicator(u))))
    }

    /// The measure of the part of the contact zone that slips.
    pub fn slip_length(u: State<Vector>) -> Functional {
        integral(GammaC, heaviside(contact_indicator(u)) * heaviside(slip_indicator(u)))
    }
}

contact_law!(frictional_nitsche {
    direct: direct,
    region: gamma_c,
    indicator: contact_indicator,
    criterion: criterion,
    adjoint: discrete_adjoint,
    shape_gradient: shape_gradient,
    diameter_gradient: diameter_gradient,
    theta: theta,
    threshold: traction_product(elasticity, gamma0),
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
    coefficient: friction,
    line_search: OnResidual,
});
