//! Contact of nearly incompressible bodies with friction at large sliding and finite strains, by Nitsche's method with θ = 0, F-bar:
//! quadrilaterals and hexahedra of degree 1.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::averaged_bodies::*;

/// The variation of ∫ W(F̄) − Σ ½ ∫ T·(v(X) − v(Y)) dA = ℓ(v): the bodies of [`rubber`](fn@crate::operators::rubber::averaged_density) with the contact
/// of [`sliding_bodies`](super::sliding_bodies), whose remarks on the rule of quadrature hold here, too.
///
/// Choose the quadrature rule, as `Quadrature::Degree(4)` for degree 1: the integrands are no polynomials, and the degree that is estimated is too high.
#[forms]
pub mod averaged_bodies {
    pub use super::super::mixed_bodies::{Data, GammaN, Omega, Touch, criterion, loads};
    pub use crate::operators::rubber::{averaged_density, averaged_piola};
    use crate::operators::sliding::{pressure, traction as between};

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(w: Vector) -> Scalar {
        pressure(averaged_piola(w) * n, w)
    }

    /// T(u), the traction of the opposite body on this one, per reference area.
    pub fn opposite_traction(w: Vector) -> Vector {
        between(averaged_piola(w) * n, w)
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, derivative(averaged_density(u), u, v))
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

contact_law!(averaged_bodies {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: bulk_modulus,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold, averaged_bodies, pairs: touch, bulk_modulus);
