//! The paper's experiment (Section 5): a hollow cylinder, clamped inside, pressed onto a flat obstacle.
//!
//! Centre (0,0), R_i = 20 cm, R_e = 30 cm, plane strain, u_D = (0, −1 cm) on the inner circle, Γ_C the lower
//! half of the outer circle, obstacle y = −30, criterion M(u) = F·u with F = (0, −1 N). Lengths are in cm
//! and stresses in MPa, never converted: forces come out in MPa·cm. Beyond the paper: friction, and other u_D in load steps.

mod friction;

use std::time::Instant;

use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;
use forms_fem::solve::SolverReport;
use thiserror::Error;

use crate::contact_problem::ContactProblem;
use crate::forms;
use crate::paper_law::Adjoint;
use crate::threshold::required_gamma0;
pub use friction::{CylinderStep, Friction, FrictionResults};
use friction::{Law, pushed};

/// Inner radius \[cm\].
pub const INNER_RADIUS: f64 = 20.0;
/// Outer radius \[cm\].
pub const OUTER_RADIUS: f64 = 30.0;
/// The obstacle is y = −`OBSTACLE_DEPTH` \[cm\].
pub const OBSTACLE_DEPTH: f64 = 30.0;
/// u_D on the inner circle \[cm\].
pub const IMPOSED_DISPLACEMENT: [f64; 2] = [0.0, -1.0];
/// F in M(u) = F·u \[N\].
pub const CRITERION_FORCE: [f64; 2] = [0.0, -1.0];
/// Cells around per cell across the thickness.
pub const CELLS_AROUND: usize = 16;
/// Mesh region of Γ_C.
pub const CONTACT: &str = "contact";
/// Mesh region of the cells that own facets of Γ_C.
pub const CONTACT_CELLS: &str = "contact cells";
/// Samples per facet at which the penetration is measured.
pub const PENETRATION_SAMPLES: usize = 21;

/// Parameters of the experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// n_r, cells across the thickness; 16 n_r around.
    pub radial: usize,
    /// θ of Nitsche's method.
    pub theta: f64,
    /// γ₀ in units of Young's modulus.
    pub gamma0_over_young: f64,
    /// E \[MPa\].
    pub young: f64,
    /// ν.
    pub poisson: f64,
    /// Degree of the quadrature on cells and facets.
    pub degree: usize,
    /// C in ξ = C √h_T of (41) \[MPa/√cm\].
    pub extension: f64,
    /// Friction on Γ_C.
    pub friction: Friction,
    /// u_D on the inner circle \[cm\], one load step each; with friction the results depend on all of them.
    pub pushes: Vec<[f64; 2]>,
    /// Number of threads that assemble; results do not depend on it.
    pub threads: Threads,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            radial: 16,
            theta: -1.0,
            gamma0_over_young: 10.0,
            young: 100.0,
            poisson: 0.3,
            degree: 8,
            extension: 1.0,
            friction: Friction::None,
            pushes: vec![IMPOSED_DISPLACEMENT],
            threads: Threads::all(),
        }
    }
}

/// Errors of the cylinder's computation.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum CylinderError {
    /// A setting without meaning.
    #[error("{name} = {value} is not possible: {why}")]
    Setting { name: &'static str, value: f64, why: &'static str },
    /// The mesh could not be made.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The space could not be made.
    #[error(transparent)]
    Space(#[from] forms_fem::space::SpaceError),
    /// The Dirichlet condition does not fit.
    #[error(transparent)]
    Constraints(#[from] forms_fem::constraints::ConstraintsError),
    /// A value at a point.
    #[error(transparent)]
    Field(#[from] forms_fem::field::FieldError),
    /// A form and its data do not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Newton's method stopped, or an adjoint problem was not solved.
    #[error(transparent)]
    Solve(Box<SolveError>),
}

impl From<SolveError> for CylinderError {
    fn from(error: SolveError) -> Self {
        CylinderError::Solve(Box::new(error))
    }
}

impl Settings {
    /// Check of every value.
    ///
    /// # Errors
    /// [`CylinderError::Setting`] names the first value that has no meaning.
    pub fn check(&self) -> Result<(), CylinderError> {
        let fail = |name, value, why| Err(CylinderError::Setting { name, value, why });
        if self.radial == 0 || self.radial > 2000 {
            return fail("radial", self.radial as f64, "cells across the thickness are between 1 and 2000");
        }
        if !self.theta.is_finite() {
            return fail("theta", self.theta, "it must be a finite number");
        }
        if !(self.gamma0_over_young > 0.0 && self.gamma0_over_young.is_finite()) {
            return fail("gamma0", self.gamma0_over_young, "it must be positive");
        }
        if !(self.young > 0.0 && self.young.is_finite()) {
            return fail("young", self.young, "Young's modulus must be positive");
        }
        if !(self.poisson > -1.0 && self.poisson < 0.5) {
            return fail("poisson", self.poisson, "Poisson's ratio lies between -1 and 0.5");
        }
        if !(2..=forms_fem::quadrature::MAXIMUM_DEGREE).contains(&self.degree) {
            return fail(
                "degree",
                self.degree as f64,
                "the quadrature degree is between 2 and the highest there is",
            );
        }
        if !(self.extension >= 0.0 && self.extension.is_finite()) {
            return fail("xi", self.extension, "C must not be negative");
        }
        let friction = match self.friction {
            Friction::None => None,
            Friction::Tresca(bound) => Some(("tresca", bound)),
            Friction::Coulomb(coefficient) => Some(("coulomb", coefficient)),
        };
        if let Some((name, value)) = friction.filter(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            return fail(name, value, "friction must be a finite number, zero or positive");
        }
        if self.pushes.is_empty() {
            return fail("push", 0.0, "the number of load steps is at least 1");
        }
        match self.pushes.iter().flatten().find(|component| !component.is_finite()) {
            Some(component) => fail("push", *component, "the displacement must be finite"),
            None => Ok(()),
        }
    }

    /// u_D on the inner circle after the last load step \[cm\]. Without load steps, which [`Settings::check`] refuses, it is the paper's.
    fn last_push(&self) -> [f64; 2] {
        self.pushes.last().copied().unwrap_or(IMPOSED_DISPLACEMENT)
    }

    /// Number of unknowns of the displacement on biquadratic cells, prescribed ones included, computed without a mesh.
    pub fn unknowns(&self) -> f64 {
        let radial = self.radial as f64;
        2.0 * (2.0 * radial + 1.0) * (2.0 * CELLS_AROUND as f64 * radial)
    }

    /// λ and μ \[MPa\] in plane strain.
    pub fn lame(&self) -> (f64, f64) {
        let (e, nu) = (self.young, self.poisson);
        (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
    }
}

/// The mesh, space and data of the experiment without friction, with u_D of the last load step.
///
/// # Errors
/// A setting without meaning.
pub fn hollow_cylinder(settings: &Settings) -> Result<ContactProblem<2>, CylinderError> {
    settings.check()?;
    let around = CELLS_AROUND * settings.radial;
    let mut mesh = annulus(INNER_RADIUS, OUTER_RADIUS, settings.radial, around, CellShape::Quadrilateral, 2)?;
    mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0)?;
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
    hollow_cylinder_on(&mesh, settings)
}

/// The experiment on another mesh with the regions of [`hollow_cylinder`]'s, as on that mesh after it has moved.
///
/// # Errors
/// A setting without meaning, a region that is not there.
pub fn hollow_cylinder_on(mesh: &Mesh<2>, settings: &Settings) -> Result<ContactProblem<2>, CylinderError> {
    settings.check()?;
    let space = Space::vector(mesh, 2)?;
    let constraints = pushed(&space, settings.last_push())?;
    let (lambda, mu) = settings.lame();
    let data = forms::data()
        .lambda(lambda)
        .mu(mu)
        .gamma0(settings.gamma0_over_young * settings.young)
        .obstacle_normal([0.0, -1.0])
        .gap(Given::function_with_gradient(|x: &[f64; 2]| x[1] + OBSTACLE_DEPTH, |_| [0.0, 1.0]))
        .theta(settings.theta)
        .extension(settings.extension)
        .criterion_force(CRITERION_FORCE);
    let regions = forms::Regions::default().gamma_n("outer").gamma_c(CONTACT);
    let problem = ContactProblem::new(&space, forms::Model { data, regions }, constraints);
    let problem = problem.quadrature(Quadrature::Degree(settings.degree)).threads(settings.threads);
    // The setup takes the time for it, and not the first solution.
    problem.pattern()?;
    Ok(problem)
}

/// The solution with everything the paper measures. Stresses in MPa, forces in MPa·cm, lengths in cm.
#[derive(Clone, Debug)]
pub struct CylinderSolution {
    /// The problem that was solved; with friction that without it, whose pressure and gap are the same functions of u.
    pub problem: ContactProblem<2>,
    /// u_h of (14) after the last load step.
    pub u: Field<2>,
    /// p̃_h of (21).
    pub p_discrete: Field<2>,
    /// p_h of (22).
    pub p_consistent: Field<2>,
    /// p_h of (41).
    pub p_extended: Field<2>,
    /// Newton's iterates of the last load step.
    pub history: Vec<NewtonStep>,
    /// The criterion (3).
    pub criterion: f64,
    /// ∫ \[σ_n − γ(u_n − g)\]₋.
    pub contact_force: f64,
    /// |Γ^h_C,a|.
    pub contact_length: f64,
    /// Each load step.
    pub steps: Vec<CylinderStep>,
    /// Friction after the last load step.
    pub friction: Option<FrictionResults>,
    /// max (u_n − g) over [`PENETRATION_SAMPLES`] points per facet.
    pub max_penetration: f64,
    /// The γ₀ \[MPa\] that the threshold asks for; zero at θ = −1.
    pub required_gamma0: f64,
    /// Seconds per stage.
    pub seconds: Seconds,
    /// Report of the linear solver.
    pub solver: SolverReport,
}

/// Seconds per stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Mesh, space, constraints, matrix pattern.
    pub setup: f64,
    /// Assembly of the direct problem.
    pub assembly: f64,
    /// Symbolic analysis and factorisations of the direct problem.
    pub factorisation: f64,
    /// The whole direct solve once mesh and spaces exist.
    pub newton_total: f64,
    /// The three adjoint states.
    pub adjoint: f64,
}

/// Solutions of the direct problem and of the three adjoint problems.
///
/// # Errors
/// [`CylinderError`], with Newton's history where Newton failed.
pub fn solve(settings: &Settings) -> Result<CylinderSolution, CylinderError> {
    solve_with_progress(settings, |_| ())
}

/// [`solve`] with a function that is called with every Newton iterate and at each further stage.
///
/// # Errors
/// As [`solve`].
pub fn solve_with_progress(
    settings: &Settings,
    mut progress: impl FnMut(Progress),
) -> Result<CylinderSolution, CylinderError> {
    solve_telling(settings, &mut progress)
}

/// [`solve_with_progress`], compiled here and not in the program that listens.
fn solve_telling(
    settings: &Settings,
    progress: &mut dyn FnMut(Progress),
) -> Result<CylinderSolution, CylinderError> {
    let start = Instant::now();
    let problem = hollow_cylinder(settings)?;
    let required_gamma0 = required_gamma0(&problem, CONTACT_CELLS)?;
    let mut seconds = Seconds { setup: start.elapsed().as_secs_f64(), ..Seconds::default() };
    let options = TangentSolverOptions { threads: settings.threads, ..TangentSolverOptions::default() };
    let mut solver = CondensedSolver::new(options);
    let mut law = Law::of(settings, &problem)?;
    let (mut u, mut history, mut steps) = (Field::zero(&problem.space), vec![], vec![]);
    for (number, &push) in settings.pushes.iter().enumerate() {
        if settings.pushes.len() > 1 {
            progress(Progress::LoadStep(number + 1, settings.pushes.len()));
        }
        let direct = law.step(push, &u, &mut solver, progress)?;
        seconds.assembly += direct.assembly_seconds;
        seconds.newton_total += direct.seconds;
        u = direct.field().clone();
        history = direct.history;
        steps.push(CylinderStep {
            push,
            newton_iterations: history.len().saturating_sub(1),
            contact_force: problem.assembler.functional(&problem.law.contact_force(&u))?,
            contact_length: problem.assembler.functional(&problem.law.contact_length(&u))?,
            friction: law.friction(&u)?,
        });
    }
    seconds.factorisation = solver.report().analysis_seconds + solver.report().factorisation_seconds;
    progress(Progress::Stage("adjoint states (22), (41), (21)"));
    let states =
        law.adjoints(&[Adjoint::Consistent, Adjoint::Extended, Adjoint::Discrete], &u, &mut solver)?;
    let mut adjoints = [(); 3].map(|()| Field::zero(&problem.space));
    for (adjoint, state) in adjoints.iter_mut().zip(states) {
        seconds.adjoint += state.seconds;
        *adjoint = state.into_field();
    }
    let [p_consistent, p_extended, p_discrete] = adjoints;
    let (assembler, paper) = (&problem.assembler, &problem.law);
    let criterion = assembler.functional(&paper.criterion(&u))?;
    let contact_force = assembler.functional(&paper.contact_force(&u))?;
    let contact_length = assembler.functional(&paper.contact_length(&u))?;
    let samples = assembler.along_facets_uniformly(&paper.penetration(&u), CONTACT, PENETRATION_SAMPLES)?;
    let max_penetration = samples.iter().map(|sample| sample.value[0]).fold(f64::NEG_INFINITY, f64::max);
    Ok(CylinderSolution {
        history,
        criterion,
        contact_force,
        contact_length,
        friction: law.friction(&u)?,
        steps,
        max_penetration,
        required_gamma0,
        seconds,
        solver: solver.report(),
        u,
        p_discrete,
        p_consistent,
        p_extended,
        problem,
    })
}

/// Progress of [`solve`].
#[derive(Clone, Copy, Debug)]
pub enum Progress<'a> {
    /// A Newton iterate.
    Newton(&'a NewtonStep),
    /// A load step begins: its number from 1, and the number of all.
    LoadStep(usize, usize),
    /// A further stage begins.
    Stage(&'static str),
}
