//! Contact problem: a contact law on a space, and the drivers that solve its direct and its adjoint problem.

use std::fmt;
use std::sync::OnceLock;

use forms_fem::assemble::BlockPattern;
use forms_fem::prelude::*;

use crate::forms;
use crate::law::{ContactLaw, WithAdjoint, WithIndicator};

/// A contact law on a space, ready to be solved. The law is any forms module that [`contact_law!`](crate::contact_law)
/// describes; the paper's, unless another is given.
#[derive(Clone)]
pub struct ContactProblem<const D: usize, L = forms::Model<D>> {
    /// Runs the kernels.
    pub assembler: Assembler<D>,
    /// V^h.
    pub space: Arc<Space<D>>,
    /// The law's forms with their data and regions.
    pub law: L,
    /// u = u_D on Γ_D. Adjoint states vanish there.
    pub constraints: Constraints<D>,
    pattern: OnceLock<Option<Arc<BlockPattern<D>>>>,
    /// Rule for splitting the facets of Γ_C at a displacement; none where they are integrated as a whole.
    split: Option<Split<D, L>>,
}

/// Splits the facets of Γ_C for a law at a displacement.
type Split<const D: usize, L> = fn(&Assembler<D>, &L, &Field<D>) -> Result<Assembler<D>, AssemblyError>;

/// Resolution of an indicator along a facet that may be split. In the plane it is the degree of its interpolation (on straight facets an indicator of
/// degree k needs k), in space the number of triangles along an edge.
#[doc(hidden)]
pub const RESOLUTION: usize = 8;

impl<const D: usize, L: fmt::Debug> fmt::Debug for ContactProblem<D, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unknowns = self.space.unknowns();
        f.debug_struct("ContactProblem").field("unknowns", &unknowns).field("law", &self.law).finish()
    }
}

impl<const D: usize, L: ContactLaw<D>> ContactProblem<D, L> {
    /// The problem of a law. Nothing is computed yet.
    pub fn new(space: &Arc<Space<D>>, law: L, constraints: Constraints<D>) -> Self {
        let (assembler, space) = (Assembler::new(space.mesh()), space.clone());
        ContactProblem { assembler, space, law, constraints, pattern: OnceLock::new(), split: None }
    }

    /// The same problem with another law.
    pub(crate) fn with_law(&self, law: L) -> Self {
        ContactProblem { law, ..self.clone() }
    }

    /// The pattern that all states share, from the first use on; none where contact pairs or interior facets couple cells.
    pub(crate) fn pattern(&self) -> Result<Option<&Arc<BlockPattern<D>>>, AssemblyError> {
        if let Some(known) = self.pattern.get() {
            return Ok(known.as_ref());
        }
        let direct = self.law.direct();
        // Those of spaces couple the nodes of each cell and no others.
        let across = |entity: Entity| matches!(entity, Entity::Pairs | Entity::InteriorFacets);
        let pattern = if direct.inputs().regions.iter().any(|region| across(region.entity)) {
            None
        } else {
            let pattern = self.assembler.pattern_of_spaces(&[&self.space], &[&self.space]);
            let refused = |source| AssemblyError::LinearAlgebra { form: direct.name(), source };
            Some(Arc::new(pattern.map_err(refused)?))
        };
        Ok(self.pattern.get_or_init(|| pattern).as_ref())
    }

    /// This problem with a quadrature rule in place of one of the degree that the compiler estimates.
    pub fn quadrature(mut self, quadrature: Quadrature<D>) -> Self {
        self.assembler = self.assembler.with_quadrature(quadrature);
        self
    }

    /// This problem with a number of threads in place of all: of assembly, and of linear solvers that no one gives.
    pub fn threads(mut self, threads: Threads) -> Self {
        self.assembler = self.assembler.with_threads(threads);
        self
    }

    /// This problem with an assembler that was made for more than it.
    pub fn assembler(mut self, assembler: Assembler<D>) -> Self {
        self.assembler = assembler;
        self
    }

    /// This problem with the facets of Γ_C split at the zeros of the law's indicator at each iterate, so that \[·\]₋ and
    /// Heaviside's function of it are integrated as exactly as what is smooth: an attribute of the integrals over Γ_C, for all
    /// states and the shape gradient. For (14) the integrand vanishes where a facet is split, so that its tangent, (21)
    /// and the shape derivative need no further term. Newton's method then stops on the residual, not on an active set.
    pub fn with_split_facets(mut self) -> Self
    where
        L: WithIndicator<D>,
    {
        self.split = Some(|assembler, law, u| {
            assembler.split_at_zeros(&law.indicator(u), law.contact_region(), RESOLUTION)
        });
        self
    }

    /// Whether facets of Γ_C are split.
    pub(crate) fn splits_facets(&self) -> bool {
        self.split.is_some()
    }

    /// The assembler of integrals over the contact zone of a displacement: [`ContactProblem::assembler`], with facets of Γ_C split
    /// if that was asked for.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn assembler_at(&self, u: &Field<D>) -> Result<Assembler<D>, AssemblyError> {
        match self.split {
            None => Ok(self.assembler.clone()),
            Some(split) => split(&self.assembler, &self.law, u),
        }
    }

    /// The direct problem, from u = 0 with u_D imposed and by the law's line search unless its builder says otherwise. Where
    /// γ₀ is below the law's [threshold](crate::threshold) the solution has a note that names it, and so has the error of a
    /// solve that fails.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # use forms_contact::{ContactProblem, law::ContactLaw};
    /// fn displacement<const D: usize, L: ContactLaw<D>>(
    ///     problem: &ContactProblem<D, L>,
    /// ) -> Result<Field<D>, Box<dyn std::error::Error>> {
    ///     Ok(problem.direct()?.solve()?.into_field())
    /// }
    /// ```
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn direct(&self) -> Result<Problem<'_, D>, AssemblyError> {
        let form = self.law.direct();
        self.law.check(form.name())?;
        let options = NewtonOptions { line_search: self.law.line_search(), ..NewtonOptions::default() };
        let problem = Problem::new(&form, &self.space)
            .assembler(&self.assembler)
            .constrained(&self.constraints)
            .options(options);
        let mut problem = self.on_pattern(problem)?;
        // Data that do not fit are reported by the solution.
        if let Ok(Some(threshold)) = self.threshold() {
            problem = problem.with_notes(threshold.warning());
        }
        Ok(match self.split {
            None => problem,
            Some(split) => problem.assembler_at(move |u| split(&self.assembler, &self.law, &u[0])),
        })
    }

    /// A problem for a state that vanishes on Γ_D, such as an adjoint state, at the displacement u.
    ///
    /// # Errors
    /// A parameter out of its range, data that do not fit.
    pub fn state(&self, form: Form<D>, u: &Field<D>) -> Result<Problem<'_, D>, AssemblyError> {
        self.state_by(form, self.assembler_at(u)?)
    }

    /// [`ContactProblem::state`] with an assembler of its own.
    pub(crate) fn state_by(
        &self,
        form: Form<D>,
        assembler: Assembler<D>,
    ) -> Result<Problem<'_, D>, AssemblyError> {
        self.law.check(form.name())?;
        let problem = Problem::new(&form, &self.space).assembler(assembler);
        self.on_pattern(problem.homogeneous(&self.constraints))
    }

    fn on_pattern<'p>(&self, problem: Problem<'p, D>) -> Result<Problem<'p, D>, AssemblyError> {
        Ok(match self.pattern()? {
            Some(pattern) => problem.with_pattern(pattern),
            None => problem,
        })
    }

    /// The adjoint problem of the law's criterion at the displacement u. A solver that has solved the direct problem reuses
    /// its analysis and, where it can, its factor.
    ///
    /// # Errors
    /// As [`ContactProblem::state`].
    pub fn adjoint(&self, u: &Field<D>) -> Result<Problem<'_, D>, AssemblyError>
    where
        L: WithAdjoint<D>,
    {
        self.state(self.law.adjoint(u), u)
    }

    /// J at a displacement.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn criterion(&self, u: &Field<D>) -> Result<f64, AssemblyError>
    where
        L: WithAdjoint<D>,
    {
        self.assembler_at(u)?.functional(&self.law.criterion(u))
    }
}
