//! Friction with a rigid obstacle given by a signed distance that moves and turns, small strains, by Nitsche's method with every
//! θ or by penalty.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::analytic_obstacle::*;

/// Contact with the obstacle y = c + Q ŷ, φ(ŷ) ≤ 0, where φ is the distance from a box with round edges: g = φ(Qᵀ(x + u − c)) and
/// n_y = −∇g turn with u, exactly, although strains are small. With P_n = σ_n + γ g, P_t = (σn − γ slip)_t
///
/// T = −\[P_n\]₋ n_y + Π_s(P_t),  s = s₀ + κ \[P_n\]₋,
///
/// a(u,v) − ∫ (θ/γ) σ(u)n·σ(v)n + ∫ (1/γ) T(u)·(θ σ(v)n − γ v) = ℓ(v).
///
/// The slip is that against the obstacle's own points, which were at (c₀, Q₀) at the last step:
/// (x + u − c) − Q Q₀ᵀ (x + u₀ − c₀). On a flat side that does not move it is
/// [`frictional_nitsche`](super::frictional_nitsche), term by term. Where the obstacle is curved the tangent is not symmetric,
/// also for θ = 1: the test function does not turn n_y.
///
/// For an obstacle of another shape write a module with another φ, in the language or in Rust on dual numbers
/// ([`capsule`](super::capsule)): the terms are [`operators::signed_distance`](crate::operators::signed_distance). A φ with
/// |∇φ| ≠ 1 is divided by its slope there.
#[forms]
pub mod analytic_obstacle {
    pub use super::super::frictional_nitsche::{elasticity, traction_product};
    use super::super::moving_obstacle::{in_own_axes, slip};
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::linear_elastic::stress;
    use crate::operators::loads::loads;
    use crate::operators::obstacle::gamma;
    use crate::operators::signed_distance::{
        nitsche_density, obstacle_traction as law, rounded_box_distance,
    };

    /// Data of the body, the method, the obstacle's motion and its shape, and of the loads.
    #[includes(
        crate::laws::moving_obstacle::Data,
        crate::operators::variant::Data,
        crate::operators::loads::Data
    )]
    pub struct Data {
        /// Half the edges of the box \[length\]; zero for a disk or a ball.
        #[default(0)]
        pub half_sizes: Param<Vector>,
        /// The radius of its round edges \[length\].
        pub radius: Param,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    /// φ at a point of space.
    fn distance(y: Vector) -> Scalar {
        rounded_box_distance(in_own_axes(y), half_sizes, radius)
    }

    /// ∇φ there.
    fn outward(y: Vector) -> Vector {
        diff(distance(y), y)
    }

    /// g = φ(x + u), the present gap.
    pub fn current_gap(w: Vector) -> Scalar {
        distance(x + w)
    }

    /// n_y = −∇φ(x + u), the unit normal into the obstacle.
    pub fn obstacle_normal(w: Vector) -> Vector {
        -outward(x + w)
    }

    fn traction_with(own: Vector, w: Vector) -> Vector {
        law(own, distance(x + w), outward(x + w), slip(w), gamma(), slip_stress, friction)
    }

    /// T(u), the traction of the obstacle on the body.
    pub fn obstacle_traction(w: Vector) -> Vector {
        traction_with(stress(w) * n, w)
    }

    /// −T·n_y = \[P_n\]₋, the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        dot(obstacle_traction(w), outward(x + w))
    }

    /// The measure of the contact zone.
    pub fn contact_length(u: State<Vector>) -> Functional {
        integral(GammaC, heaviside(contact_pressure(u)))
    }

    /// The direct problem by Nitsche's method.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - loads(v)
            + integral(
                GammaC,
                nitsche_density(stress(u) * n, obstacle_traction(u), stress(v) * n, v, theta, gamma()),
            )
    }

    /// The direct problem by penalty, T without σn: the error is of the order 1/γ. θ is not read.
    pub fn penalty(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - loads(v) - integral(GammaC, dot(traction_with(0 * u, u), v))
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dκ = ∂R/∂κ (u; p), with p of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1)
    }

    /// dJ/dr = ∂R/∂r (u; p) for the radius r of the obstacle, with p of `discrete_adjoint`.
    pub fn by_radius(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), radius, 1)
    }
}

contact_law!(analytic_obstacle {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    theta: theta,
    threshold: traction_product(elasticity, gamma0),
    positive: mu,
    positive: gamma0,
    non_negative: half_sizes,
    non_negative: radius,
    non_negative: slip_stress,
    non_negative: friction,
    rotation: rotation,
    rotation: rotation_before,
    coefficient: friction,
    line_search: OnResidual,
});
