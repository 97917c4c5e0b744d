//! Frictionless contact with a flat obstacle whose pressure is a function of the gap given by data points, small strains.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::tabulated_obstacle::*;

/// a(u,v) + ∫ p(g − u_n) v_n = ℓ(v), with the pressure p as a [`Table`](forms_fem::prelude::Table) of points \[gap, pressure\] with ascending gaps, as measured ones. Give
/// a last point with the pressure 0 and `.constant_outside()`; below the first gap the table's last slope goes on unless it is constant there, too.
/// A pressure that rises with the gap anywhere is unstable.
#[forms]
pub mod tabulated_obstacle {
    pub use super::super::barrier_obstacle::{GammaC, GammaN, Omega};
    pub use crate::operators::linear_criterion::criterion;
    use crate::operators::linear_elastic::stress;
    pub use crate::operators::loads::loads;
    use crate::operators::obstacle::{current_gap, normal_displacement};

    /// Data of the body, the obstacle and the law.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::flat_obstacle::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data
    )]
    pub struct Data {
        /// p, the pressure by the gap \[stress by length\].
        pub closure: Table,
    }

    /// p(g − u_n), the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        closure(current_gap(w))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - loads(v)
            + integral(GammaC, contact_pressure(u) * normal_displacement(v))
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// ∫ p, the force on the obstacle.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, contact_pressure(u))
    }
}

contact_law!(tabulated_obstacle {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    positive: mu,
    line_search: OnResidual,
});
