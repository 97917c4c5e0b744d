//! Contact of two bodies with friction by Nitsche's method with means over own facets, small strains and small sliding.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::mean_two_bodies::*;

/// Σ a_i(u,v) + Σ D_i { (θ/γ)(⟨T⟩ − ⟨σ(u)n⟩)·⟨σ(v)n⟩ − ⟨T⟩·⟨⟦v⟧⟩ } = ℓ(v): the law of [`two_bodies`](super::two_bodies), with one traction
/// ⟨T⟩ = −\[⟨P_n⟩\]₋ n_y + Π_s(⟨P_t⟩) per own facet, for displacements of degree 1. With θ = 1 and without friction it is the variation of an
/// energy where γ is constant on each own cell.
#[forms]
pub mod mean_two_bodies {
    pub use super::super::two_bodies::{Data, GammaN, Omega, Touch, criterion, loads, slip_limit, stress};
    use crate::operators::bodies::{own_gamma, own_traction, present_gap};
    use crate::operators::friction::{augmented_traction, ball_projection, tangential};

    fn augmented(w: Vector) -> Vector {
        let slip = jump(w - displacement_before);
        augmented_traction(own_traction(w), present_gap(w), slip, own_gamma(), toward)
    }

    /// \[⟨P_n⟩\]₋, the pressure of the facet.
    fn pressure(w: Vector) -> Scalar {
        neg_part(mean(dot(augmented(w), toward)))
    }

    /// Π_s(⟨P_t⟩), the traction of friction on the facet.
    fn friction_traction(w: Vector) -> Vector {
        ball_projection(mean(tangential(augmented(w), toward)), slip_limit(pressure(w)))
    }

    /// ⟨T⟩·⟨e⟩ of a vector with sides.
    fn power(w: Vector, e: Vector) -> Scalar {
        dot(friction_traction(w), mean(tangential(e, toward))) - pressure(w) * mean(dot(e, toward))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let of_test = own_traction(v) / own_gamma();
        let consistent = dot(mean(own_traction(u)), mean(of_test));
        let nitsche = theta * (power(u, of_test) - consistent) - power(u, jump(v));
        integral(Omega, inner(stress(u), eps(v))) - loads(v) + means(Touch, 0, share * nitsche)
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
        means(Touch, 0, power(u, this(force_direction)))
    }
}

contact_law!(mean_two_bodies {
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

// A mean is no larger than what it is the mean of, so that the threshold at points is enough.
threshold_of_material!(threshold, mean_two_bodies, pairs: touch, lambda, theta: theta);
