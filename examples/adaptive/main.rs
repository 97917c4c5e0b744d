//! Adaptive meshes compared with uniform ones, for a goal with a dual-weighted estimate and for norms with a residual estimator:
//! the tables and pictures of examples/results.md.
//!
//! `cargo run --release --bin adaptive`

mod figures;
mod l_shape;
mod membrane;
mod options;
mod study;
mod transition;

use std::error::Error;
use std::process::ExitCode;

use forms_examples::command_line::program_with_options;
use forms_fem::output::StandardOutput;

use options::Options;
use study::{Row, Study, order};

/// Errors of writing files have no common type.
type Outcome<T> = Result<T, Box<dyn Error>>;

/// Rows of a table that are shown: about one per doubling of the unknowns, and the last.
fn shown(rows: &[Row]) -> Vec<Row> {
    let mut shown: Vec<Row> = vec![];
    for (index, row) in rows.iter().enumerate() {
        let far = shown.last().is_none_or(|last| row.unknowns >= 2 * last.unknowns);
        if far || index + 1 == rows.len() {
            shown.push(*row);
        }
    }
    shown
}

/// Prints a study.
fn table(out: &mut StandardOutput, study: &Study) {
    out.line(format!("\n{}\n", study.name));
    out.line("| meshes | unknowns | error | estimate / error |");
    out.line("| --- | --- | --- | --- |");
    for (name, rows) in [("uniform", &study.uniform), ("adaptive", &study.adaptive)] {
        for Row { unknowns, error, estimate } in shown(rows) {
            out.line(format!("| {name} | {unknowns} | {error:.3e} | {:.4} |", estimate / error));
        }
        if let Some(order) = order(rows) {
            out.line(format!("| {name} | | N^{order:.2} | |"));
        }
    }
    if let (Some(last), Some(unknowns)) = (study.uniform.last(), study.unknowns_for_the_same_error()) {
        out.line(format!(
            "\nThe error of {} unknowns refined everywhere takes {unknowns} adaptive ones.",
            last.unknowns
        ));
    }
}

fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    // Before the long computation: its results can be written.
    std::fs::create_dir_all(&options.out)
        .map_err(|error| format!("the output directory {} cannot be used: {error}", options.out.display()))?;
    let file = |name: &str| options.out.join(name);

    let corner = l_shape::goal(options.unknowns)?;
    table(out, &corner);
    let displacement = transition::displacement(options.unknowns)?;
    table(out, &displacement);
    let adjoint = transition::adjoint(options.unknowns)?;
    table(out, &adjoint);
    let discrete = transition::discrete_adjoint(options.unknowns)?;
    table(out, &discrete);
    for theta in [-1.0, 0.0, 1.0] {
        table(out, &transition::goal(options.unknowns, theta)?);
    }
    let written = [
        figures::errors("L-shape", "|J − J_{h}|", &[("J", &corner)], &file("adaptive_l_shape.png"))?,
        figures::mesh("L-shape, for J", &corner, &file("adaptive_l_shape_mesh.png"))?,
        figures::errors(
            "Scalar Signorini, degree 2, θ = −1",
            "error in H^{1}",
            &[("u", &displacement), ("p (22)", &adjoint), ("p (21)", &discrete)],
            &file("adaptive_contact.png"),
        )?,
        figures::mesh("Scalar Signorini, for u", &displacement, &file("adaptive_contact_mesh.png"))?,
    ];
    for path in written {
        out.line(format!("Written: {}", path.display()));
    }
    Ok(())
}

fn main() -> ExitCode {
    program_with_options(run)
}
