//! Shape optimisation under contact: the paper's Figure 6, a ring that spreads its pressure, a cantilever on a support.

mod cantilever;
mod meshes;
mod options;
mod pictures;
mod ring;
mod runs;

use std::error::Error;
use std::process::ExitCode;

use forms_contact::Adjoint;
use forms_contact::shape_problem::Criterion;
use forms_examples::command_line::program_with_options;
use forms_examples::memory;
use forms_fem::output::StandardOutput;
use forms_fem::shape_optimisation::{Rotations, ShapeProblem, boundary_distance, perimeter};
use forms_fem::space::Space;

use options::{Case, Options};
use runs::Run;

/// Errors have no common type.
type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> ExitCode {
    program_with_options(run)
}

fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    if !options.any_memory {
        let unknowns = options.unknowns();
        // The contact problem's factors, those of the inner product on as many unknowns, and fields of every shape tried:
        // 396 MB were measured on 49,152 unknowns.
        let bytes = 3.1 * memory::of_contact(unknowns);
        memory::check(&format!("--cells-per-side {}", options.cells_per_side()), unknowns, bytes)?;
    }
    let initial = match options.case {
        Case::Cantilever => cantilever::mesh(options)?,
        _ => ring::mesh(options)?,
    };
    let mut problems = match options.case {
        Case::Figure6 => vec![
            ("adjoint_22", "(22)", ring::shape_problem(&initial, Criterion::Paper, Adjoint::Consistent)?),
            ("adjoint_21", "(21)", ring::shape_problem(&initial, Criterion::Paper, Adjoint::Discrete)?),
        ],
        Case::EvenPressure => {
            let variation = Criterion::PressureVariation { over: ring::EVEN_OVER };
            vec![("even_pressure", "(21)", ring::shape_problem(&initial, variation, Adjoint::Discrete)?)]
        }
        Case::Cantilever => vec![("cantilever", "(21)", cantilever::shape_problem(&initial)?)],
    };
    for (.., problem) in &mut problems {
        let criterion = problem.solve(&initial)?.criterion.abs();
        problem.perimeter_penalty =
            options.perimeter_penalty() * criterion / perimeter(&initial, &problem.moving)?;
    }
    let pattern = match options.case {
        Case::Cantilever => None,
        _ => Some(Rotations::new(&*Space::of_geometry(&initial)?, [0.0; 2], options.holes)?),
    };
    let mut finished = Vec::new();
    for (name, number, problem) in &problems {
        finished.push(Run::new(options, &initial, name, number, problem, pattern.clone())?);
    }
    out.line(runs::table(&finished));
    if let [first, second] = finished.as_slice() {
        let apart = boundary_distance(&first.mesh, &second.mesh, "holes")?;
        let moved = boundary_distance(&initial, &first.mesh, "holes")?;
        let relative = |length: f64| 100.0 * length / options.hole_radius;
        out.line(format!(
            "Between the two optimal shapes: at most {:.3} %, in the mean {:.3} % of a hole's radius",
            relative(apart.largest),
            relative(apart.mean)
        ));
        out.line(format!(
            "From the round holes to the first: at most {:.2} %, in the mean {:.2} %",
            relative(moved.largest),
            relative(moved.mean)
        ));
    }
    for file in pictures::write_all(options, &initial, &finished)? {
        out.line(format!("Written: {}", file.display()));
    }
    Ok(())
}
