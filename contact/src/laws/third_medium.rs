//! Contact through a third medium: bodies in a very soft one, whose crushed cells carry the pressure. Finite strains, no friction, an energy.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::third_medium::*;

/// The stationary point of ∫_B W(u; λ, μ) + ∫_M W(u; λ_M, μ_M) + ½ k (H⋮H − L·L/D) − ℓ(u): W is the neo-Hookean energy of
/// [`neo_hookean`](fn@crate::operators::neo_hookean::energy_density), H = ∇∇u, and L = div ∇u.
///
/// No pairs are searched for, and self contact needs nothing. The medium's ln J grows without bound where a gap closes. The term in k keeps the medium's cells
/// regular (Bluhm, Sigmund and Poulios 2021; with L Frederiksen, Dalklint, Sigmund and Poulios 2025, Comput. Methods Appl. Mech. Eng. 436). It needs cells of degree 2 or above: on simplices of degree 1 it is zero.
/// The error is a thin layer of crushed medium, and forces in it before it closes, of the size of μ_M.
///
/// Usual values are λ_M = s λ and μ_M = s μ with s = 10⁻⁶ to 10⁻⁵, and k = s λ ℓ² with the size ℓ of the whole ([`medium()`]). Keep J positive, so that a step of Newton's
/// method does not turn the medium inside out, as [`third_medium_problem`] does.
#[forms]
pub mod third_medium {
    pub use crate::operators::loads::loads;
    use crate::operators::neo_hookean::density;
    use crate::operators::strains::deformation_gradient;

    /// Data of the bodies, the medium and the loads.
    #[includes(crate::operators::neo_hookean::Data, crate::operators::loads::Data)]
    pub struct Data {
        /// λ_M, the medium's first parameter of Lamé \[stress\].
        pub medium_lambda: Param,
        /// μ_M, the medium's shear modulus \[stress\].
        pub medium_mu: Param,
        /// k, the stiffness against second derivatives of u in the medium \[force per length in the plane, force in space\].
        pub curvature_stiffness: Param,
    }

    /// The bodies.
    #[cells]
    pub struct Omega;
    /// The medium.
    #[cells]
    pub struct Medium;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;

    /// λ/2 (ln J)² + μ/2 (tr C − D − 2 ln J), per reference volume of the medium.
    pub fn medium_density(u: Vector) -> Scalar {
        let F = deformation_gradient(u);
        let J = volume_ratio(u);
        medium_mu / 2 * (inner(F, F) - D - 2 * ln(J)) + medium_lambda / 2 * pow(ln(J), 2)
    }

    /// ½ (H⋮H − L·L/D), which vanishes where u has no second derivatives.
    pub fn second_gradients(u: Vector) -> Scalar {
        let L = div(grad(u));
        (inner(hess(u), hess(u)) - dot(L, L) / D) / 2
    }

    /// The energy without loads, whose derivative along a displacement is a force.
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, density(deformation_gradient(u)))
            + integral(Medium, medium_density(u) + curvature_stiffness * second_gradients(u))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(stored(u), u, v) - loads(v)
    }

    /// J = det F, the volume over that at rest.
    pub fn volume_ratio(u: Vector) -> Scalar {
        det(deformation_gradient(u))
    }

    /// ∫ J, whose integrand has to stay positive at all points.
    pub fn volume(u: Unknown<Vector>) -> Functional {
        integral(Omega, volume_ratio(u)) + integral(Medium, volume_ratio(u))
    }

    /// The work of the internal forces along w: the force on a node or a part of the boundary that moves by w, with w zero where u is free.
    pub fn force_along(u: State<Vector>, w: State<Vector>) -> Functional {
        derivative(stored(u), u, w)
    }

    /// The adjoint problem of a force: K q = 0 for test functions that vanish where u is prescribed, with q = w there. K is symmetric.
    pub fn force_adjoint(u: State<Vector>, q: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(derivative(stored(u), u, v), u, q)
    }

    /// dF/dμ of the force along w, with q of [`force_adjoint`](fn@force_adjoint) and the body's μ only.
    pub fn force_by_mu(u: State<Vector>, q: State<Vector>) -> Functional {
        derivative(force_along(u, q), mu, 1)
    }

    /// dF/dλ of the same force.
    pub fn force_by_lambda(u: State<Vector>, q: State<Vector>) -> Functional {
        derivative(force_along(u, q), lambda, 1)
    }
}

parameter_ranges!(third_medium {
    positive: mu,
    positive: medium_mu,
    non_negative: medium_lambda,
    non_negative: curvature_stiffness,
});

/// The direct problem, whose steps keep J positive.
///
/// # Errors
/// A parameter out of its range.
pub fn third_medium_problem<'a, const D: usize>(
    model: &third_medium::Model<D>,
    space: &Arc<Space<D>>,
) -> Result<Problem<'a, D>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    Ok(Problem::new(&form, space).keep_positive(&model.volume()))
}

/// The medium's parameters, as parts of the bodies'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumParameters {
    /// λ_M \[stress\].
    pub lambda: f64,
    /// μ_M \[stress\].
    pub mu: f64,
    /// k \[stress · length²\].
    pub curvature_stiffness: f64,
}

/// The usual medium for bodies with λ and μ: `softness` times as stiff, with the stiffness s λ ℓ² against second derivatives for bodies and gaps
/// that fit into a box of this size ℓ.
pub fn medium(lambda: f64, mu: f64, softness: f64, size: f64) -> MediumParameters {
    MediumParameters {
        lambda: softness * lambda,
        mu: softness * mu,
        curvature_stiffness: softness * lambda * size * size,
    }
}
