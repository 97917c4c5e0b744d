//! Frictionless contact with a flat obstacle by a log barrier, small strains: gaps stay positive.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::barrier_obstacle::*;

/// The minimum of ½ a(u,u) − ℓ(u) + κ ∫ b(g − u_n + c), b = −(g − ĝ)² ln(g/ĝ) at gaps below ĝ (Li et al. 2020, with plain gaps): smooth,
/// symmetric, without an active set. [`barrier_problem`] takes steps that let no point through.
///
/// The error is of order ĝ. With κ by [`stiffness`] the pressure p keeps a gap of ĝ/2. Solve with a ĝ of the size of the displacement first, then
/// with halves of it, each from the last solution. Bodies that touch at the start need a clearance c > 0, which is the largest penetration.
#[forms]
pub mod barrier_obstacle {
    use crate::operators::barrier::{barrier, barrier_pressure};
    pub use crate::operators::linear_criterion::criterion;
    use crate::operators::linear_elastic::energy_density;
    pub use crate::operators::loads::loads;
    use crate::operators::obstacle::current_gap;

    /// Data of the body, the obstacle and the barrier.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::barrier::Data,
        crate::operators::flat_obstacle::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data
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

    /// g − u_n + c, which the barrier keeps positive.
    pub fn guarded_gap(w: Vector) -> Scalar {
        current_gap(w) + clearance
    }

    /// −κ b′, the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        barrier_pressure(guarded_gap(w))
    }

    /// ½ a(u,u) + κ ∫ b, the energy without loads.
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u)) + integral(GammaC, barrier_stiffness * barrier(guarded_gap(u)))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(stored(u), u, v) - loads(v)
    }

    /// ∫ (g − u_n + c), whose integrand has to stay positive at all points.
    pub fn guarded(u: Unknown<Vector>) -> Functional {
        integral(GammaC, guarded_gap(u))
    }

    /// The adjoint of the discrete problem. Its matrix is that of the tangent, which is symmetric.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// The volume form of the shape derivative of the criterion along Θ, with p of `discrete_adjoint`.
    pub fn shape_gradient(u: State<Vector>, p: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(criterion(u) + direct(u, p), shape, Theta)
    }

    /// dJ/dμ = ∂R/∂μ (u; p), with p of `discrete_adjoint`.
    pub fn by_mu(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), mu, 1)
    }

    /// ∫ p, the force on the obstacle.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, contact_pressure(u))
    }
}

parameter_ranges!(barrier_obstacle {
    positive: mu,
    positive: barrier_stiffness,
    positive: activation_gap,
    non_negative: clearance,
});

/// κ with which a barrier from ĝ on has this pressure at the gap ĝ/2 \[stress per length\].
pub fn stiffness(pressure: f64, activation_gap: f64) -> f64 {
    pressure / (activation_gap * (2.0_f64.ln() + 0.5))
}

/// The direct problem, whose steps keep all gaps positive and lower the energy. Its rule has the degree 2k + 2 for displacements of degree k;
/// gaps are kept positive at the rule's points.
///
/// # Errors
/// A parameter out of its range.
pub fn barrier_problem<'a, const D: usize>(
    model: &barrier_obstacle::Model<D>,
    space: &Arc<Space<D>>,
) -> Result<Problem<'a, D>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    Ok(guarded_problem(&form, &model.guarded(), space))
}

/// A problem whose steps keep a functional's integrand positive and lower the potential.
pub(super) fn guarded_problem<'a, const D: usize>(
    form: &Form<D>,
    guarded: &Functional<D>,
    space: &Arc<Space<D>>,
) -> Problem<'a, D> {
    let options = NewtonOptions {
        line_search: LineSearch::OnPotential,
        prescribed_values: PrescribedValues::ByTangent,
        max_iterations: 100,
        ..NewtonOptions::default()
    };
    let rule = Quadrature::Degree(2 * space.degree() + 2);
    Problem::new(form, space).quadrature(rule).options(options).keep_positive(guarded)
}
