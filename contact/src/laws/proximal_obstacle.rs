//! Frictionless contact with a flat obstacle by proximal Galerkin, small strains: a latent variable on the contact boundary keeps the
//! gap positive.

use forms_fem::forms;

use crate::parameter_ranges;

#[doc(inline)]
pub use self::proximal_obstacle::*;

/// α (a(u,v) − ℓ(v)) − ∫ (ψ − ψ_k) v_n = 0 and ∫ (g − u_n − e^ψ) w = 0 over Γ_C, with v_n = v·n_y: the step k of the proximal point iteration
/// of Signorini's problem (Dokken, Farrell, Keith, Papadopoulos and Surowiec 2025). [`solve_by_proximal_points`](crate::proximal::solve_by_proximal_points) repeats it. The
/// pressure is (ψ_k − ψ)/α.
///
/// ψ lives on Γ_C, with the degree of u: `Space::on_facets(&mesh, "contact", k)`. u itself may enter the obstacle a little between nodes.
#[forms]
pub mod proximal_obstacle {
    use crate::operators::linear_elastic::stress;
    pub use crate::operators::loads::loads;
    use crate::operators::obstacle::{current_gap, normal_displacement};

    /// Data of the body, the obstacle and the iteration.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::flat_obstacle::Data,
        crate::operators::loads::Data
    )]
    pub struct Data {
        /// α, the step \[1 per stress\]. At the first step α times the pressure should not be far above 10.
        #[doc(alias = "α")]
        pub alpha: Param,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    /// The problem of a step, with ψ_k of the last one.
    pub fn direct(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        psi_before: State<Scalar>,
    ) -> Form {
        alpha * (integral(Omega, inner(stress(u), eps(v))) - loads(v))
            - integral(GammaC, (psi - psi_before) * normal_displacement(v) - (current_gap(u) - exp(psi)) * w)
    }

    /// ½ a(u, u).
    pub fn elastic_energy(u: State<Vector>) -> Functional {
        integral(Omega, inner(stress(u), eps(u)) / 2)
    }

    /// ∫ (ψ_k − ψ)/α, the force on the obstacle.
    pub fn contact_force(psi: State<Scalar>, psi_before: State<Scalar>) -> Functional {
        integral(GammaC, (psi_before - psi) / alpha)
    }
}

parameter_ranges!(proximal_obstacle { positive: mu, positive: alpha });
