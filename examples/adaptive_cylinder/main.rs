//! The paper's cylinder on meshes that follow the error of its criterion J, beside meshes refined everywhere, with the three
//! adjoint states as weights of the residual: the table and picture of docs/adaptivity.md.
//!
//! `cargo run --release --bin adaptive_cylinder`

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use forms_contact::hollow_cylinder::{
    CONTACT, CONTACT_CELLS, IMPOSED_DISPLACEMENT, INNER_RADIUS, OUTER_RADIUS, Settings, hollow_cylinder_on,
};
use forms_contact::{Adjoint, ContactProblem};
use forms_examples::command_line::program_with_options;
use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate};
use forms_fem::mesh::{Surface, onto_sphere};
use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
use forms_fem::output::{StandardOutput, tell};
use forms_fem::prelude::*;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// The residual at a product of a test function and what is known.
#[forms]
mod weighted {
    pub use forms_contact::nitsche::nitsche::Data;
    use forms_contact::nitsche::nitsche::direct;
    pub use forms_contact::nitsche::nitsche::{GammaC, GammaN, Omega};

    pub fn localised(u: State<Vector>, z: State<Vector>, q: Test<Scalar>) -> Form {
        direct(u, q * z)
    }
}

/// The paper's cylinder on meshes that follow the error of J, beside meshes refined everywhere.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "adaptive_cylinder")]
struct Options {
    /// The estimated error of J, relative to J, at which both ways end
    #[arg(long, value_name = "T", default_value_t = 1e-6)]
    tolerance: f64,
    /// Unknowns at which the meshes refined everywhere end at the latest
    #[arg(long, value_name = "N", default_value_t = 200_000)]
    most: usize,
    /// Directory of the picture; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/adaptive_cylinder")]
    out: PathBuf,
}

/// What is known of one mesh.
#[derive(Clone, Copy, Debug)]
struct Row {
    unknowns: usize,
    criterion: f64,
    /// By (21), (22) and (41).
    estimates: [f64; 3],
    /// Seconds since the first mesh of its kind.
    seconds: f64,
}

/// The solution in degree 2, with J and its estimated error by each adjoint state in degree 3; (21) marks.
fn solve(mesh: &Arc<Mesh<2>>, before: Option<&Field<2>>) -> Outcome<(AdaptiveSolution<2>, f64, [f64; 3])> {
    let problem = hollow_cylinder_on(mesh, &Settings::default())?;
    let start = match before {
        Some(before) => before.onto(&problem.space).interpolated()?,
        None => Field::zero(&problem.space),
    };
    let u = problem.direct()?.start(&start).solve()?.into_field();
    let criterion = problem.assembler.functional(&problem.law.criterion(&u))?;
    let space = Space::vector(mesh, 3)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("inner", |_| IMPOSED_DISPLACEMENT)?;
    let higher = ContactProblem::new(problem.assembler.clone(), &space, problem.law.clone(), constraints)?;
    let regions = weighted::Regions::default().gamma_n("outer").gamma_c(CONTACT);
    let model = weighted::Model { data: problem.law.data.clone(), regions };
    let mut solver = TangentSolver::default();
    let mut estimates = vec![];
    for adjoint in [Adjoint::Discrete, Adjoint::Consistent, Adjoint::Extended] {
        let p = higher.solve_adjoint(adjoint, &u, &mut solver)?.into_field();
        let localised = |z: &Field<2>| model.localised(&u, z);
        estimates.push(ErrorEstimate::dual_weighted(&problem.assembler, &p, &problem.space, localised)?);
    }
    let values = std::array::from_fn(|k| estimates[k].value());
    let own = estimates.swap_remove(0);
    Ok((AdaptiveSolution::new(u, own).with_goal(criterion), criterion, values))
}

/// Prints a table: unknowns, J, what is left of it to the reference, the estimates over that, seconds.
fn table(out: &mut StandardOutput, name: &str, rows: &[Row], reference: f64) {
    for Row { unknowns, criterion, estimates, seconds } in rows {
        let error = reference - criterion;
        let [a, b, c] = estimates.map(|estimate| estimate / error);
        out.line(format!(
            "| {name} | {unknowns} | {criterion:.8} | {error:.3e} | {a:.3} | {b:.3} | {c:.3} | {seconds:.1} |"
        ));
    }
}

fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    // A long computation must not end with nowhere to put its result.
    std::fs::create_dir_all(&options.out)
        .map_err(|error| format!("the output directory {} cannot be used: {error}", options.out.display()))?;
    if !(options.tolerance > 0.0 && options.tolerance < 1.0) {
        return Err(format!("--tolerance {}: it lies between 0 and 1", options.tolerance).into());
    }
    let mut coarse = annulus(INNER_RADIUS, OUTER_RADIUS, 2, 32, CellShape::Triangle, 2)?;
    coarse.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0)?;
    coarse.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
    let coarse = Arc::new(coarse);
    let (inner, outer) = (onto_sphere([0.0; 2], INNER_RADIUS), onto_sphere([0.0; 2], OUTER_RADIUS));
    let surfaces: [Surface<2>; 2] = [("inner", &inner), ("outer", &outer)];

    let mut adaptive: Vec<Row> = vec![];
    let tolerance = options.tolerance * solve(&coarse, None)?.1.abs();
    let clock = Instant::now();
    let on_mesh = |mesh: &Arc<Mesh<2>>, before: Option<&Field<2>>| -> Outcome<_> {
        let (solution, criterion, estimates) = solve(mesh, before)?;
        let (unknowns, seconds) = (solution.field.space().unknowns(), clock.elapsed().as_secs_f64());
        adaptive.push(Row { unknowns, criterion, estimates, seconds });
        Ok(solution)
    };
    let cycle = Adaptation::to_tolerance(tolerance).onto(&surfaces);
    cycle.run(coarse.clone(), on_mesh, |step| tell(format!("adaptive, {step}")))?;

    let (mut uniform, mut mesh, mut before): (Vec<Row>, _, Option<Field<2>>) = (vec![], coarse, None);
    let clock = Instant::now();
    loop {
        let (solution, criterion, estimates) = solve(&mesh, before.as_ref())?;
        let (unknowns, seconds) = (solution.field.space().unknowns(), clock.elapsed().as_secs_f64());
        uniform.push(Row { unknowns, criterion, estimates, seconds });
        tell(format!("refined everywhere, {unknowns} unknowns, J = {criterion:.8}"));
        if estimates[0].abs() <= tolerance || 4 * unknowns > options.most {
            break;
        }
        before = Some(solution.field);
        mesh = Arc::new(mesh.refined_onto(&surfaces)?);
    }

    // What is left of the last estimate is of higher order.
    let reference = adaptive.last().map_or(f64::NAN, |row| row.criterion + row.estimates[0]);
    out.line(format!("J = {reference:.8} N cm^2, by the last adaptive mesh and its estimate\n"));
    out.line("| meshes | unknowns | J_h | J − J_h | η/(J − J_h), (21) | (22) | (41) | seconds |");
    out.line("| --- | --: | --: | --: | --: | --: | --: | --: |");
    table(out, "uniform", &uniform, reference);
    table(out, "adaptive", &adaptive, reference);
    let mut plot = LinePlot::new()
        .title("The cylinder's J")
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis("|J − J_{h}|/J", Scale::Logarithmic)
        .grid()
        .size(360.0, 280.0);
    for (name, rows) in [("adaptive", &adaptive), ("uniform", &uniform)] {
        let (x, y): (Vec<f64>, Vec<f64>) = rows
            .iter()
            .map(|row| (row.unknowns as f64, ((reference - row.criterion) / reference).abs()))
            .unzip();
        plot = plot.curve(Curve::new(name, &x, &y));
    }
    let path = options.out.join("adaptive_cylinder.png");
    plot.write_png(&path)?;
    out.line(format!("Written: {}", path.display()));
    Ok(())
}

fn main() -> ExitCode {
    program_with_options(run)
}
