//! Heat across the contact of two bodies: conduction by pressure, and the work of friction as a source.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::contact_heat::*;

/// Conduction in two bodies whose displacement u is known, ϑ the temperature:
///
/// ∫ k ∇ϑ·∇ϕ + Σ ½ ∫ { h_c(p) ⟦ϑ⟧ ⟦ϕ⟧ − D (r ϕ(X) + (1 − r) ϕ(Y)) } = ∫ f ϕ + ∫ q ϕ,
///
/// p the pressure of [`two_bodies`](super::two_bodies) at the displacement u, h_c = h₀ (p/H)^m after Cooper, Mikic and Yovanovich
/// (1969, m = 0.95) and zero where nothing presses, D = −T·s/Δt the power of friction for the slip s of the step. Each body takes
/// the part of its effusivity e = √(k ρ c), r = e(X)/(e(X) + e(Y)). What leaves one body enters the other in one integral, so that
/// heat balances at any quadrature.
///
/// It is linear in ϑ: [`heat_problem`] solves it, after each step of the mechanical law. γ₀ only enters p; its threshold is looked
/// at where u is solved for.
#[forms]
pub mod contact_heat {
    pub use super::super::two_bodies::{GammaN, Omega, Touch, contact_pressure, friction_traction};
    use crate::operators::friction::tangential;

    /// Data of bodies, contact and heat.
    #[includes(crate::laws::two_bodies::Data)]
    pub struct Data {
        /// k, conductivity \[power/(length temperature)\].
        #[doc(alias = "k")]
        pub conductivity: Given<Scalar>,
        /// e = √(k ρ c), effusivity; only the ratio of the two bodies' counts. A field that is discontinuous between them, for
        /// both are asked at one place.
        #[doc(alias = "e")]
        #[default(1)]
        pub effusivity: Given<Scalar>,
        /// h₀, conductance of the contact at the pressure H \[power/(area temperature)\].
        #[doc(alias = "h₀")]
        pub conductance: Param,
        /// H, hardness of the softer body \[stress\].
        #[doc(alias = "H")]
        pub hardness: Param,
        /// m.
        #[doc(alias = "m")]
        #[default(0.95)]
        pub exponent: Param,
        /// Δt, the duration of the step.
        #[doc(alias = "Δt")]
        #[default(1)]
        pub duration: Param,
        /// f, heat per volume and time.
        #[default(0)]
        pub heat_source: Given<Scalar>,
        /// q, heat per area and time that enters through Γ_N.
        #[default(0)]
        pub heat_flux: Given<Scalar>,
    }

    /// h_c(p), the conductance of the contact.
    #[doc(alias = "h_c")]
    pub fn contact_conductance(u: State<Vector>) -> Scalar {
        let p = contact_pressure(u);
        if p > 0 { conductance * pow(p / hardness, exponent) } else { 0 }
    }

    /// D = −T·s/Δt, the power of friction per area.
    #[doc(alias = "D")]
    pub fn friction_power(u: State<Vector>) -> Scalar {
        -dot(friction_traction(u), tangential(jump(u - displacement_before), toward)) / duration
    }

    /// r, the part of the heat of friction that the body of X takes.
    #[doc(alias = "r")]
    pub fn own_part() -> Scalar {
        this(effusivity) / (this(effusivity) + other(effusivity))
    }

    /// The heat problem at the displacement u.
    pub fn heat(temperature: Unknown<Scalar>, phi: Test<Scalar>, u: State<Vector>) -> Form {
        let across = contact_conductance(u) * jump(temperature) * jump(phi);
        let heated = own_part() * this(phi) + (1 - own_part()) * other(phi);
        integral(Omega, conductivity * dot(grad(temperature), grad(phi)) - heat_source * phi)
            - integral(GammaN, heat_flux * phi)
            + integral(Touch, share * (across - friction_power(u) * heated))
    }

    /// ∫ D: the power of friction on the whole contact.
    pub fn total_friction_power(u: State<Vector>) -> Functional {
        integral(Touch, share * friction_power(u))
    }

    /// The heat per time from the bodies of X to those opposite: bound to one surface, the flow across the contact.
    pub fn flow_across(temperature: State<Scalar>, u: State<Vector>) -> Functional {
        integral(Touch, contact_conductance(u) * jump(temperature))
    }
}

parameter_ranges!(contact_heat {
    positive: mu,
    positive: gamma0,
    positive: share,
    positive: conductivity,
    positive: effusivity,
    positive: hardness,
    positive: duration,
    non_negative: slip_stress,
    non_negative: friction,
    non_negative: conductance,
    non_negative: exponent,
});

/// The heat problem at a displacement, on the space of temperatures.
///
/// # Errors
/// A parameter out of its range.
pub fn heat_problem<'a, const D: usize>(
    model: &contact_heat::Model<D>,
    temperatures: &Arc<Space<D>>,
    displacement: &Field<D>,
) -> Result<Problem<'a, D>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let form = model.heat(displacement);
    model.check(form.name())?;
    Ok(Problem::new(&form, temperatures))
}
