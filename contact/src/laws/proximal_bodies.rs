//! Frictionless contact of two bodies by proximal Galerkin, small strains and small sliding: a latent variable on the own surface keeps the gap
//! positive.

use forms_fem::forms;

use crate::parameter_ranges;

#[doc(inline)]
pub use self::proximal_bodies::*;

/// α (Σ a_i(u,v) − ℓ(v)) − ∫ (ψ − ψ_k) n_y·⟦v⟧ = 0 and ∫ (g − ⟦u⟧·n_y − e^ψ) w = 0 over one surface: the step k of the proximal point iteration of
/// two bodies, as [`proximal_obstacle`](super::proximal_obstacle)'s. The pressure is (ψ_k − ψ)/α.
///
/// ψ lives on the own surface, with the degree of u: `Space::on_facets(&mesh, own, k)` with `Pairing::onto(own, opposite)`.
#[forms]
pub mod proximal_bodies {
    use crate::operators::bodies::present_gap;
    use crate::operators::linear_elastic::stress;
    pub use crate::operators::loads::loads;

    /// Data of the bodies and the iteration. Materials may differ from cell to cell.
    #[includes(crate::operators::loads::Data)]
    pub struct Data {
        /// λ, first Lamé parameter \[stress\].
        pub lambda: Given<Scalar>,
        /// μ, shear modulus \[stress\].
        pub mu: Given<Scalar>,
        /// α, the step \[1 per stress\]. At the first step α times the pressure should not be far above 10.
        #[doc(alias = "α")]
        pub alpha: Param,
    }

    /// Ω, both bodies.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// The own surface and the one opposite to it.
    #[pairs]
    pub struct Touch;

    /// The problem of a step, with ψ_k of the last one.
    pub fn direct(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        psi_before: State<Scalar>,
    ) -> Form {
        alpha * (integral(Omega, inner(stress(u), eps(v))) - loads(v))
            - integral(
                Touch,
                this(psi - psi_before) * dot(toward, jump(v)) - (present_gap(u) - exp(this(psi))) * this(w),
            )
    }

    /// ½ Σ a_i(u, u).
    pub fn elastic_energy(u: State<Vector>) -> Functional {
        integral(Omega, inner(stress(u), eps(u)) / 2)
    }

    /// ∫ (ψ_k − ψ)/α, the force between the bodies.
    pub fn contact_force(psi: State<Scalar>, psi_before: State<Scalar>) -> Functional {
        integral(Touch, this(psi_before - psi) / alpha)
    }
}

parameter_ranges!(proximal_bodies { positive: mu, positive: alpha });
