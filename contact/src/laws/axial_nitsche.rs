//! Contact with friction on a flat obstacle by Nitsche's method, bodies of revolution in the (r, z) plane, small strains.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::law::{ContactLaw, WithAdjoint};
use crate::parameter_ranges;

#[doc(inline)]
pub use self::axial_nitsche::*;

/// [`frictional_nitsche`](super::frictional_nitsche) with axial symmetry: x = (r, z), all integrals with the weight 2π r, so that forces and energies are those of the
/// whole body. Loads are per volume and per area of it. Hold the displacement along r on the axis.
#[forms(dimension = 2)]
pub mod axial_nitsche {
    pub use crate::operators::axial::{
        circumference, hoop_strain, hoop_stress, internal_work, meridian_stress,
    };
    use crate::operators::friction::{augmented_traction, contact_traction, slip_limit};
    use crate::operators::obstacle::{current_gap, gamma};

    /// Data of the body, the obstacle and friction.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::obstacle::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data,
        crate::operators::friction::Data
    )]
    pub struct Data {}

    /// The body's half of its section.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    fn augmented(w: Vector) -> Vector {
        let force = meridian_stress(w) * n;
        augmented_traction(force, current_gap(w), w - displacement_before, gamma(), obstacle_normal)
    }

    /// \[P_n\]₋, the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(augmented(w), obstacle_normal))
    }

    /// T(u), the traction of the obstacle on the body.
    pub fn obstacle_traction(w: Vector) -> Vector {
        contact_traction(augmented(w), slip_limit(contact_pressure(w)), obstacle_normal)
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let of_test = meridian_stress(v) * n;
        let consistent = theta / gamma() * dot(obstacle_traction(u) - meridian_stress(u) * n, of_test);
        integral(Omega, internal_work(u, v) - circumference() * dot(body_force, v))
            - integral(GammaN, circumference() * dot(traction, v))
            + integral(GammaC, circumference() * (consistent - dot(obstacle_traction(u), v)))
    }

    /// J = ∫ F·u over the body.
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, circumference() * dot(criterion_force, u))
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dμ = ∂R/∂μ (u; p), with p of `discrete_adjoint`.
    pub fn by_mu(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), mu, 1)
    }

    /// ½ a(u, u).
    pub fn elastic_energy(u: State<Vector>) -> Functional {
        integral(Omega, internal_work(u, u) / 2)
    }

    /// ∫ p over the body's surface, the force on the obstacle.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, circumference() * contact_pressure(u))
    }
}

parameter_ranges!(axial_nitsche {
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    unit: obstacle_normal,
});

// `contact_law!` writes laws for both dimensions.
impl ContactLaw<2> for axial_nitsche::Model<2> {
    fn direct(&self) -> Form<2> {
        axial_nitsche::Model::direct(self)
    }

    fn contact_region(&self) -> &str {
        &self.regions.gamma_c.0.name
    }

    fn line_search(&self) -> LineSearch {
        LineSearch::OnResidual
    }
}

impl WithAdjoint<2> for axial_nitsche::Model<2> {
    fn criterion(&self, u: &Field<2>) -> Functional<2> {
        axial_nitsche::Model::criterion(self, u)
    }

    fn adjoint(&self, u: &Field<2>) -> Form<2> {
        self.discrete_adjoint(u)
    }
}
