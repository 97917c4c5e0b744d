//! Frictionless contact with a flat obstacle whose pressure falls exponentially with the gap, small strains.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::exponential_obstacle::*;

/// The minimum of ½ a(u,u) − ℓ(u) + ∫ p₀ c exp(−(g − u_n)/c), the energy of a surface with the pressure p₀ exp(−g/c): smooth, without an active set.
/// Surfaces may overlap: a pressure p belongs to the gap c ln(p₀/p).
#[forms]
pub mod exponential_obstacle {
    pub use super::super::barrier_obstacle::{GammaC, GammaN, Omega};
    use crate::operators::exponential_closure::{exponential_energy, exponential_pressure};
    pub use crate::operators::linear_criterion::criterion;
    use crate::operators::linear_elastic::energy_density;
    pub use crate::operators::loads::loads;
    use crate::operators::obstacle::current_gap;

    /// Data of the body, the obstacle and the law.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::exponential_closure::Data,
        crate::operators::flat_obstacle::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data
    )]
    pub struct Data {}

    /// p₀ exp(−(g − u_n)/c), the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        exponential_pressure(current_gap(w))
    }

    /// The energy without loads.
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u)) + integral(GammaC, exponential_energy(current_gap(u)))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(stored(u), u, v) - loads(v)
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dc = ∂R/∂c (u; p), with p of `discrete_adjoint`.
    pub fn by_closure_length(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), closure_length, 1)
    }

    /// ∫ p, the force on the obstacle.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, contact_pressure(u))
    }
}

contact_law!(exponential_obstacle {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    positive: mu,
    positive: closed_pressure,
    positive: closure_length,
    line_search: OnPotential,
});
