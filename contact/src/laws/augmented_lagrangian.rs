//! Friction with a flat obstacle by the augmented Lagrangian of Alart and Curnier (1991), small strains, multipliers on the
//! facets of Γ_C.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::augmented_lagrangian::*;

/// The multiplier λ is the traction of the obstacle on the body, T(λ) = −\[P_n\]₋ n_y + Π_s(P_t) with
/// P = λ − γ ((u_n − g) n_y + (u − u₀)_t). Where the equation λ = T(λ) holds the conditions of contact and friction do, for any
/// γ = γ₀/h_T, without a threshold. θ is not read.
///
/// It has two unknowns, u and λ on a space on facets (`Space::vector_on_facets(&mesh, region, degree)`): [`multiplier_problem`] solves
/// it, on `[&displacements, &multipliers]`.
#[forms]
pub mod augmented_lagrangian {
    pub use super::super::frictional_nitsche::{Boundary, Data, GammaC, GammaN, Omega, criterion};
    use super::super::frictional_nitsche::{augmented, elasticity, law, loads};
    use crate::operators::obstacle::gamma;

    /// T(λ): the projection of the augmented multiplier onto the tractions that contact and friction allow.
    pub fn update(multiplier: Vector, w: Vector) -> Vector {
        law(augmented(multiplier, w))
    }

    /// The direct problem: a(u,v) − ∫ λ·v − ℓ(v) − ∫ (1/γ) (λ − T(λ))·q.
    pub fn direct(u: Unknown<Vector>, multiplier: Unknown<Vector>, v: Test<Vector>, q: Test<Vector>) -> Form {
        elasticity(u, v)
            - loads(v)
            - integral(GammaC, dot(multiplier, v))
            - integral(GammaC, dot(multiplier - update(multiplier, u), q) / gamma())
    }

    /// ∫ λ·e with e the data's `force_direction`.
    pub fn along(multiplier: State<Vector>) -> Functional {
        integral(GammaC, dot(multiplier, force_direction))
    }
}

parameter_ranges!(augmented_lagrangian {
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
});

/// The direct problem on the spaces of displacements and multipliers, with a line search on the residual unless it is given other
/// options.
///
/// # Errors
/// A parameter out of its range.
pub fn multiplier_problem<'a, const D: usize>(
    model: &augmented_lagrangian::Model<D>,
    spaces: [&Arc<Space<D>>; 2],
) -> Result<Problem<'a, D, 2>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
    Ok(Problem::new(&form, spaces).options(options))
}
