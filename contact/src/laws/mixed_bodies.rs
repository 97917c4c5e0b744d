//! Contact of nearly incompressible bodies with friction at large sliding and finite strains, by Nitsche's method with θ = 0, with a field
//! for the mean stress.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::mixed_bodies::*;

/// ∫ P(u,p):∇v + ∫ (J − 1 − p/K) q − Σ ½ ∫ T·(v(X) − v(Y)) dA = ℓ(v): the bodies of [`rubber`](fn@crate::operators::rubber::mixed_density) with the
/// contact of [`sliding_bodies`](super::sliding_bodies), whose remarks on the rule of quadrature hold here, too. A rigid tool is the other side of
/// a pairing.
///
/// γ₀ has the scale of μ ([`usual_gamma0`](super::mixed_nitsche::usual_gamma0)).
#[forms]
pub mod mixed_bodies {
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::loads::loads;
    pub use crate::operators::rubber::{mixed_density, mixed_piola, three_field_density};
    use crate::operators::sliding::{pressure, traction as between};

    /// Data of both bodies. Materials may differ from cell to cell, by a field with a value per cell.
    #[includes(
        crate::operators::rubber::Data,
        crate::operators::sliding::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data,
        crate::operators::resultant::Data
    )]
    pub struct Data {
        /// μ, shear modulus \[stress\].
        #[doc(alias = "μ")]
        pub mu: Given<Scalar>,
        /// K, bulk modulus \[stress\].
        #[doc(alias = "K")]
        pub bulk_modulus: Given<Scalar>,
        /// γ₀ \[stress\]; γ = γ₀ / h_T.
        pub gamma0: Given<Scalar>,
    }

    /// Ω, both bodies.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(u: Vector, p: Scalar) -> Scalar {
        pressure(mixed_piola(u, p) * n, u)
    }

    /// T(u,p), the traction of the opposite body on this one, per reference area.
    pub fn opposite_traction(u: Vector, p: Scalar) -> Vector {
        between(mixed_piola(u, p) * n, u)
    }

    fn contact(u: Vector, p: Scalar, v: Test<Vector>) -> Form {
        -integral(Touch(u), share * dot(opposite_traction(u, p), jump(v)))
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

    /// ∫ e·T over the surfaces of the pairs: bound to one surface, the force of the opposite body on its body along e.
    pub fn contact_force(u: State<Vector>, p: State<Scalar>) -> Functional {
        integral(Touch(u), dot(opposite_traction(u, p), this(force_direction)))
    }
}

parameter_ranges!(mixed_bodies {
    positive: mu,
    positive: bulk_modulus,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
});

fn options() -> NewtonOptions {
    NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() }
}

/// The direct problem on the spaces of u and p, with a line search on the residual unless it is given other options.
///
/// # Errors
/// A parameter out of its range.
pub fn mixed_problem<'a, const D: usize>(
    model: &mixed_bodies::Model<D>,
    spaces: [&Arc<Space<D>>; 2],
) -> Result<Problem<'a, D, 2>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    Ok(Problem::new(&form, spaces).options(options()))
}

/// The direct problem on the spaces of u, p and j = J − 1, with a line search on the residual unless it is given other options.
///
/// # Errors
/// A parameter out of its range.
pub fn three_field_problem<'a, const D: usize>(
    model: &mixed_bodies::Model<D>,
    spaces: [&Arc<Space<D>>; 3],
) -> Result<Problem<'a, D, 3>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.three_fields();
    model.check(form.name())?;
    Ok(Problem::new(&form, spaces).options(options()))
}
