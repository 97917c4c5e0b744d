//! Contact of bodies with friction at large sliding and finite strains, by Nitsche's method with θ = 0 (Poulios and Renard 2015;
//! Mlika, Renard and Chouly 2017).

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::sliding_bodies::*;

/// ∫ P:∇v − Σ ½ ∫ T·(v(X) − v(Y)) dA = ℓ(v). Opposite points lie on rays along the deformed normal and move with u; the slip
/// counts the rotation of that normal, so that turning both bodies together is no slip, whatever the gap. Also self contact:
/// bind `Touch` to one surface.
///
/// Choose the quadrature rule, `Quadrature::Degree(4)` for quadratic displacements: its integrand is no polynomial, and the
/// estimated degree is above 20.
///
/// Facets keep their whole rule, so that a uniform pressure is not reproduced on meshes that do not match: the stress next to the
/// surface is off by an amount that depends on the rule and on which surface is integrated over and that stays on finer meshes. It vanishes
/// where the nodes of the two surfaces meet. docs/contact_between_bodies.md has figures; a higher rule makes it smaller. In the plane
/// `.at(PairQuadrature::Pieces)` has none (docs/points_segments_means.md), without `discrete_adjoint`, which holds points.
#[forms]
pub mod sliding_bodies {
    pub use super::super::two_bodies::{Data, GammaN, Omega, Touch, criterion, loads, slip_limit};
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};
    use crate::operators::sliding::{pressure, traction as between};

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(w: Vector) -> Scalar {
        pressure(first_piola(w) * n, w)
    }

    /// T(u), the traction of the opposite body on this one, per reference area.
    pub fn opposite_traction(w: Vector) -> Vector {
        between(first_piola(w) * n, w)
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(Touch(u), share * dot(opposite_traction(u), jump(v)))
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
        integral(Touch(u), dot(opposite_traction(u), this(force_direction)))
    }
}

contact_law!(sliding_bodies {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold, sliding_bodies, pairs: touch, lambda);
