//! Contact of bodies with friction at large sliding and finite strains by Nitsche's method with θ = 0, with means over own facets in place
//! of values at points.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::mean_sliding_bodies::*;

/// ∫ P:∇v + Σ D_i { \[⟨P_n⟩_i\]₋ ⟨⟦v⟧·n_x⟩_i − Π_s(⟨P_t⟩_i)·⟨⟦v⟧_t⟩_i } = ℓ(v) over own facets, each with one mean: the law of
/// [`sliding_bodies`](super::sliding_bodies) for displacements of degree 1, with as many conditions of contact as there are facets. A body that
/// moves along another one feels its nodes less than by conditions at points (docs/mean_gaps.md). For displacements of degree 2 take
/// [`mean_sliding_bodies_of_degree_two`](mod@mean_sliding_bodies_of_degree_two).
///
/// Data, pairs and adjoint are those of `sliding_bodies`; its remarks on the rule of quadrature hold here, too.
#[forms]
pub mod mean_sliding_bodies {
    pub use super::super::two_bodies::{Data, GammaN, Omega, Touch, criterion, loads, slip_limit};
    use crate::operators::mean_sliding::{contact_of_facets, force_of_facets};
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v))) - loads(v)
            + contact_of_facets(first_piola(u) * n, u, v)
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
        force_of_facets(first_piola(u) * n, u, force_direction)
    }
}

contact_law!(mean_sliding_bodies {
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

threshold_of_material!(threshold, mean_sliding_bodies, pairs: touch, lambda);

/// The law of [`mean_sliding_bodies`](mod@mean_sliding_bodies) with one mean per vertex of each own facet, by the functions of degree 1: for
/// displacements of degree 2.
#[forms]
pub mod mean_sliding_bodies_of_degree_two {
    pub use super::super::two_bodies::{Data, GammaN, Omega, Touch, criterion, loads, slip_limit};
    use crate::operators::mean_sliding::{contact_of_vertices, force_of_vertices};
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v))) - loads(v)
            + contact_of_vertices(first_piola(u) * n, u, v)
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
        force_of_vertices(first_piola(u) * n, u, force_direction)
    }
}

contact_law!(mean_sliding_bodies_of_degree_two {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold_of_degree_two,
    positive: mu,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold_of_degree_two, mean_sliding_bodies_of_degree_two, pairs: touch, lambda);
