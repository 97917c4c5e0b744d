//! Nearly incompressible bodies on a flat obstacle by Nitsche's method, finite strains, F-bar: quadrilaterals and hexahedra of degree 1.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::averaged_nitsche::*;

/// The variation of ∫ W(F̄) − ∫ T(u)·v = ℓ(v), where the traction is that of the same averaged deformation, P(F̄) n. The body is that of
/// [`rubber`](fn@crate::operators::rubber::averaged_density), the contact that of [`frictional_nitsche`](super::frictional_nitsche).
///
/// In u only K multiplies the error of J after a step. The line search on the residual is the default, for whole steps go too far there; where K/μ is
/// above 100 Newton's method takes ten or more steps, or fails. [`averaged_problem`] has the same solution with one p per cell as a second unknown, in a
/// few steps.
///
/// Choose the quadrature rule, as `Quadrature::Degree(4)` for degree 1: the integrands are no polynomials, and the degree that is estimated is too high.
#[forms]
pub mod averaged_nitsche {
    use super::super::frictional_nitsche::{augmented, law};
    pub use super::super::mixed_nitsche::{Data, GammaC, GammaN, Omega, criterion, growth, loads};
    pub use crate::operators::rubber::{
        averaged_density, averaged_mixed_density, averaged_mixed_piola, averaged_piola,
    };

    /// T(u), the traction of the obstacle on the body, per reference area.
    pub fn obstacle_traction(w: Vector) -> Vector {
        law(augmented(averaged_piola(w) * n, w))
    }

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(augmented(averaged_piola(w) * n, w), obstacle_normal))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, derivative(averaged_density(u), u, v))
            - loads(v)
            - integral(GammaC, dot(obstacle_traction(u), v))
    }

    /// The direct problem with one p per cell: the same u in fewer Newton steps. p is eliminated cell by cell.
    pub fn with_pressure(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let W = averaged_mixed_density(u, p);
        integral(Omega, derivative(W, u, v) + derivative(W, p, q))
            - loads(v)
            - integral(GammaC, dot(law(augmented(averaged_mixed_piola(u, p) * n, u)), v))
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dκ = ∂R/∂κ (u; p), with p of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1)
    }

    /// ∫ e·T, the force of the obstacle on the body along e.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, dot(obstacle_traction(u), force_direction))
    }
}

contact_law!(averaged_nitsche {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: bulk_modulus,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
    coefficient: friction,
    line_search: OnResidual,
});

/// The direct problem with one p per cell, on the spaces of u and p, `Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[])`.
///
/// # Errors
/// A parameter out of its range.
pub fn averaged_problem<'a, const D: usize>(
    model: &averaged_nitsche::Model<D>,
    spaces: [&Arc<Space<D>>; 2],
) -> Result<Problem<'a, D, 2>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.with_pressure();
    model.check(form.name())?;
    let line_search = super::mixed_nitsche::line_search(model.data.slip_stress, model.data.friction);
    let options = NewtonOptions { line_search, ..NewtonOptions::default() };
    Ok(Problem::new(&form, spaces).options(options))
}

threshold_of_material!(threshold, averaged_nitsche, facets: gamma_c, bulk_modulus);
