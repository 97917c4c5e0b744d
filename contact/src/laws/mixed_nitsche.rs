//! Nearly incompressible bodies on a flat obstacle by Nitsche's method, finite strains, with a field for the mean stress: friction with
//! θ = 0, or the energy without friction.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::mixed_nitsche::*;

/// ∫ P(u,p):∇v + ∫ (J − 1 − p/K) q − ∫ T(u,p)·v = ℓ(v): P = ∂W_iso/∂F + p cof F, and so the traction P n in T, read the field p. The
/// body is that of [`rubber`](fn@crate::operators::rubber::mixed_density), the contact that of
/// [`frictional_nitsche`](super::frictional_nitsche).
///
/// γ₀ has the scale of μ where the element is stable for incompressible bodies, and not that of K: [`usual_gamma0`].
///
/// [`mixed_problem`] and [`three_field_problem`] solve it; choose the quadrature rule, as `Quadrature::Degree(5)` for degree 2. Fields p and j with discontinuous spaces are eliminated cell by cell.
#[forms]
pub mod mixed_nitsche {
    use super::super::frictional_nitsche::{augmented, law};
    pub use crate::operators::friction::slip_limit;
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::loads::loads;
    use crate::operators::obstacle::nitsche_energy;
    pub use crate::operators::rubber::{mixed_density, mixed_piola, three_field_density};

    /// Data of the body, the obstacle, friction and loads.
    #[includes(
        crate::operators::rubber::Data,
        crate::operators::rigid_flat::Data,
        crate::operators::friction::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data,
        crate::operators::resultant::Data
    )]
    pub struct Data {}

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    /// T(u,p), the traction of the obstacle on the body, per reference area.
    pub fn obstacle_traction(u: Vector, p: Scalar) -> Vector {
        law(augmented(mixed_piola(u, p) * n, u))
    }

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(u: Vector, p: Scalar) -> Scalar {
        neg_part(dot(augmented(mixed_piola(u, p) * n, u), obstacle_normal))
    }

    /// σ = P Fᵀ/J, Cauchy's stress.
    #[doc(alias = "σ")]
    pub fn cauchy_stress(u: State<Vector>, p: State<Scalar>) -> Tensor {
        let F = I + grad(u);
        mixed_piola(u, p) * transpose(F) / det(F)
    }

    fn contact(u: Vector, p: Scalar, v: Test<Vector>) -> Form {
        -integral(GammaC, dot(obstacle_traction(u, p), v))
    }

    /// The direct problem with u and p.
    pub fn direct(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let W = mixed_density(u, p);
        integral(Omega, derivative(W, u, v) + derivative(W, p, q)) - loads(v) + contact(u, p, v)
    }

    /// The direct problem with u, p and j = J − 1.
    pub fn three_fields(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        dilatation: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        let W = three_field_density(u, p, dilatation);
        integral(Omega, derivative(W, u, v) + derivative(W, p, q) + derivative(W, dilatation, r)) - loads(v)
            + contact(u, p, v)
    }

    fn work_of_loads(u: Vector) -> Energy {
        integral(Omega, dot(body_force, u)) + integral(GammaN, dot(traction, u))
    }

    fn normal_stress(u: Vector, p: Scalar) -> Scalar {
        dot(mixed_piola(u, p) * n, obstacle_normal)
    }

    /// The energy of contact without friction, with u and p: Nitsche's method with θ = 1, whose tangent is symmetric. Friction is not read.
    pub fn energy(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        integral(Omega, mixed_density(u, p)) - work_of_loads(u)
            + integral(GammaC, nitsche_energy(normal_stress(u, p), u))
    }

    /// `energy` with u, p and j.
    pub fn three_field_energy(u: Unknown<Vector>, p: Unknown<Scalar>, dilatation: Unknown<Scalar>) -> Energy {
        integral(Omega, three_field_density(u, p, dilatation)) - work_of_loads(u)
            + integral(GammaC, nitsche_energy(normal_stress(u, p), u))
    }

    /// The adjoint (z, s) of `direct` for the criterion ∫ F·u.
    pub fn discrete_adjoint(
        u: State<Vector>,
        p: State<Scalar>,
        z: Unknown<Vector>,
        s: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
    ) -> Form {
        derivative(direct(u, p, z, s), u, v)
            + derivative(direct(u, p, z, s), p, q)
            + derivative(criterion(u), u, v)
    }

    /// dJ/dκ = ∂R/∂κ, with (z, s) of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Scalar>, z: State<Vector>, s: State<Scalar>) -> Functional {
        derivative(direct(u, p, z, s), friction, 1)
    }

    /// ∫ e·T, the force of the obstacle on the body along e.
    pub fn contact_force(u: State<Vector>, p: State<Scalar>) -> Functional {
        integral(GammaC, dot(obstacle_traction(u, p), force_direction))
    }

    /// ∫ (J − 1), the change of the body's volume.
    pub fn growth(u: State<Vector>) -> Functional {
        integral(Omega, det(I + grad(u)) - 1)
    }
}

parameter_ranges!(mixed_nitsche {
    positive: mu,
    positive: bulk_modulus,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
});

/// γ₀ = 20 μ \[stress\] of a law that reads the field p, for any bulk modulus. The element must be stable for incompressible bodies: with MINI,
/// P2/P1, Q2/P₋₁ the normal stress is controlled by the scale of μ. F-bar has no such field:
/// [`usual_gamma0`](crate::threshold::usual_gamma0) with λ = K − 2μ/3.
pub fn usual_gamma0(mu: f64) -> f64 {
    20.0 * mu
}

/// The line search of laws with this bound of friction: whole steps go back and forth between stick and slip. Without friction they serve, and
/// with u and p the search on the residual would leave them whole.
pub(crate) fn line_search(slip_stress: f64, friction: f64) -> LineSearch {
    if slip_stress == 0.0 && friction == 0.0 { LineSearch::Off } else { LineSearch::OnResidual }
}

/// The direct problem on the spaces of u and p, with a line search on the residual where there is friction, unless it is given other options.
///
/// # Errors
/// A parameter out of its range.
pub fn mixed_problem<'a, const D: usize>(
    model: &mixed_nitsche::Model<D>,
    spaces: [&Arc<Space<D>>; 2],
) -> Result<Problem<'a, D, 2>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    let line_search = line_search(model.data.slip_stress, model.data.friction);
    let options = NewtonOptions { line_search, ..NewtonOptions::default() };
    Ok(Problem::new(&form, spaces).options(options))
}

/// The direct problem on the spaces of u, p and j = J − 1, with a line search on the residual where there is friction, unless it is given other options.
///
/// # Errors
/// A parameter out of its range.
pub fn three_field_problem<'a, const D: usize>(
    model: &mixed_nitsche::Model<D>,
    spaces: [&Arc<Space<D>>; 3],
) -> Result<Problem<'a, D, 3>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.three_fields();
    model.check(form.name())?;
    let line_search = line_search(model.data.slip_stress, model.data.friction);
    let options = NewtonOptions { line_search, ..NewtonOptions::default() };
    Ok(Problem::new(&form, spaces).options(options))
}
