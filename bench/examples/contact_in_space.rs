//! A block of n³ × 6 quadratic tetrahedra, pressed onto a rigid ball by Nitsche's method: Newton's method with multigrid on meshes
//! that become finer, then the last tangent compared with PETSc's CG with GAMG.
//!
//! `cargo run --release -p forms-bench --example contact_in_space -- [DIVISIONS]... [--theta THETA] [--alone]` (default 9, 18, 35:
//! 1,073,733 unknowns on the last mesh; θ = 1, whose tangents are symmetric). With another θ GMRES takes the place of conjugate
//! gradients, and PETSc is left out, as with `--alone`. Debian: python3-petsc4py, openmpi-bin.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use forms_bench::beside_petsc::{Beside, HEADER, compare, options, peak_memory};
use forms_contact::{ContactProblem, forms};
use forms_fem::linear_algebra::SharedWork;
use forms_fem::output::{StandardOutput, program, tell};
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, NonlinearProblem};

/// Contact in space by multigrid, on meshes that become finer, compared with PETSc.
#[derive(Parser)]
struct Arguments {
    /// Cubes of six tetrahedra along each edge, mesh after mesh.
    #[arg(default_values_t = [9, 18, 35])]
    divisions: Vec<usize>,
    /// θ of Nitsche's method.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    theta: f64,
    /// Leaves PETSc out.
    #[arg(long)]
    alone: bool,
}

/// E \[MPa\] and ν.
const YOUNG: f64 = 200.0;
const POISSON: f64 = 0.3;
/// Radius of the rigid ball, which touches the middle of the block's lower side \[mm\].
const RADIUS: f64 = 8.0;
/// Edge of the block \[mm\].
const EDGE: f64 = 4.0;
/// Displacement of its upper side \[mm\].
const PRESSED: f64 = 0.05;
/// Γ_C is the lower side this near to its middle \[mm\].
const REACH: f64 = 1.0;

fn block(divisions: usize, theta: f64) -> Result<ContactProblem<3>, Box<dyn Error>> {
    let half = EDGE / 2.0;
    let mut mesh =
        cuboid([-half, -half, 0.0], [half, half, EDGE], [divisions; 3], CellShape::Tetrahedron, 1)?;
    let near = |centre: &[f64; 3]| centre[0].abs().max(centre[1].abs()) < REACH;
    mesh.name_facets("contact", "bottom", near)?;
    mesh.name_facets("beside", "bottom", |centre| !near(centre))?;
    let space = Space::vector(&mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |_: &[f64; 3]| [0.0, 0.0, -PRESSED])?;
    let away = |x: &[f64; 3]| {
        let away = [x[0], x[1], x[2] + RADIUS];
        let length = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        (length, away.map(|v| v / length))
    };
    let data = forms::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .gamma0(20.0 * YOUNG)
        .obstacle_normal(move |x: &[f64; 3]| away(x).1.map(|v| -v))
        .gap(move |x: &[f64; 3]| away(x).0 - RADIUS)
        .theta(theta);
    let regions = forms::Regions::default().gamma_n("beside").gamma_c("contact");
    Ok(ContactProblem::new(&space, forms::Model { data, regions }, constraints)
        .quadrature(Quadrature::Degree(6)))
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    out.line("n | unknowns | Newton steps | active points | iterations, each step | mesh, space, pattern s | of Newton's method s | of it set-up s | iterations s | peak memory");
    out.line("--- | --- | --- | --- | --- | --- | --- | --- | --- | ---");
    let mut last = None;
    for &divisions in &arguments.divisions {
        drop(last.take());
        let start = Instant::now();
        let problem = block(divisions, arguments.theta)?;
        let prepared = start.elapsed().as_secs_f64();
        let mut solver = MultigridSolver::new(&problem.constraints, options(Threads::all()))?;
        let mut active = 0;
        let solved = problem
            .direct()?
            .solver(&mut solver)
            .each_step(|step| {
                active = step.active_points.unwrap_or(0);
                tell(format!(
                    "Newton {}: residual {:.2e}, {active} active points",
                    step.iteration, step.residual
                ));
            })
            .solve()?;
        let seconds = start.elapsed().as_secs_f64() - prepared;
        let report = solver.report();
        let iterations: Vec<String> = report.iterations.iter().map(ToString::to_string).collect();
        out.line(format!(
            "{divisions} | {} | {} | {active} | {} | {prepared:.2} | {seconds:.2} | {:.2} | {:.2} | {}",
            problem.space.unknowns(),
            solved.iterations(),
            iterations.join(", "),
            report.setup_seconds,
            report.solve_seconds,
            peak_memory()
        ));
        for (stage, work) in [("set-up", &report.setup_work), ("a cycle", &report.cycle_work)] {
            if let Some(work) = work {
                let speed_ups = SharedWork::THREADS.map(|threads| work.speed_up(threads).unwrap_or(1.0));
                let threads = SharedWork::THREADS;
                tell(format!("Counted speed-ups of {stage} on {threads:?} threads: {speed_ups:.1?}"));
            }
        }
        let u = solved.into_field();
        drop(solver);
        last = Some((problem, u));
    }
    let Some((problem, u)) = last.filter(|_| arguments.theta == 1.0) else { return Ok(()) };
    let space = &problem.space;
    let prescribed = problem.constraints.prescribed();
    let mut elimination = Elimination::new(space.unknowns(), prescribed)?;
    let mut at_start = vec![0.0; space.unknowns()];
    prescribed.iter().for_each(|(unknown, value)| at_start[*unknown] = *value);
    let mut direct = problem.direct()?;
    let load: Vec<f64> =
        elimination.reduce(&direct.residual(&at_start)?)?.iter().map(|value| -value).collect();
    let matrix = elimination.reduce_matrix(&direct.tangent(u.values())?.matrix)?;
    drop(direct);
    out.line(format!(
        "\nThe last tangent, {} entries, with the residual of the start\n",
        matrix.values().len()
    ));
    HEADER.iter().for_each(|line| out.line(line));
    let free = elimination.free().iter().step_by(3).map(|unknown| space.positions()[unknown / 3]);
    let beside = if arguments.alone { Beside::Nobody } else { Beside::Petsc };
    compare(out, &problem.constraints, (matrix, load), free, beside)
}

fn main() -> ExitCode {
    program(run)
}
