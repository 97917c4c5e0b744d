//! Frictionless contact of two bodies by a log barrier, small strains and small sliding: gaps stay positive.

use forms_fem::forms;
use forms_fem::prelude::*;

use super::barrier_obstacle::guarded_problem;
use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::barrier_bodies::*;

/// The minimum of Σ ½ a_i(u,u) − ℓ(u) + κ Σ D ∫ b(g − ⟦u⟧·n_y + c) over the surfaces of the pairs, with b of
/// [`barrier`](fn@crate::operators::barrier::barrier) and the share D. The remarks on [`barrier_obstacle`](super::barrier_obstacle) hold here, too. The force acts on
/// X and its opposite on Y, so that forces balance at any quadrature.
#[forms]
pub mod barrier_bodies {
    use crate::operators::barrier::{barrier, barrier_pressure};
    use crate::operators::bodies::present_gap;
    pub use crate::operators::linear_criterion::criterion;
    use crate::operators::linear_elastic::energy_density;
    pub use crate::operators::loads::loads;

    /// Data of the bodies and the barrier. Materials may differ from cell to cell.
    #[includes(
        crate::operators::barrier::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data
    )]
    pub struct Data {
        /// λ, first Lamé parameter \[stress\].
        pub lambda: Given<Scalar>,
        /// μ, shear modulus \[stress\].
        pub mu: Given<Scalar>,
        /// Part of each surface's integral: ½ where both surfaces are integrated over, 1 where one of them is.
        #[default(0.5)]
        pub share: Param,
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

    /// g − ⟦u⟧·n_y + c, which the barrier keeps positive.
    pub fn guarded_gap(w: Vector) -> Scalar {
        present_gap(w) + clearance
    }

    /// −κ b′, the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        barrier_pressure(guarded_gap(w))
    }

    /// ½ a(u,u) + κ Σ D ∫ b, the energy without loads.
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u))
            + integral(Touch, share * barrier_stiffness * barrier(guarded_gap(u)))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(stored(u), u, v) - loads(v)
    }

    /// ∫ (g − ⟦u⟧·n_y + c), whose integrand has to stay positive at all points.
    pub fn guarded(u: Unknown<Vector>) -> Functional {
        integral(Touch, guarded_gap(u))
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// ∫ D p over the surfaces of the pairs, the force between the bodies.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(Touch, share * contact_pressure(u))
    }
}

parameter_ranges!(barrier_bodies {
    positive: mu,
    positive: barrier_stiffness,
    positive: activation_gap,
    positive: share,
    non_negative: clearance,
});

/// The direct problem, as [`barrier_problem`](super::barrier_obstacle::barrier_problem).
///
/// # Errors
/// A parameter out of its range.
pub fn barrier_bodies_problem<'a, const D: usize>(
    model: &barrier_bodies::Model<D>,
    space: &Arc<Space<D>>,
) -> Result<Problem<'a, D>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    Ok(guarded_problem(&form, &model.guarded(), space))
}
