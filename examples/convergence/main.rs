//! The paper's convergence study (its Figures 3, 4 and 5) on the hollow cylinder: errors of the displacement and of the
//! three adjoint states against a finer mesh, and how far the contact zone is off. Writes CSV files and pictures.
//!
//! `cargo run --release --bin convergence -- --reference 128 --coarsest 8`

mod contact_zone;
mod figures;
mod options;
mod progress;
mod states;
mod study;
mod tables;

use std::error::Error;
use std::process::ExitCode;

use forms_examples::command_line::program_with_options;
use forms_fem::output::StandardOutput;

use options::Options;

/// Errors of writing files have no common type.
type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    program_with_options(run)
}

fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    options.check()?;
    // Before the long computation: its results can be written.
    std::fs::create_dir_all(&options.out)
        .map_err(|error| format!("the output directory {} cannot be used: {error}", options.out.display()))?;
    let mut written = Vec::new();
    for &theta in &options.theta {
        let study = study::run(options, theta)?;
        out.line(tables::summary(&study));
        written.extend(tables::write_all(&study, &options.out)?);
        written.extend(figures::write_all(&study, &options.out)?);
    }
    for path in written {
        out.line(format!("Written: {}", path.display()));
    }
    Ok(())
}
