//! Contact of two bodies with friction by Nitsche's method (Chouly, Mlika, Renard 2018), small strains and small sliding.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::two_bodies::*;

/// Σ a_i(u,v) + Σ ½ ∫ { −(θ/γ) σ(u)n·σ(v)n + (1/γ) T·(θ σ(v)n − γ ⟦v⟧) } = ℓ(v) over the surfaces of both bodies: unbiased. Each
/// surface takes its own body's σ, h and γ. T acts on X and −T on Y in one integral, so that forces balance at any quadrature.
///
/// Pairs are those of the undeformed mesh. With both surfaces on pieces, the default of a
/// [`Pairing`](forms_fem::prelude::Pairing), a constant pressure is reproduced to rounding, whatever the meshes.
///
/// A point without a partner adds nothing: not −(θ/γ) σ(u)n·σ(v)n either, which is consistent there with and without it, for σn vanishes
/// on a free surface.
#[forms]
pub mod two_bodies {
    use crate::operators::bodies::{own_gamma, own_traction, present_gap};
    pub use crate::operators::friction::slip_limit;
    use crate::operators::friction::{augmented_traction, contact_traction, tangential};
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::linear_elastic::stress;
    pub use crate::operators::loads::loads;

    /// Data of laws between two bodies. Materials may differ from cell to cell: where bodies touch, give a field with a value per cell, for a
    /// function of position does not know which body is meant at a point of both (it is refused).
    #[includes(
        crate::operators::bodies::Data,
        crate::operators::variant::Data,
        crate::operators::friction::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data,
        crate::operators::resultant::Data
    )]
    pub struct Data {}

    /// Ω, both bodies.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;

    fn augmented(w: Vector) -> Vector {
        let slip = jump(w - displacement_before);
        augmented_traction(own_traction(w), present_gap(w), slip, own_gamma(), toward)
    }

    /// T(u), the traction of the opposite body on this one.
    pub fn opposite_traction(w: Vector) -> Vector {
        contact_traction(augmented(w), slip_limit(contact_pressure(w)), toward)
    }

    /// Π_s(P_t), the traction of friction on this body.
    pub fn friction_traction(w: Vector) -> Vector {
        tangential(opposite_traction(w), toward)
    }

    /// \[P_n\]₋, the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(augmented(w), toward))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let T = opposite_traction(u);
        let nitsche = theta / own_gamma() * dot(T - own_traction(u), own_traction(v)) - dot(T, jump(v));
        integral(Omega, inner(stress(u), eps(v))) - loads(v) + integral(Touch, share * nitsche)
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dκ = ∂R/∂κ (u; p), with p of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1)
    }

    /// ∫ e·T over the surfaces of the pairs: bound to one surface, the force of the opposite body on its body along e.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(Touch, dot(opposite_traction(u), this(force_direction)))
    }
}

contact_law!(two_bodies {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    theta: theta,
    threshold_by: threshold,
    positive: mu,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold, two_bodies, pairs: touch, lambda, theta: theta);
