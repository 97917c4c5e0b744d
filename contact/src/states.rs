//! The drivers: direct problem → adjoint states, on any mesh, in two or three dimensions.

use std::time::Instant;

use forms_fem::assemble::BlockPattern;
use forms_fem::prelude::*;
use forms_fem::solve::{
    LineSearch, LinearProblemError, LoadPath, LoadStepError, LoadSteps, NewtonFailure, Solved,
};

use crate::forms;

/// The regions of a contact problem by their names in the mesh.
#[derive(Clone, Debug)]
pub struct Regions {
    /// Ω.
    pub omega: forms::Omega,
    /// Γ_N.
    pub gamma_n: forms::GammaN,
    /// Γ_C.
    pub gamma_c: forms::GammaC,
    /// ∂Ω, where the criterion's N acts.
    pub boundary: forms::Boundary,
}

impl Regions {
    /// All cells, the whole boundary for N, and the named facet regions for Γ_N and Γ_C.
    pub fn new(gamma_n: &str, gamma_c: &str) -> Self {
        Regions {
            omega: forms::Omega::on(forms_fem::mesh::EVERYWHERE),
            gamma_n: forms::GammaN::on(gamma_n),
            gamma_c: forms::GammaC::on(gamma_c),
            boundary: forms::Boundary::on(forms_fem::mesh::BOUNDARY),
        }
    }
}

/// A contact problem, ready to be solved.
#[derive(Clone, Debug)]
pub struct ContactProblem<const D: usize> {
    /// Runs the kernels.
    pub assembler: Assembler<D>,
    /// V^h.
    pub space: Arc<Space<D>>,
    /// Material, obstacle, loads, Nitsche's parameters, criterion.
    pub data: forms::Data<D>,
    /// Ω, Γ_N, Γ_C, ∂Ω.
    pub regions: Regions,
    /// u = u_D on Γ_D. Adjoint states vanish there.
    pub constraints: Constraints<D>,
    pattern: Arc<BlockPattern<D>>,
    contact_facets: ContactFacets,
}

/// The quadrature on the facets of Γ_C.
#[derive(Clone, Copy, Debug)]
enum ContactFacets {
    /// A facet is integrated as a whole.
    Whole,
    /// A facet is split at the zeros of the contact zone's indicator, anew at each displacement.
    Split,
}

/// The contact zone of (14), (21) and (22), or that of (41).
#[derive(Clone, Copy)]
enum Zone {
    /// β_h > 0.
    Touching,
    /// β_h > ξ.
    Extended,
}

/// How finely β_h is looked at along a facet before the facet is split: the degree of its interpolation in the plane, where
/// on straight facets of degree k it has degree k; triangles along an edge in space.
const RESOLUTION: usize = 8;

/// The way of [`ContactProblem::solve_direct_through`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThetaPath {
    /// The θ of the first problem.
    pub from: f64,
    /// Equal steps from there to the problem's own θ.
    pub steps: usize,
    /// For the first problem; on its potential only where `from` is 1.
    pub line_search: LineSearch,
}

impl Default for ThetaPath {
    /// From θ = 1, by a line search on the potential, in two steps.
    fn default() -> Self {
        ThetaPath { from: 1.0, steps: 2, line_search: LineSearch::OnPotential }
    }
}

/// The θ that was not reached, with the last solution.
pub type ThetaPathError<const D: usize> = Box<LoadStepError<Field<D>, NewtonError<AssemblyError>>>;

/// The paper's three adjoint states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adjoint {
    /// p̃_h of (21): the adjoint of the discrete problem.
    Discrete,
    /// p_h of (22): Nitsche's method for the continuous adjoint.
    Consistent,
    /// p_h of (41): (22) with an extended Neumann zone.
    Extended,
}

/// A state and the seconds that its assembly and its whole computation took.
#[derive(Clone, Debug)]
pub struct Timed<T> {
    /// The result.
    pub result: T,
    /// Seconds in assembly.
    pub assembly_seconds: f64,
    /// Seconds in all.
    pub seconds: f64,
}

impl<const D: usize> ContactProblem<D>
where
    Dim: Dimension<D>,
{
    /// Prepares the matrix pattern that all states share.
    ///
    /// # Errors
    /// When the matrix is too large to be numbered.
    pub fn new(
        assembler: Assembler<D>,
        space: &Arc<Space<D>>,
        data: forms::Data<D>,
        regions: Regions,
        constraints: Constraints<D>,
    ) -> Result<Self, AssemblyError> {
        let pattern = BlockPattern::new(&[space], &[space])
            .map_err(|source| AssemblyError::LinearAlgebra { form: "direct", source })?;
        let (space, pattern) = (space.clone(), Arc::new(pattern));
        Ok(ContactProblem {
            assembler,
            space,
            data,
            regions,
            constraints,
            pattern,
            contact_facets: ContactFacets::Whole,
        })
    }

    /// The same with the facets of Γ_C split at the zeros of β_h of each iterate, so that \[·\]₋ and H(β_h) are integrated as
    /// exactly as what is smooth: an attribute of the integrals over Γ_C, for all states and the shape gradient. The
    /// integrand of (14) vanishes where a facet is split, so that its tangent, (21) and the shape derivative need no
    /// further term. Newton's method then stops on the residual, not on an active set.
    pub fn with_split_facets(mut self) -> Self {
        self.contact_facets = ContactFacets::Split;
        self
    }

    /// Who assembles what reads β_h of a displacement, as ∫ H(β_h): [`ContactProblem::assembler`], with facets of Γ_C split
    /// if that was asked for.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn assembler_at(&self, u: &Field<D>) -> Result<Assembler<D>, AssemblyError> {
        self.assembler_of(u, Zone::Touching)
    }

    fn assembler_of(&self, u: &Field<D>, zone: Zone) -> Result<Assembler<D>, AssemblyError> {
        let region = &self.regions.gamma_c.0.name;
        match (self.contact_facets, zone) {
            (ContactFacets::Whole, _) => Ok(self.assembler.clone()),
            (ContactFacets::Split, Zone::Touching) => {
                let indicator = forms::contact_indicator(&self.data, u);
                self.assembler.split_at_zeros(&indicator, region, RESOLUTION)
            }
            (ContactFacets::Split, Zone::Extended) => {
                let indicator = forms::extended_indicator(&self.data, u);
                self.assembler.split_at_zeros(&indicator, region, RESOLUTION)
            }
        }
    }

    /// A γ₀ that is not positive turns the obstacle's push into a pull.
    ///
    /// # Errors
    /// [`AssemblyError::ParameterRange`] for such a γ₀, in the name of a form.
    pub fn check_gamma0(&self, form: &'static str) -> Result<(), AssemblyError> {
        let (parameter, value) = ("gamma0", self.data.gamma0);
        // A value that is not finite is named when the form is bound to its data.
        if value <= 0.0 {
            return Err(AssemblyError::ParameterRange { form, parameter, value, range: "positive" });
        }
        Ok(())
    }

    /// The direct problem (14) as a form.
    pub fn direct_form(&self) -> forms::direct::Compiled<D> {
        let Regions { omega, gamma_n, gamma_c, .. } = &self.regions;
        forms::direct(&self.data, omega, gamma_n, gamma_c)
    }

    /// Solves (14) by semismooth Newton from u = 0 with u_D imposed.
    ///
    /// # Errors
    /// The reason with Newton's history.
    pub fn solve_direct(
        &self,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<Timed<Solved<D>>, NewtonError<AssemblyError>> {
        self.solve_direct_from(&Field::zero(&self.space), solver, options, progress)
    }

    /// Solves (14) from another start, on which u_D is imposed.
    ///
    /// # Errors
    /// As [`ContactProblem::solve_direct`], and if the start is not a field of the problem's space.
    pub fn solve_direct_from(
        &self,
        first: &Field<D>,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<Timed<Solved<D>>, NewtonError<AssemblyError>> {
        let start = Instant::now();
        self.check_gamma0("direct").map_err(|error| NewtonError {
            why: NewtonFailure::Assembly(error),
            history: vec![],
            u: first.values().to_vec(),
        })?;
        let form = self.direct_form();
        let mut problem = FormProblem::with_pattern(&form, &self.assembler, &self.space, &self.pattern);
        if matches!(self.contact_facets, ContactFacets::Split) {
            problem = problem.with_assembler_at(|u| self.assembler_at(u));
        }
        let result = problem.solve(first, &self.constraints, solver, options, progress)?;
        let assembly_seconds = problem.assembly_seconds();
        Ok(Timed { result, assembly_seconds, seconds: start.elapsed().as_secs_f64() })
    }

    /// Solves (14) for hard starts: first at another θ (1 has a potential, so that a line search may help), then at
    /// values between it and the problem's own θ, each from the solution before. A step that fails is halved.
    ///
    /// # Errors
    /// The θ that could not be reached, the last solution, and why Newton's method failed.
    pub fn solve_direct_through(
        &self,
        path: ThetaPath,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(f64, &NewtonStep),
    ) -> Result<LoadPath<Field<D>>, ThetaPathError<D>> {
        let ThetaPath { from, steps, line_search } = path;
        let mut problem = self.clone();
        let mut solve_at = |theta: f64, line_search, first: &Field<D>| {
            problem.data.theta = theta;
            let options = NewtonOptions { line_search, ..options.clone() };
            let solved =
                problem.solve_direct_from(first, solver, &options, &mut |step| progress(theta, step));
            solved.map(|solved| solved.result.field)
        };
        let zero = Field::zero(&self.space);
        let first = match solve_at(from, line_search, &zero) {
            Ok(first) => first,
            Err(why) => {
                let (state, steps) = (zero, vec![]);
                return Err(Box::new(LoadStepError { factor: from, state, failed: from, why, steps }));
            }
        };
        let to = self.data.theta;
        if from == to {
            return Ok(LoadPath { state: first, steps: vec![] });
        }
        let count = steps.max(1);
        let thetas = (1..=count).map(|k| from + (to - from) * k as f64 / count as f64);
        let smallest_increment = (to - from).abs() / (1024.0 * count as f64);
        let steps = LoadSteps { start: from, factors: thetas.collect(), smallest_increment };
        let one = |theta: f64, before: &Field<D>| solve_at(theta, LineSearch::Off, before);
        steps.run(first, one, |_| (), |_| ()).map_err(Box::new)
    }

    /// Solves for an adjoint state at the displacement u; it vanishes on Γ_D. A solver that has solved the
    /// direct problem reuses its analysis and, where it can, its factor.
    ///
    /// # Errors
    /// What does not fit, or why the system was not solved.
    pub fn solve_adjoint(
        &self,
        adjoint: Adjoint,
        u: &Field<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Timed<Field<D>>, LinearProblemError> {
        let Regions { omega, gamma_n, gamma_c, boundary } = &self.regions;
        match adjoint {
            Adjoint::Discrete => {
                let form = forms::discrete_adjoint(&self.data, omega, gamma_n, gamma_c, boundary, u);
                self.solve_affine(&form, &self.assembler_at(u)?, solver)
            }
            Adjoint::Consistent => {
                let form = forms::consistent_adjoint(&self.data, omega, gamma_c, boundary, u);
                self.solve_affine(&form, &self.assembler_at(u)?, solver)
            }
            Adjoint::Extended => {
                let form = forms::extended_adjoint(&self.data, omega, gamma_c, boundary, u);
                self.solve_affine(&form, &self.assembler_of(u, Zone::Extended)?, solver)
            }
        }
    }

    fn solve_affine<F: Form<D>>(
        &self,
        form: &F,
        assembler: &Assembler<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Timed<Field<D>>, LinearProblemError> {
        let start = Instant::now();
        self.check_gamma0(form.name())?;
        let mut problem = FormProblem::with_pattern(form, assembler, &self.space, &self.pattern);
        let result = problem.solve_affine(&self.constraints.homogeneous(), solver)?;
        let assembly_seconds = problem.assembly_seconds();
        Ok(Timed { result, assembly_seconds, seconds: start.elapsed().as_secs_f64() })
    }
}
