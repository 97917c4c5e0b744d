//! Motion of rubber with impact and friction on a flat, at large displacements, by two mid-point schemes that know the energy.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::material_threshold::{NitscheContact, Traction, material_threshold};
use crate::threshold::Threshold;

/// The γ₀ below which E₁ of the undeformed body is not positive, so that motion explodes. A loop over time has no notes, so look at
/// [`Threshold::warning`] before it.
///
/// # Errors
/// Data that do not fit.
pub fn threshold(
    model: &finite_impact::Model<2>,
    assembler: &Assembler<2>,
    space: &Arc<Space<2>>,
) -> Result<Threshold, AssemblyError> {
    let data = &model.data;
    let contact =
        NitscheContact::of_surface(&model.regions.gamma_c.0.name, [data.lambda, data.mu, data.gamma0]);
    let contact = NitscheContact { theta: 1.0, traction: Traction::Normal, ..contact };
    material_threshold(assembler, space, &contact)
}

/// A plane neo-Hookean body that hits a rigid flat with Coulomb's friction, by Nitsche's method with θ = 1. The flat's normal n_y is constant, so the
/// gap is affine in u for any motion of the body.
///
/// The energy, with σ_n = n_y·P n and β(w) = γ (w_n − g) − σ_n(w), is
///
/// ```text
/// E₁ = ∫ ρ|u̇|²/2 + W(u) − f·u + ∫_Γ_C ([β]₊² − σ_n²)/2γ
/// ```
///
/// and each of its terms enters a step as the quotient of its differences ([`neo_hookean_secant`](crate::operators::neo_hookean_secant)),
/// the pressure Φ(β₀, β₁) as in [`impact`](crate::impact::impact): with `conserving` E₁ and the work that friction has taken stay
/// together what they were, with `hybrid` they never grow. Friction resists the slip Δu_t of a step by Π_κΦ(γ Δu_t), which takes energy
/// or none. Sticking points drift by force/γ per step. Both are for
/// [`GeneralisedAlpha::mid_point`](forms_fem::time::GeneralisedAlpha::mid_point), with the displacement before the step,
/// `step.before.value`, as third argument.
#[forms(dimension = 2)]
pub mod finite_impact {
    use forms_fem::time::operators::vector::acceleration;

    use crate::impact::impact::{conserving_pressure, hybrid_pressure};
    use crate::operators::friction::{ball_projection, tangential};
    use crate::operators::neo_hookean::{energy_density, first_piola};
    use crate::operators::neo_hookean_secant::{mean_stress, stress_secant};
    use crate::operators::obstacle::{augmented_stress, gamma, normal_component, normal_displacement};

    #[includes(
        forms_fem::time::operators::vector::Data,
        crate::operators::linear_elastic::Data,
        crate::operators::penalty::Data,
        crate::operators::body_load::Data
    )]
    pub struct Data {
        /// ρ, mass per volume.
        #[doc(alias = "ρ")]
        pub rho: Param,
        /// n_y, unit normal pointing into the flat; the same everywhere.
        pub obstacle_normal: Given<Vector>,
        /// g, the gap of the undeformed body \[length\].
        pub gap: Given<Scalar>,
        /// κ, the coefficient of friction.
        #[doc(alias = "κ")]
        #[default(0)]
        pub friction: Param,
        /// e, the direction of `…_force` and `momentum`.
        #[default(0)]
        pub direction: Given<Vector>,
        /// The point of `spin` and `inertia` \[length\].
        #[default(0)]
        pub centre: Given<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    fn normal_stress(w: Vector) -> Scalar {
        normal_component(first_piola(w))
    }

    /// β = γ (w_n − g) − σ_n(w): presses where it is positive.
    #[doc(alias = "β")]
    pub fn pressing(w: Vector) -> Scalar {
        -augmented_stress(normal_stress(w), w)
    }

    /// Π_κΦ(γ Δu_t), the resistance to the slip of a step under the pressure Φ.
    fn resistance(u: Vector, before: Vector, pressure: Scalar) -> Vector {
        ball_projection(gamma() * tangential(u - before, obstacle_normal), friction * pressure)
    }

    /// The residual of a step without the pressure's part.
    fn body(u: Vector, v: Vector, before: Vector) -> Form {
        let mean = (normal_stress(before) + normal_stress(u)) / 2;
        integral(Omega, rho * dot(acceleration(u), v) - dot(body_force, v))
            + integral(Omega, inner(mean_stress(before, u), grad(v)))
            - integral(GammaC, mean / gamma() * normal_component(stress_secant(before, u, grad(v))))
    }

    /// The part of the flat, which presses by Φ.
    fn flat(u: Vector, v: Vector, before: Vector, pressure: Scalar) -> Form {
        let of_test = normal_component(stress_secant(before, u, grad(v)));
        integral(GammaC, pressure * (normal_displacement(v) - of_test / gamma()))
            + integral(GammaC, dot(resistance(u, before, pressure), v))
    }

    /// The residual of a step of the conserving scheme from the displacement `before`.
    pub fn conserving(u: Unknown<Vector>, v: Test<Vector>, before: State<Vector>) -> Form {
        body(u, v, before) + flat(u, v, before, conserving_pressure(pressing(before), pressing(u)))
    }

    /// The residual of a step of the hybrid scheme from the displacement `before`.
    pub fn hybrid(u: Unknown<Vector>, v: Test<Vector>, before: State<Vector>) -> Form {
        body(u, v, before) + flat(u, v, before, hybrid_pressure(pressing(before), pressing(u)))
    }

    /// E₁.
    #[doc(alias = "E₁")]
    pub fn energy(u: State<Vector>, velocity: State<Vector>) -> Functional {
        integral(Omega, rho * dot(velocity, velocity) / 2 + energy_density(u) - dot(body_force, u))
            + integral(GammaC, (sqr(pos_part(pressing(u))) - sqr(normal_stress(u))) / (2 * gamma()))
    }

    /// e·∫ of the flat's mean traction on the body in a step of the conserving scheme.
    pub fn conserving_force(u: State<Vector>, before: State<Vector>) -> Functional {
        let pressure = conserving_pressure(pressing(before), pressing(u));
        -integral(GammaC, dot(pressure * obstacle_normal + resistance(u, before, pressure), direction))
    }

    /// The work that friction takes in a step of the conserving scheme.
    pub fn conserving_loss(u: State<Vector>, before: State<Vector>) -> Functional {
        let pressure = conserving_pressure(pressing(before), pressing(u));
        integral(GammaC, dot(resistance(u, before, pressure), u - before))
    }

    /// e·∫ of the flat's mean traction on the body in a step of the hybrid scheme.
    pub fn hybrid_force(u: State<Vector>, before: State<Vector>) -> Functional {
        let pressure = hybrid_pressure(pressing(before), pressing(u));
        -integral(GammaC, dot(pressure * obstacle_normal + resistance(u, before, pressure), direction))
    }

    /// The work that friction takes in a step of the hybrid scheme.
    pub fn hybrid_loss(u: State<Vector>, before: State<Vector>) -> Functional {
        let pressure = hybrid_pressure(pressing(before), pressing(u));
        integral(GammaC, dot(resistance(u, before, pressure), u - before))
    }

    /// e·∫ ρ w: of the velocity the momentum along e, of the displacement the mass times the way of its centre.
    pub fn momentum(w: State<Vector>) -> Functional {
        integral(Omega, rho * dot(direction, w))
    }

    /// ∫ ρ (x + u − c) × u̇, the angular momentum about the centre c.
    pub fn spin(u: State<Vector>, velocity: State<Vector>) -> Functional {
        let r = x + u - centre;
        integral(Omega, rho * (r[0] * velocity[1] - r[1] * velocity[0]))
    }

    /// ∫ ρ |x + u − c|², the moment of inertia about the centre c.
    pub fn inertia(u: State<Vector>) -> Functional {
        integral(Omega, rho * dot(x + u - centre, x + u - centre))
    }
}
