//! A membrane over an obstacle by proximal Galerkin: a latent variable keeps the gap positive.

use forms_fem::forms;

use crate::parameter_ranges;

#[doc(inline)]
pub use self::proximal_membrane::*;

/// α ((T ∇u, ∇v) − (f, v)) + (ψ − ψ_k, v) = 0 and (u − φ − e^ψ, w) = 0: the step k of the proximal point iteration of a membrane above an obstacle φ
/// (Keith and Surowiec 2024). [`solve_by_proximal_points`](crate::proximal::solve_by_proximal_points) repeats it. The force per area on the
/// obstacle is (ψ_k − ψ)/α.
///
/// A stable pair of spaces is u of degree p + 1 with ψ of degree p − 1 cell by cell, `Space::of(&mesh, Elements::Lagrange(p - 1), Scope::Cell, &[])`, which is
/// eliminated; or both of one degree.
#[forms]
pub mod proximal_membrane {
    /// Data of the membrane and the iteration.
    pub struct Data {
        /// T, tension \[force per length\].
        #[default(1)]
        pub tension: Given<Scalar>,
        /// f, force per area.
        #[default(0)]
        pub load: Given<Scalar>,
        /// φ, height of the obstacle \[length\].
        #[doc(alias = "φ")]
        pub obstacle: Given<Scalar>,
        /// α, the step \[1 per force per area\].
        #[doc(alias = "α")]
        pub alpha: Param,
    }

    /// The membrane.
    #[cells]
    pub struct Omega;

    /// The problem of a step, with ψ_k of the last one.
    pub fn direct(
        u: Unknown<Scalar>,
        psi: Unknown<Scalar>,
        v: Test<Scalar>,
        w: Test<Scalar>,
        psi_before: State<Scalar>,
    ) -> Form {
        integral(
            Omega,
            alpha * (tension * dot(grad(u), grad(v)) - load * v)
                + (psi - psi_before) * v
                + (u - obstacle - exp(psi)) * w,
        )
    }

    /// ½ ∫ T |∇u|² − ∫ f u.
    pub fn energy(u: State<Scalar>) -> Functional {
        integral(Omega, tension * dot(grad(u), grad(u)) / 2 - load * u)
    }

    /// ∫ (ψ_k − ψ)/α, the force on the obstacle.
    pub fn contact_force(psi: State<Scalar>, psi_before: State<Scalar>) -> Functional {
        integral(Omega, (psi_before - psi) / alpha)
    }
}

parameter_ranges!(proximal_membrane { positive: alpha, positive: tension });
