//! A body that is cut from a mesh by a level set function, in frictionless contact with a rigid obstacle, by Nitsche's method on its
//! boundary inside cells.

use forms_contact_problem::law::ContactLaw;
use forms_contact_problem::parameter_ranges::{ParameterRanges, Range};
use forms_fem::forms;
use forms_fem::prelude::*;

#[doc(inline)]
pub use self::cut_nitsche::*;

/// The forms of [`nitsche`](crate::nitsche) on an interface, for an assembler that is cut by a level set function
/// ([`Assembler::cut_by`]):
///
/// a(u,v) + (2μ + λ) s(u,v) − ∫_Γ (θ/γ) σ_n(u) σ_n(v) − ∫_Γ (1/γ) \[σ_n(u) − γ(u_n − g)\]₋ (θ σ_n(v) − γ v_n) = ℓ(v)
///
/// with the ghost penalty s on the facets "ghost" and γ = γ₀/h_T of the whole cell. `dirichlet` prescribes displacements on a part of the
/// interface; it is added to `direct`. Ranges of γ₀ are those of fitted meshes (10 k² (2μ + λ) for θ = 1), because of s.
///
/// `GammaC` and `GammaD` are regions of cells, and mean the interface in them. Loads act on what is inside, and on exterior facets.
#[forms(level_set_derivatives)]
pub mod cut_nitsche {
    use crate::operators::ghost_penalty::{vector_ghost, vector_ghost_of_slopes};
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::linear_elastic::{stress, von_mises};
    use crate::operators::loads::loads;
    pub use crate::operators::obstacle::{current_gap, normal_displacement, penetration};
    use crate::operators::obstacle::{
        gamma, nitsche_density, nitsche_pressure, nitsche_test, normal_component,
    };
    use crate::operators::weak_dirichlet::dirichlet_density;

    /// Data of all forms.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::obstacle::Data,
        crate::operators::loads::Data,
        crate::operators::linear_criterion::Data,
        crate::operators::ghost_penalty::Data
    )]
    pub struct Data {
        /// u_D, the displacement of the interface on `GammaD` \[length\].
        #[doc(alias = "u_D")]
        #[default(0)]
        pub prescribed: Given<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded exterior facets.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the cells in which the interface may touch the obstacle.
    #[interface]
    pub struct GammaC;
    /// Γ_D, the cells in which the interface is held.
    #[interface]
    pub struct GammaD;
    /// The facets of the ghost penalty.
    #[interior_facets]
    pub struct Ghost;

    /// σ_n(w) = (σ(w) n)·n_y.
    #[doc(alias = "σ_n")]
    pub fn normal_stress(w: Vector) -> Scalar {
        normal_component(stress(w))
    }

    /// \[σ_n(w) − γ (w_n − g)\]₋: the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        nitsche_pressure(normal_stress(w), w)
    }

    /// a(u, v).
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }

    /// (2μ + λ) s(u, v), for degrees 1 and 2.
    pub fn stabilisation(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Ghost, (2 * mu + lambda) * vector_ghost(u, v))
    }

    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) + stabilisation(u, v) - loads(v)
            + integral(GammaC, nitsche_density(normal_stress(u), u, normal_stress(v), v))
    }

    /// The direct problem without contact.
    pub fn without_contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) + stabilisation(u, v) - loads(v)
    }

    /// u = u_D on Γ_D.
    pub fn dirichlet(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaD, dirichlet_density(stress(u) * n, u, stress(v) * n, v))
    }

    /// The adjoint of the discrete problem (21).
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// The consistent adjoint (22), for criteria of the displacement in cells.
    pub fn consistent_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        let pressed = heaviside(gamma() * penetration(u) - normal_stress(u));
        elasticity(p, q) + stabilisation(p, q)
            - integral(GammaC, theta / gamma() * normal_stress(p) * normal_stress(q))
            + integral(
                GammaC,
                pressed / gamma()
                    * (normal_stress(p) - gamma() * normal_displacement(p))
                    * nitsche_test(normal_stress(q), q),
            )
            + derivative(criterion(u), u, q)
    }

    /// The criterion times t, for its derivative by the level set function.
    pub fn weighted_criterion(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, dot(criterion_force, u) * t)
    }

    /// ∫ \[σ_n(u) − γ(u_n − g)\]₋: the resultant of the contact pressure.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(GammaC, contact_pressure(u))
    }

    /// ∫_Γ \[σ_n(u) − γ(u_n − g)\]₋ t: with t of degree 0 the contact force in each cell.
    pub fn contact_forces(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(GammaC, contact_pressure(u) * t)
    }

    /// The measure of the discrete contact zone.
    pub fn contact_length(u: State<Vector>) -> Functional {
        integral(GammaC, heaviside(contact_pressure(u)))
    }
}

/// The regions with the facets "ghost" of the cut, and all other defaults.
pub fn regions() -> Regions {
    Regions::default().ghost("ghost")
}

impl<const D: usize> ContactLaw<D> for cut_nitsche::Model<D>
where
    Dim: Dimension<D>,
{
    fn direct(&self) -> Form<D> {
        cut_nitsche::Model::direct(self)
    }

    fn contact_region(&self) -> &str {
        &self.regions.gamma_c.0.name
    }
}

impl<const D: usize> cut_nitsche::Model<D>
where
    Dim: Dimension<D>,
{
    /// dJ/dφ of the criterion at a solution u of `direct`, with p of `discrete_adjoint`: one entry per node of the level set function's space.
    /// It is that of what is assembled, points and weights included, as long as no node changes sides. Functions of position among the
    /// data need gradients.
    ///
    /// # Errors
    /// Those of [`Assembler::derivative_by_level_set`].
    pub fn level_set_gradient(
        &self,
        assembler: &Assembler<D>,
        u: &Field<D>,
        p: &Field<D>,
    ) -> Result<Vec<f64>, AssemblyError> {
        let form = self.weighted_criterion(u);
        let refused = |_| AssemblyError::NoLevelSetDerivative { form: form.name() };
        let constants = Space::discontinuous_scalar(assembler.mesh(), 0).map_err(refused)?;
        let one = Field::of_known(&constants, vec![1.0; constants.unknowns()]);
        let own = assembler.derivative_by_level_set(&form, &[], &[&one])?;
        let by_state = assembler.derivative_by_level_set(&self.direct(), &[u], &[p])?;
        Ok(own.iter().zip(by_state).map(|(own, by_state)| own + by_state).collect())
    }
}

/// Small cuts make the discrete problem unstable for θ > 0 unless the ghost penalty acts: Newton's method may still converge, to something else.
impl<const D: usize> ParameterRanges for cut_nitsche::Model<D>
where
    Dim: Dimension<D>,
{
    fn check(&self, form: &'static str) -> Result<(), AssemblyError> {
        let Data { gamma0, theta, ghost_slopes, ghost_bends, .. } = &self.data;
        Range::Positive.check(form, "gamma0", gamma0)?;
        Range::NonNegative.check(form, "ghost_bends", ghost_bends)?;
        if *theta > 0.0 && *ghost_slopes <= 0.0 {
            let (parameter, value, range) = (
                "ghost_slopes",
                *ghost_slopes,
                "positive where θ > 0: without a ghost penalty small cuts are unstable",
            );
            return Err(AssemblyError::ParameterRange { form, parameter, value, range });
        }
        Range::NonNegative.check(form, "ghost_slopes", ghost_slopes)
    }
}
