//! Motion with impact on a rigid obstacle, by Nitsche's method: contact at the time at which a scheme evaluates forces, and two
//! mid-point schemes that know the energy.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::material_threshold::{NitscheContact, Traction, material_threshold};
use crate::threshold::Threshold;

/// The γ₀ below which motion explodes: E₁ of θ = 1 is not positive then. A loop over time has no notes, so look at
/// [`Threshold::warning`] before it.
///
/// # Errors
/// Data that do not fit.
pub fn threshold<const D: usize>(
    model: &impact::Model<D>,
    assembler: &Assembler<D>,
    space: &Arc<Space<D>>,
) -> Result<Threshold, AssemblyError>
where
    Dim: Dimension<D>,
{
    let data = &model.data;
    let contact =
        NitscheContact::of_surface(&model.regions.gamma_c.0.name, [data.lambda, data.mu, data.gamma0]);
    let contact = NitscheContact { theta: data.theta, traction: Traction::Normal, ..contact };
    material_threshold(assembler, space, &contact)
}

/// A linear elastic body in frictionless impact. With β(w) = γ (w_n − g) − σ_n(w), which is −P_γ of the paper, the pressure is
///
/// - \[β\]₊ at the evaluated displacement in `motion`, for every implicit scheme and for central differences;
/// - Φ(β₀, β₁) of the two ends of a step in `hybrid` and `conserving`, which are for
///   [`GeneralisedAlpha::mid_point`](forms_fem::time::GeneralisedAlpha::mid_point). Their third argument is the displacement
///   before the step, `step.before.value`.
///
/// After Chouly, Hild & Renard (2015), A Nitsche finite element method for dynamic contact, parts 1 and 2, ESAIM: M2AN 49. For
/// θ = 1 `energy` is what the continuous equations keep. [`threshold`] says how large γ₀ has to be.
#[forms]
pub mod impact {
    use forms_fem::time::operators::vector::{acceleration, displacement};

    use crate::operators::linear_elastic::{energy_density, stress};
    use crate::operators::obstacle::{augmented_stress, gamma, nitsche_test, normal_component};

    #[includes(
        forms_fem::time::operators::vector::Data,
        crate::operators::linear_elastic::Data,
        crate::operators::obstacle::Data,
        crate::operators::body_load::Data
    )]
    pub struct Data {
        /// ρ, mass per volume: of all of the body, or without inertia at the nodes of Γ_C, as
        /// [`redistributed_mass`](forms_fem::time::redistributed_mass()) makes it.
        #[doc(alias = "ρ")]
        pub rho: Given<Scalar>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    fn normal_stress(w: Vector) -> Scalar {
        normal_component(stress(w))
    }

    /// β = γ (w_n − g) − σ_n(w): presses where it is positive.
    #[doc(alias = "β")]
    pub fn pressing(w: Vector) -> Scalar {
        -augmented_stress(normal_stress(w), w)
    }

    /// Φ of the hybrid scheme: \[(β₀ + β₁)/2\]₊ where the step begins in contact, else (\[β₀\]₊ + \[β₁\]₊)/2. Energy is never gained.
    pub fn hybrid_pressure(before: Scalar, after: Scalar) -> Scalar {
        if before > 0 { pos_part((before + after) / 2) } else { pos_part(after) / 2 }
    }

    /// Φ of the conserving scheme: (\[β₁\]₊² − \[β₀\]₊²)/(2 (β₁ − β₀)), the mean of \[·\]₊ between β₀ and β₁.
    pub fn conserving_pressure(before: Scalar, after: Scalar) -> Scalar {
        if min(before, after) >= 0 {
            (before + after) / 2
        } else if max(before, after) > 0 {
            sqr(max(before, after)) / (2 * abs(after - before))
        } else {
            0
        }
    }

    /// Inertia, elasticity and load at the evaluated state, with Nitsche's term of σ_n.
    fn body(u: Vector, v: Vector) -> Form {
        integral(Omega, rho * dot(acceleration(u), v) - dot(body_force, v))
            + integral(Omega, inner(stress(displacement(u)), eps(v)))
            - integral(GammaC, theta / gamma() * normal_stress(displacement(u)) * normal_stress(v))
    }

    /// The residual of a step with contact where the scheme evaluates forces.
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = pos_part(pressing(displacement(u)));
        body(u, v) - integral(GammaC, pressure / gamma() * nitsche_test(normal_stress(v), v))
    }

    /// The residual of a step of the hybrid scheme from the displacement `before`.
    pub fn hybrid(u: Unknown<Vector>, v: Test<Vector>, before: State<Vector>) -> Form {
        let pressure = hybrid_pressure(pressing(before), pressing(u));
        body(u, v) - integral(GammaC, pressure / gamma() * nitsche_test(normal_stress(v), v))
    }

    /// The residual of a step of the conserving scheme from the displacement `before`.
    pub fn conserving(u: Unknown<Vector>, v: Test<Vector>, before: State<Vector>) -> Form {
        let pressure = conserving_pressure(pressing(before), pressing(u));
        body(u, v) - integral(GammaC, pressure / gamma() * nitsche_test(normal_stress(v), v))
    }

    /// Kinetic and elastic energy with θ times Nitsche's terms, −σ_n²/2γ + \[β\]₊²/2γ.
    #[doc(alias = "E₁")]
    pub fn energy(u: State<Vector>, velocity: State<Vector>) -> Functional {
        integral(Omega, rho * dot(velocity, velocity) / 2 + energy_density(u))
            + integral(GammaC, theta * (sqr(pos_part(pressing(u))) - sqr(normal_stress(u))) / (2 * gamma()))
    }

    /// The force of the obstacle on the body, \[β\]₊ over Γ_C.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, pos_part(pressing(u)))
    }

    /// The mean force of a step of the hybrid scheme.
    pub fn hybrid_force(u: State<Vector>, before: State<Vector>) -> Functional {
        integral(GammaC, hybrid_pressure(pressing(before), pressing(u)))
    }

    /// The mean force of a step of the conserving scheme.
    pub fn conserving_force(u: State<Vector>, before: State<Vector>) -> Functional {
        integral(GammaC, conserving_pressure(pressing(before), pressing(u)))
    }
}
