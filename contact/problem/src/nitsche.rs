//! The paper's equations as forms. Equation numbers are those of Bretin et al. (2023), hal-03936245.

use forms_fem::forms;

#[doc(inline)]
pub use self::nitsche::*;

/// Linear elasticity in frictionless contact with a rigid obstacle, by Nitsche's method.
///
/// Signs: n_y points into the obstacle; the gap g = n_y·(y − x) is positive when apart; a normal stress
/// σ_n ≤ 0 presses. (15) is used with MINUS before its last integral, as Green's formula asks: the printed
/// plus makes the obstacle pull (see `docs/method.md`).
#[forms]
pub mod nitsche {
    pub use crate::operators::linear_elastic::{stress, von_mises};
    pub use crate::operators::obstacle::{current_gap, normal_displacement, penetration};
    use crate::operators::obstacle::{gamma, nitsche_test};

    /// Data of all forms. No load acts and no criterion weighs unless they are given.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::obstacle::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data
    )]
    pub struct Data {
        /// C in ξ = C √h_T of the extended-Neumann adjoint (41); only `extended_adjoint` reads it.
        #[doc(alias = "C")]
        #[default(0)]
        pub extension: Param,
        /// c in the criterion's N(u) = ½ c |u|²; zero where N does not act.
        #[doc(alias = "c")]
        #[default(0)]
        pub criterion_weight: Given<Scalar>,
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
    /// ∂Ω, where the criterion's N acts.
    #[doc(alias = "∂Ω")]
    #[facets]
    pub struct Boundary;

    /// σ_n(w) = (σ(w) n)·n_y.
    #[doc(alias = "σ_n")]
    pub fn normal_stress(w: Vector) -> Scalar {
        dot(stress(w) * n, obstacle_normal)
    }

    /// σ_n(w) − γ (w_n − g); −β_h of the paper.
    #[doc(alias = "P")]
    fn augmented_stress(w: Vector) -> Scalar {
        normal_stress(w) - gamma() * penetration(w)
    }

    /// β_h = −σ_n(w) + γ (w_n − g): contact where positive.
    #[doc(alias = "β_h")]
    pub fn contact_indicator(w: Vector) -> Scalar {
        -augmented_stress(w)
    }

    /// β_h − ξ, ξ = C √h_T: positive in the contact zone of (41).
    pub fn extended_indicator(w: Vector) -> Scalar {
        contact_indicator(w) - extension * sqrt(h)
    }

    /// \[σ_n(w) − γ (w_n − g)\]₋: the contact pressure of Nitsche's method.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(augmented_stress(w))
    }

    /// a(u, v) = ∫ σ(u):ε(v).
    #[doc(alias = "a")]
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }

    /// The direct problem (14)-(15): a(u,v) − ∫ (θ/γ) σ_n(u) σ_n(v) − ∫ (1/γ) \[σ_n(u) − γ(u_n − g)\]₋ (θ σ_n(v) − γ v_n) − ℓ(v).
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v)
            - integral(Omega, dot(body_force, v))
            - integral(GammaN, dot(traction, v))
            - integral(GammaC, theta / gamma() * normal_stress(u) * normal_stress(v))
            - integral(GammaC, neg_part(augmented_stress(u)) / gamma() * nitsche_test(normal_stress(v), v))
    }

    /// M(u) = F·u.
    #[doc(alias = "M")]
    pub fn cell_criterion(w: Vector) -> Scalar {
        dot(criterion_force, w)
    }

    /// N(u) = ½ c |u|².
    #[doc(alias = "N")]
    pub fn boundary_criterion(w: Vector) -> Scalar {
        criterion_weight / 2 * dot(w, w)
    }

    /// N′(u).
    #[doc(alias = "N_prime")]
    pub fn boundary_slope(w: Vector) -> Vector {
        diff(boundary_criterion(w), w)
    }

    /// The criterion (3): J = ∫_Ω M(u) + ∫_∂Ω N(u).
    #[doc(alias = "J")]
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, cell_criterion(u)) + integral(Boundary, boundary_criterion(u))
    }

    /// The discrete adjoint (21): the derivatives of `direct` and `criterion`, which the compiler takes.
    /// Its matrix is the transpose of the tangent of `direct`.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// The volume form of the shape derivative of the criterion along Θ: that of J(u) + R(u; p), the whole discrete problem
    /// (14) in it, with u and p at fixed nodal values. With p of (21) it is the exact derivative of J_h, h_T held.
    pub fn shape_derivative(u: State<Vector>, p: State<Vector>, Theta: State<Vector>) -> Functional {
        derivative(criterion(u) + direct(u, p), shape, Theta)
    }

    /// `shape_derivative` as a linear form in Θ: its vector is the gradient by nodes.
    pub fn shape_gradient(u: State<Vector>, p: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(criterion(u) + direct(u, p), shape, Theta)
    }

    /// The contribution of the diameters h_T in γ = γ₀ / h_T, per cell and unit of growth.
    pub fn diameter_gradient(u: State<Vector>, p: State<Vector>, growth: Test<Scalar>) -> Form {
        derivative(direct(u, p), h, growth)
    }

    /// (22), with the contact zone where β_h(u) > shift.
    fn adjoint(u: Vector, p: Vector, q: Vector, shift: Scalar) -> Form {
        let slope = dot(boundary_slope(u), obstacle_normal);
        let contact = heaviside(contact_indicator(u) - shift);
        elasticity(p, q) - integral(GammaC, theta / gamma() * (normal_stress(p) + slope) * normal_stress(q))
            + integral(
                GammaC,
                contact / gamma()
                    * (normal_stress(p) + slope - gamma() * normal_displacement(p))
                    * nitsche_test(normal_stress(q), q),
            )
            + derivative(criterion(u), u, q)
    }

    /// The consistent adjoint (22). Its matrix is the tangent of `direct`, not transposed.
    pub fn consistent_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        adjoint(u, p, q, 0)
    }

    /// The extended-Neumann adjoint (41): (22) with H(β_h − ξ), ξ = C √h_T.
    pub fn extended_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        adjoint(u, p, q, extension * sqrt(h))
    }

    /// ∫ \[σ_n(u) − γ(u_n − g)\]₋: the resultant of the contact pressure.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, contact_pressure(u))
    }

    /// |Γ^h_C,a| = ∫ H(β_h): the measure of the discrete contact zone.
    pub fn contact_length(u: State<Vector>) -> Functional {
        integral(GammaC, heaviside(contact_indicator(u)))
    }

    /// ∫_F σ_n(u) σ_n(v), for the threshold of γ₀.
    pub fn normal_stress_product(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, normal_stress(u) * normal_stress(v))
    }
}
