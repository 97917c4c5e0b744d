//! Friction with a flat obstacle by Nitsche's method with θ = 0, finite strains of a neo-Hookean body.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::finite_nitsche::*;

/// ∫ P(u):∇v − ∫ T(u)·v = ℓ(v), where tractions are forces per reference area: P(u)n replaces σn in T. γ, h_T and areas
/// are those of the reference configuration, and so are the loads. θ is not read: other variants than θ = 0 would need second
/// derivatives of the stress.
#[forms]
pub mod finite_nitsche {
    pub use super::super::frictional_nitsche::{Boundary, Data, GammaC, GammaN, Omega, criterion};
    use super::super::frictional_nitsche::{augmented, law, loads};
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};

    /// T(u), the traction of the obstacle on the body, per reference area.
    pub fn obstacle_traction(w: Vector) -> Vector {
        law(augmented(first_piola(w) * n, w))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(GammaC, dot(obstacle_traction(u), v))
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

contact_law!(finite_nitsche {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
    coefficient: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold, finite_nitsche, facets: gamma_c, lambda);
