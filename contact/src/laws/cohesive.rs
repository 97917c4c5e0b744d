//! Cohesion between two bodies: a traction that falls as they separate, small strains, at pairs of fixed points.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::law::{ContactLaw, WithAdjoint};
use crate::material_threshold::{NitscheContact, Traction, material_threshold};
use crate::parameter_ranges::{ParameterRanges, Range};
use crate::threshold::Threshold;

#[doc(inline)]
pub use self::cohesive::*;

/// Bodies that are glued together by a bilinear law of traction and separation (after Camacho and Ortiz 1996, Alfano and
/// Crisfield 2001). With Δ = u(Y) − u(X), Δ_n = Δ·n_y and the effective opening δ = √(\[Δ_n\]₊² + β² |Δ_t|²),
///
/// T = k(κ) (\[Δ_n\]₊ n_y + β² Δ_t) − \[P_n\]₋ n_y,  κ = max(largest δ of all steps before, δ),  P_n = σ_n + γ g,
///
/// Σ a_i(u,v) − Σ ½ ∫ T·⟦v⟧ = ℓ(v) over both surfaces. Along the way of largest openings the traction k(κ) κ rises with the
/// stiffness K to the strength σ_c at δ₀ = σ_c/K and falls to zero at δ_f = 2 G_c/σ_c, so that G_c is lost per area; it unloads
/// to the origin. What closes touches without friction by Nitsche's method with θ = 0.
///
/// The largest opening is a [`History`] of the pairing, made by [`Assembler::history_on_pairs`]; after a step
/// `assembler.update_history(&model.opening_after(&u), &model.data.largest_opening)` and `commit()`. Where the bodies' stiffness
/// is less than the slope of the softening, separation jumps, and no small load step follows it.
#[forms]
pub mod cohesive {
    pub use super::super::two_bodies::{GammaN, Omega, Touch};
    use crate::operators::bodies::{own_gamma, own_traction, present_gap};
    use crate::operators::cohesion::{
        bilinear_dissipation, bilinear_stiffness, opening, separation_traction,
    };
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::linear_elastic::stress;
    use crate::operators::loads::loads;

    /// Data of bodies and glue.
    #[includes(
        crate::operators::bodies::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data
    )]
    pub struct Data {
        /// K, stiffness before damage \[stress/length\]; above σ_c²/(2 G_c).
        #[doc(alias = "K")]
        pub stiffness: Param,
        /// σ_c, the largest traction \[stress\].
        #[doc(alias = "σ_c")]
        pub strength: Param,
        /// G_c, the energy that separation takes per area.
        #[doc(alias = "G_c")]
        pub fracture_energy: Param,
        /// β, the weight of sliding relative to opening.
        #[doc(alias = "β")]
        #[default(1)]
        pub shear_weight: Param,
        /// The largest effective opening of all steps before \[length\].
        pub largest_opening: History<Scalar>,
    }

    /// δ(u), the effective opening.
    #[doc(alias = "δ")]
    pub fn effective_opening(w: Vector) -> Scalar {
        opening(-jump(w), toward, shear_weight)
    }

    /// κ(u), the largest effective opening so far: the history's value after a step.
    #[doc(alias = "κ")]
    pub fn opening_after(w: Vector) -> Scalar {
        max(this(largest_opening), effective_opening(w))
    }

    /// The traction of the glue on the body of X.
    pub fn cohesive_traction(w: Vector) -> Vector {
        let k = bilinear_stiffness(opening_after(w), stiffness, strength, fracture_energy);
        separation_traction(-jump(w), toward, shear_weight, k)
    }

    /// \[P_n\]₋, the pressure where the bodies touch.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(own_traction(w), toward) + own_gamma() * present_gap(w))
    }

    /// T(u), the traction of glue and contact on the body of X.
    pub fn opposite_traction(w: Vector) -> Vector {
        cohesive_traction(w) - contact_pressure(w) * toward
    }

    /// The direct problem of a step.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            - loads(v)
            - integral(Touch, share * dot(opposite_traction(u), jump(v)))
    }

    /// The adjoint of the discrete problem of one step, with a fixed history.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dσ_c = ∂R/∂σ_c (u; p) for one step, with p of `discrete_adjoint`.
    pub fn by_strength(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), strength, 1)
    }

    /// The energy that separation has taken up to now, by the largest openings that are committed.
    pub fn dissipated_energy() -> Functional {
        integral(
            Touch,
            share * bilinear_dissipation(this(largest_opening), stiffness, strength, fracture_energy),
        )
    }
}

impl<const D: usize> ParameterRanges for cohesive::Model<D>
where
    Dim: Dimension<D>,
{
    fn check(&self, form: &'static str) -> Result<(), AssemblyError> {
        let data = &self.data;
        Range::Positive.check(form, "mu", &data.mu)?;
        Range::Positive.check(form, "gamma0", &data.gamma0)?;
        Range::Positive.check(form, "share", &data.share)?;
        Range::Positive.check(form, "strength", &data.strength)?;
        Range::Positive.check(form, "fracture_energy", &data.fracture_energy)?;
        Range::NonNegative.check(form, "shear_weight", &data.shear_weight)?;
        // The stiffness at which the line of softening would be upright.
        if data.stiffness <= data.strength * data.strength / (2.0 * data.fracture_energy) {
            let (parameter, value) = ("stiffness", data.stiffness);
            let range = "above strength²/(2 fracture_energy)";
            return Err(AssemblyError::ParameterRange { form, parameter, value, range });
        }
        Ok(())
    }
}

impl<const D: usize> ContactLaw<D> for cohesive::Model<D>
where
    Dim: Dimension<D>,
{
    fn direct(&self) -> Form<D> {
        cohesive::Model::direct(self)
    }

    fn contact_region(&self) -> &str {
        &self.regions.touch.0.name
    }

    fn line_search(&self) -> LineSearch {
        LineSearch::OnResidual
    }

    /// That of what closes; softening of the glue makes no law monotone.
    fn threshold(
        &self,
        assembler: &Assembler<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Option<Threshold>, AssemblyError> {
        let data = &self.data;
        let materials = [&data.lambda, &data.mu, &data.gamma0];
        let contact = NitscheContact::of_pairs(&self.regions.touch.0, materials, data.share);
        let contact = NitscheContact { traction: Traction::Normal, ..contact };
        material_threshold(assembler, space, &contact).map(Some)
    }
}

impl<const D: usize> WithAdjoint<D> for cohesive::Model<D>
where
    Dim: Dimension<D>,
{
    fn criterion(&self, u: &Field<D>) -> Functional<D> {
        cohesive::Model::criterion(self, u)
    }

    fn adjoint(&self, u: &Field<D>) -> Form<D> {
        cohesive::Model::discrete_adjoint(self, u)
    }
}
