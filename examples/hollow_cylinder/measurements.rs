//! Results of the program; the JSON file has these names.

use forms_contact_problem::hollow_cylinder::{
    self as cylinder, CylinderSolution, CylinderStep, Friction, Settings,
};
use forms_fem::linear_algebra::SharedWork;
use forms_fem::norms::{Norms, norms};
use forms_fem::prelude::*;
use forms_fem::solve::SolverReport;
use serde::Serialize;

use crate::Outcome;

/// Points at which u and p are given \[cm\].
const POINTS: [[f64; 2]; 3] = [[0.0, -25.0], [25.0, 0.0], [0.0, 25.0]];

/// Everything that is measured: lengths in cm, stresses in MPa, forces in MPa·cm.
#[derive(Clone, Debug, Serialize)]
pub struct Measurements {
    /// Version of this program and its packages.
    pub version: &'static str,
    /// System and processor.
    pub platform: String,
    /// True for an optimised build; seconds of other builds mean little.
    pub release_build: bool,
    pub settings: SettingsUsed,
    pub cells: usize,
    /// Before elimination of the prescribed ones.
    pub unknowns: usize,
    pub prescribed_unknowns: usize,
    /// Newton steps of the last load step.
    pub newton_iterations: usize,
    /// The start and each iterate of the last load step.
    pub newton_history: Vec<NewtonStep>,
    /// The criterion (3).
    #[serde(rename = "J")]
    pub criterion: f64,
    pub u_l2: f64,
    pub u_h1: f64,
    /// p̃_h of (21).
    pub p_discrete_l2: f64,
    pub p_discrete_h1: f64,
    /// p_h of (22).
    pub p_consistent_l2: f64,
    pub p_consistent_h1: f64,
    /// p_h of (41).
    pub p_extended_l2: f64,
    pub p_extended_h1: f64,
    /// ∫ \[σ_n − γ(u_n − g)\]₋ \[MPa·cm\].
    pub contact_force: f64,
    /// |Γ^h_C,a| \[cm\].
    pub contact_length: f64,
    /// ∫ of the tangential traction on the body, positive to the right \[MPa·cm\]; null without friction, as the two below.
    pub tangential_force: Option<f64>,
    /// Length of the part of the contact zone that sticks \[cm\].
    pub stick_length: Option<f64>,
    /// Length of the part of the contact zone that slips \[cm\].
    pub slip_length: Option<f64>,
    pub load_steps: Vec<LoadStep>,
    /// The largest u_n − g at 21 points per facet \[cm\].
    pub max_penetration: f64,
    pub points: Vec<AtPoint>,
    /// γ₀ \[MPa\] below which the method need not be stable; 0 at θ = −1.
    pub required_gamma0: f64,
    pub solver: Solver,
    /// Largest speed-ups by several threads, from counted work.
    pub speed_ups: SpeedUps,
    pub seconds: Seconds,
    /// Peak resident memory in 10⁶ bytes; null if the system does not report it.
    pub peak_rss_mb: Option<f64>,
}

/// The settings with their derived values.
#[derive(Clone, Debug, Serialize)]
pub struct SettingsUsed {
    pub radial: usize,
    pub around: usize,
    pub theta: f64,
    /// γ₀ / E.
    pub gamma0_over_young: f64,
    /// γ₀ \[MPa\].
    pub gamma0: f64,
    /// E \[MPa\].
    pub young: f64,
    pub poisson: f64,
    /// Degree of the quadrature.
    pub degree: usize,
    /// C of (41).
    pub xi: f64,
    /// The bound of Tresca's law \[MPa\]; null unless it was asked for.
    pub tresca: Option<f64>,
    /// The coefficient of Coulomb's law; null if it was not given.
    pub coulomb: Option<f64>,
    /// Threads of the assembly.
    pub threads: usize,
}

/// A load step that has converged.
#[derive(Clone, Debug, Serialize)]
pub struct LoadStep {
    /// Displacement of the inner circle \[cm\].
    pub push: [f64; 2],
    pub newton_iterations: usize,
    pub contact_force: f64,
    pub contact_length: f64,
    pub tangential_force: Option<f64>,
    pub stick_length: Option<f64>,
    pub slip_length: Option<f64>,
}

impl From<&CylinderStep> for LoadStep {
    fn from(step: &CylinderStep) -> LoadStep {
        LoadStep {
            push: step.push,
            newton_iterations: step.newton_iterations,
            contact_force: step.contact_force,
            contact_length: step.contact_length,
            tangential_force: step.friction.map(|friction| friction.tangential_force),
            stick_length: step.friction.map(|friction| friction.stick_length),
            slip_length: step.friction.map(|friction| friction.slip_length),
        }
    }
}

/// u of (14) and p of (22) at a point.
#[derive(Clone, Debug, Serialize)]
pub struct AtPoint {
    pub x: [f64; 2],
    pub u: Vec<f64>,
    pub p: Vec<f64>,
}

/// Report of the linear solver for the direct and the adjoint problems.
#[derive(Clone, Debug, Serialize)]
pub struct Solver {
    pub analyses: usize,
    pub factorisations: usize,
    pub indefinite_factorisations: usize,
    pub factor_entries: usize,
    /// The way that the last system took: "condensed to the unknowns that change", "Cholesky", "GMRES with …".
    pub path: Option<String>,
    /// Unknowns on the contact boundary to which Newton's steps were condensed; null where GMRES or one
    /// factor of the whole tangent was used.
    pub condensed_unknowns: Option<usize>,
    pub solves: usize,
    /// Krylov iterations of each solve; 0 for a direct one.
    pub iterations: Vec<usize>,
    /// Largest relative residual of a solve.
    pub largest_residual: f64,
}

/// Seconds per stage.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Seconds {
    /// Mesh, space, matrix pattern, threshold of γ₀.
    pub setup: f64,
    /// Assembly of the direct problem.
    pub assembly: f64,
    /// Symbolic analysis and factorisations of the direct problem.
    pub factorisation: f64,
    /// The whole direct solve once mesh and spaces exist.
    pub newton_total: f64,
    /// The three adjoint states.
    pub adjoint: f64,
    /// Norms and values at points.
    pub norms: f64,
    /// Stress, von Mises stress, gap and contact pressure.
    pub derived_fields: f64,
    /// The `.vtu` file.
    pub vtu: f64,
    pub pictures: f64,
    pub total: f64,
}

impl Measurements {
    /// Computes the norms and collects the rest.
    pub fn new(settings: &Settings, solution: &CylinderSolution) -> Outcome<Measurements> {
        let start = std::time::Instant::now();
        let assembler = &solution.problem.assembler;
        let of = |field: &Field<2>| -> Result<Norms, AssemblyError> { norms(assembler, field) };
        let (u, discrete) = (of(&solution.u)?, of(&solution.p_discrete)?);
        let (consistent, extended) = (of(&solution.p_consistent)?, of(&solution.p_extended)?);
        let mut points = Vec::new();
        for x in POINTS {
            points.push(AtPoint { x, u: solution.u.evaluate(&x)?, p: solution.p_consistent.evaluate(&x)? });
        }
        let space = &solution.problem.space;
        let seconds = Seconds {
            setup: solution.seconds.setup,
            assembly: solution.seconds.assembly,
            factorisation: solution.seconds.factorisation,
            newton_total: solution.seconds.newton_total,
            adjoint: solution.seconds.adjoint,
            norms: start.elapsed().as_secs_f64(),
            ..Seconds::default()
        };
        Ok(Measurements {
            version: env!("CARGO_PKG_VERSION"),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            release_build: !cfg!(debug_assertions),
            settings: SettingsUsed::of(settings),
            cells: space.mesh().cell_count(),
            unknowns: space.unknowns(),
            prescribed_unknowns: solution.problem.constraints.prescribed().len(),
            newton_iterations: solution.history.len().saturating_sub(1),
            newton_history: solution.history.clone(),
            criterion: solution.criterion,
            u_l2: u.l2,
            u_h1: u.h1,
            p_discrete_l2: discrete.l2,
            p_discrete_h1: discrete.h1,
            p_consistent_l2: consistent.l2,
            p_consistent_h1: consistent.h1,
            p_extended_l2: extended.l2,
            p_extended_h1: extended.h1,
            contact_force: solution.contact_force,
            contact_length: solution.contact_length,
            tangential_force: solution.friction.map(|friction| friction.tangential_force),
            stick_length: solution.friction.map(|friction| friction.stick_length),
            slip_length: solution.friction.map(|friction| friction.slip_length),
            load_steps: solution.steps.iter().map(LoadStep::from).collect(),
            max_penetration: solution.max_penetration,
            points,
            required_gamma0: solution.required_gamma0,
            solver: Solver::of(&solution.solver),
            speed_ups: SpeedUps::of(solution)?,
            seconds,
            peak_rss_mb: None,
        })
    }
}

/// The largest speed-ups by [`SharedWork::THREADS`] threads: counted work over the counted cost until the last thread has finished.
#[derive(Clone, Debug, Serialize)]
pub struct SpeedUps {
    pub factorisation: Option<[f64; 5]>,
    pub triangular_solve: Option<[f64; 5]>,
    pub assembly: [f64; 5],
    /// Norms, and derived fields at quadrature points.
    pub evaluation: [f64; 5],
    /// Projections of derived fields to a scalar space.
    pub projection: [f64; 5],
}

impl SpeedUps {
    fn of(solution: &CylinderSolution) -> Outcome<SpeedUps> {
        let of = |work: &SharedWork| SharedWork::THREADS.map(|threads| work.speed_up(threads).unwrap_or(1.0));
        let assembler = &solution.problem.assembler;
        let scalars = solution.problem.space.with_shape(&[])?;
        Ok(SpeedUps {
            factorisation: solution.solver.factorisation_work.as_ref().map(of),
            triangular_solve: solution.solver.solve_work.as_ref().map(of),
            assembly: of(&assembler.assembly_work()),
            evaluation: of(&assembler.evaluation_work()),
            projection: of(&assembler.projection_work(&scalars)),
        })
    }
}

impl SettingsUsed {
    fn of(settings: &Settings) -> SettingsUsed {
        let (tresca, coulomb) = match settings.friction {
            Friction::None => (None, None),
            Friction::Tresca(bound) => (Some(bound), None),
            Friction::Coulomb(coefficient) => (None, Some(coefficient)),
        };
        SettingsUsed {
            radial: settings.radial,
            around: cylinder::CELLS_AROUND * settings.radial,
            theta: settings.theta,
            gamma0_over_young: settings.gamma0_over_young,
            gamma0: settings.gamma0_over_young * settings.young,
            young: settings.young,
            poisson: settings.poisson,
            degree: settings.degree,
            xi: settings.extension,
            tresca,
            coulomb,
            threads: settings.threads.count(),
        }
    }
}

impl Solver {
    fn of(report: &SolverReport) -> Solver {
        Solver {
            analyses: report.analyses,
            factorisations: report.factorisations,
            indefinite_factorisations: report.indefinite_factorisations,
            factor_entries: report.factor_entries,
            path: report.path.map(|path| path.to_string()),
            condensed_unknowns: report.condensed_unknowns,
            solves: report.solves,
            iterations: report.iterations.clone(),
            largest_residual: report.largest_residual,
        }
    }
}
