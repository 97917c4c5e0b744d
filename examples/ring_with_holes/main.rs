//! The paper's Figure 6: the holes of a ring that is pressed on the ground change their shape until a criterion is least at
//! the same volume, with the adjoint states (22) and (21).

mod options;
mod pictures;
mod ring;
mod runs;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use forms_contact::shape_problem::Criterion;
use forms_contact::states::Adjoint;
use forms_fem::shape_optimisation::boundary_distance;

use options::{Goal, Options};
use runs::Run;

/// What can go wrong has no common type.
type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Outcome<()> {
    let initial = ring::mesh(options)?;
    let wanted: &[(&str, &str, Criterion, Adjoint)] = match options.criterion {
        Goal::Paper => &[
            ("adjoint_22", "(22)", Criterion::Paper, Adjoint::Consistent),
            ("adjoint_21", "(21)", Criterion::Paper, Adjoint::Discrete),
        ],
        Goal::Pressure => {
            &[("pressure", "(21)", Criterion::Unevenness { over: ring::EVEN_OVER }, Adjoint::Discrete)]
        }
    };
    let mut finished = Vec::new();
    for &(name, number, criterion, adjoint) in wanted {
        let run = Run::new(options, &initial, name, number, criterion, adjoint)?;
        finished.push(run);
    }
    println!("{}", runs::table(&finished));
    if let [first, second] = finished.as_slice() {
        let apart = boundary_distance(&first.mesh, &second.mesh, "holes")?;
        let moved = boundary_distance(&initial, &first.mesh, "holes")?;
        let relative = |length: f64| 100.0 * length / options.hole_radius;
        println!(
            "Between the two optimal shapes: at most {:.2} %, in the mean {:.2} % of a hole's radius (nodes: at most {:.2} %)",
            relative(apart.largest),
            relative(apart.mean),
            relative(apart.largest_of_nodes)
        );
        println!(
            "From the round holes to the first: at most {:.2} %, in the mean {:.2} %",
            relative(moved.largest),
            relative(moved.mean)
        );
    }
    for file in pictures::write_all(options, &initial, &finished)? {
        println!("Written: {}", file.display());
    }
    Ok(())
}
