//! The residual estimator of contact by Nitsche's method (Chouly, Fabre, Hild, Pousin and Renard 2018), as linear forms with
//! a test function that is constant on cells: [`ErrorEstimate::residual`](forms_fem::adaptivity::ErrorEstimate::residual) takes them.
//!
//! η_T² = h²‖f + div σ‖² + h‖½⟦σn⟧‖² + h‖σn − g_N‖² on Γ_N + h‖σn − T‖² on Γ_C, with T the traction of the obstacle on the body. It
//! is \[stress² · length^D\]: η_T² divided by μ is an energy.

use forms_fem::forms;

/// Without friction: T = −\[σ_n − γ(u_n − g)\]₋ n_y, so that the last term is h‖σ_t‖² + h‖σ_n + \[σ_n − γ(u_n − g)\]₋‖².
#[forms]
pub mod frictionless {
    pub use crate::nitsche::nitsche::Data;
    use crate::nitsche::nitsche::{contact_pressure, stress};

    /// Ω.
    #[cells]
    pub struct Omega;
    /// The facets between cells.
    #[interior_facets]
    pub struct Interior;
    /// Γ_N, the loaded boundary. What is free belongs to it, with g_N = 0.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    /// h²‖f + div σ‖² + h‖½⟦σn⟧‖² + h‖σn − g_N‖².
    pub fn equilibrium(u: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = body_force + div(stress(u));
        let jumped = jump(stress(u)) * n;
        let free = stress(u) * n - traction;
        integral(Omega, sqr(h) * dot(rest, rest) * q)
            + integral(Interior, avg(h) * dot(jumped, jumped) / 2 * avg(q))
            + integral(GammaN, h * dot(free, free) * q)
    }

    /// η_T².
    pub fn squared(u: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = stress(u) * n + contact_pressure(u) * obstacle_normal;
        equilibrium(u, q) + integral(GammaC, h * dot(rest, rest) * q)
    }
}

/// With friction on a flat: T = −\[P_n\]₋ n_y + Π_s(P_t). Where the body sticks the slip stands in T, too.
#[forms]
pub mod frictional {
    use super::frictionless::equilibrium;
    pub use super::frictionless::{GammaC, GammaN, Interior, Omega};
    pub use crate::laws::frictional_nitsche::frictional_nitsche::Data;
    use crate::laws::frictional_nitsche::frictional_nitsche::{obstacle_traction, stress};

    /// η_T².
    pub fn squared(u: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = stress(u) * n - obstacle_traction(u);
        equilibrium(u, q) + integral(GammaC, h * dot(rest, rest) * q)
    }
}
