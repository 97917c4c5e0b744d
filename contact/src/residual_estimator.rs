//! The residual estimator of contact by Nitsche's method (Chouly, Fabre, Hild, Pousin and Renard 2018), as linear forms with
//! a test function that is constant on cells: [`ErrorEstimate::residual`](forms_fem::adaptivity::ErrorEstimate::residual) takes them.
//!
//! η_T² = h²‖f + div σ‖² + h‖½⟦σn⟧‖² + h‖σn − g_N‖² on Γ_N + h‖σn − T‖² on Γ_C, with T the traction of the obstacle on the body. It
//! is \[stress² · length^D\]: η_T² divided by μ is an energy.

use forms_fem::forms;

/// Without friction: T = −\[σ_n − γ(u_n − g)\]₋ n_y, so that the last term is h‖σ_t‖² + h‖σ_n + \[σ_n − γ(u_n − g)\]₋‖².
#[forms]
pub mod frictionless {
    pub use crate::nitsche::Data;
    use crate::nitsche::{contact_pressure, stress};

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

/// A body that is cut from a mesh, without friction: Γ_C is the interface, and its parts that do not touch are free. Facets and cells are their
/// parts inside.
#[forms]
pub mod cut_frictionless {
    use super::frictionless::equilibrium;
    pub use super::frictionless::{GammaN, Interior, Omega};
    pub use crate::laws::cut_nitsche::{Data, GammaC};
    use crate::laws::cut_nitsche::{contact_pressure, stress};

    /// η_T².
    pub fn squared(u: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = stress(u) * n + contact_pressure(u) * obstacle_normal;
        equilibrium(u, q) + integral(GammaC, h * dot(rest, rest) * q)
    }
}

/// With friction on a flat: T = −\[P_n\]₋ n_y + Π_s(P_t). Where the body sticks T contains the slip, too.
#[forms]
pub mod frictional {
    use super::frictionless::equilibrium;
    pub use super::frictionless::{GammaC, GammaN, Interior, Omega};
    pub use crate::laws::frictional_nitsche::Data;
    use crate::laws::frictional_nitsche::{obstacle_traction, stress};

    /// η_T².
    pub fn squared(u: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = stress(u) * n - obstacle_traction(u);
        equilibrium(u, q) + integral(GammaC, h * dot(rest, rest) * q)
    }
}

/// Estimator of the consistent adjoint state (22) without N: η_T² = h²‖div σ(p) − F‖² + h‖½⟦σ(p)n⟧‖² + h‖σ(p)n‖² on Γ_N + h‖σ(p)n − T‖² on Γ_C, with
/// T = (σ_n(p) − γp_n) n_y where u is in contact and 0 elsewhere.
#[forms]
pub mod consistent_adjoint {
    pub use super::frictionless::{GammaC, GammaN, Interior, Omega};
    pub use crate::nitsche::Data;
    use crate::nitsche::{contact_indicator, normal_stress, stress};
    use crate::operators::obstacle::{gamma, normal_displacement};

    /// η_T².
    pub fn squared(u: State<Vector>, p: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = div(stress(p)) - criterion_force;
        let jumped = jump(stress(p)) * n;
        let free = stress(p) * n;
        let pressed = heaviside(contact_indicator(u)) * (normal_stress(p) - gamma() * normal_displacement(p));
        let touched = free - pressed * obstacle_normal;
        integral(Omega, sqr(h) * dot(rest, rest) * q)
            + integral(Interior, avg(h) * dot(jumped, jumped) / 2 * avg(q))
            + integral(GammaN, h * dot(free, free) * q)
            + integral(GammaC, h * dot(touched, touched) * q)
    }
}

/// The residual of (14) weighted with an adjoint state, part by part: what
/// [`ErrorEstimate::dual_weighted`](forms_fem::adaptivity::ErrorEstimate::dual_weighted) takes for a goal of contact.
#[forms]
pub mod dual_weighted {
    use crate::nitsche::direct;
    pub use crate::nitsche::{Data, GammaC, GammaN, Omega};

    /// R(u; q z).
    pub fn localised(u: State<Vector>, z: State<Vector>, q: Test<Scalar>) -> Form {
        direct(u, q * z)
    }
}

/// Estimator of two bodies by [`two_bodies`](crate::laws::two_bodies): η_T² = h²‖f + div σ‖² + h‖½⟦σn⟧‖² + h‖σn − g_N‖² on Γ_N + h‖σn − T‖² on
/// the surfaces that may touch, T with its friction from the pairs' own side and −T on the opposite one, each with the h of its cells.
/// Moduli are constant in each cell. Points without an opposite one belong to no term.
#[forms]
pub mod two_bodies {
    pub use crate::laws::two_bodies::{Data, GammaN, Omega, Touch};
    use crate::laws::two_bodies::{opposite_traction, stress};

    /// The facets between cells of one body.
    #[interior_facets]
    pub struct Interior;

    /// η_T².
    pub fn squared(u: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = body_force + div(stress(u));
        let jumped = jump(stress(u)) * n;
        let free = stress(u) * n - traction;
        let near = this(stress(u) * n) - opposite_traction(u);
        let far = other(stress(u) * n) + opposite_traction(u);
        integral(Omega, sqr(h) * dot(rest, rest) * q)
            + integral(Interior, avg(h) * dot(jumped, jumped) / 2 * avg(q))
            + integral(GammaN, h * dot(free, free) * q)
            + integral(
                Touch,
                share * (this(h) * dot(near, near) * this(q) + other(h) * dot(far, far) * other(q)),
            )
    }
}
