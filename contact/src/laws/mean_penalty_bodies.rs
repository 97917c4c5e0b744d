//! Contact of bodies with friction at large sliding and finite strains by the penalty method, with means over own facets in place of values
//! at points.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::mean_penalty_bodies::*;

/// Springs of stiffness γ = γ₀/h_T between bodies, one per own facet: pressure \[γ ⟨g⟩\]₋, friction Π_s(−γ ⟨s⟩) with the slip s. The penetration
/// is of the order p/γ. Mean gaps bear a larger γ than gaps at points, whose number over-constrains surfaces on meshes that do not match
/// (docs/mean_gaps.md).
#[forms]
pub mod mean_penalty_bodies {
    pub use super::super::two_bodies::{Data, GammaN, Omega, Touch, criterion, loads, slip_limit};
    use crate::operators::mean_sliding::{contact_of_facets, force_of_facets};
    use crate::operators::neo_hookean::energy_density;
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v))) - loads(v) + contact_of_facets(0 * u, u, v)
    }

    /// The energy of the bodies and of frictionless springs, ∫ W + Σ D γ/2 \[⟨g⟩\]₋². Its forces act along the change of the gap, and its
    /// tangent is symmetric; where the surfaces are parallel, they are those of `direct`.
    pub fn stored(u: Unknown<Vector>) -> Energy {
        integral(Omega, energy_density(u))
            + means(Touch(u), 0, share / 2 * mean(this(gamma0) / this(h)) * sqr(neg_part(mean(gap))))
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
        force_of_facets(0 * u, u, force_direction)
    }
}

contact_law!(mean_penalty_bodies {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    positive: mu,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});
