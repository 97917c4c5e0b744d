//! The paper's hollow cylinder on meshes that follow the error: Figures 3 and 5 continued, and J to a tolerance.
//!
//! `cargo run --release --bin adaptive_cylinder`

mod goal;
mod states;
mod study;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use forms_contact::hollow_cylinder::Settings;
use forms_examples::command_line::program_with_options;
use forms_fem::output::StandardOutput;
use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};

use states::{ContactFacets, Variant};
use study::{Meshes, Reference, Row, series};

/// Errors of writing files have no common type.
type Outcome<T> = Result<T, Box<dyn Error>>;

/// The paper's cylinder on adaptive meshes compared with uniform ones: errors of u and of the three adjoint states against a reference on a
/// finer adaptive mesh, and J to a tolerance.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "adaptive_cylinder")]
struct Options {
    /// Unknowns at which the series end
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    unknowns: usize,
    /// Unknowns of the reference, at least
    #[arg(long, value_name = "N", default_value_t = 45_000)]
    reference: usize,
    /// θ of Nitsche's method
    #[arg(long, allow_negative_numbers = true, default_value_t = -1.0)]
    theta: f64,
    /// |η| within this part of J ends the adaptive meshes for J
    #[arg(long, default_value_t = 1e-6)]
    tolerance: f64,
    /// γ₀ of the meshes on which η is compared with the error of J, in units of Young's modulus; all else has 10
    #[arg(long, value_name = "N", default_value_t = 40.0)]
    gamma0: f64,
    /// The integration over contact facets
    #[arg(long, value_enum, default_value_t = ContactFacets::Split)]
    contact_facets: ContactFacets,
    /// Directory of the pictures; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/adaptive_cylinder")]
    out: PathBuf,
}

impl Options {
    /// The variant whose states are computed.
    fn variant(&self) -> Variant {
        let gamma0_over_young = Settings::default().gamma0_over_young;
        Variant { theta: self.theta, gamma0_over_young, facets: self.contact_facets }
    }
}

const QUANTITIES: [&str; 4] = ["u (14)", "p (22)", "p (21)", "p (41)"];

/// Errors over unknowns of one quantity.
fn curve(title: &str, rows: &[Row], quantity: usize) -> Curve {
    let (x, y): (Vec<f64>, Vec<f64>) =
        rows.iter().map(|row| (row.unknowns as f64, row.errors[quantity])).unzip();
    Curve::new(title, &x, &y)
}

/// The number of rows to which s in error ~ Nˢ is fitted: those with at least a quarter of the last one's unknowns, at least three.
/// The first meshes gain by being fine where nothing was yet.
fn fitted(rows: &[Row]) -> usize {
    let least = rows.last().map_or(0, |row| row.unknowns / 4);
    rows.iter().filter(|row| row.unknowns >= least).count().max(3)
}

/// Prints the errors on meshes of one kind: about one row per doubling of the unknowns, and the last.
fn table(out: &mut StandardOutput, name: &str, rows: &[Row]) {
    let print = |out: &mut StandardOutput, row: &Row| {
        let errors = row.errors.map(|error| format!("{error:.3e}")).join(" | ");
        out.line(format!("| {name} | {} | {errors} |", row.unknowns));
    };
    let mut last = 0;
    for (index, row) in rows.iter().enumerate() {
        if row.unknowns >= 2 * last || index + 1 == rows.len() {
            print(out, row);
            last = row.unknowns;
        }
    }
    let orders = [0, 1, 2, 3].map(|quantity| {
        let order = curve("", rows, quantity).order(fitted(rows));
        order.map_or(String::new(), |s| format!("N^{s:.2}"))
    });
    out.line(format!("| {name} | order | {} |", orders.join(" | ")));
}

fn study(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    // Two references: their difference says how far the last one can be trusted.
    let (mut earlier, mut fine) = (None, None);
    let shown = series(Meshes::ForBoth, options, options.reference, |states| {
        earlier = fine.take();
        fine = Some(states);
        Ok(())
    })?;
    let reference = Reference::new(fine.ok_or("no reference")?)?;
    out.line(format!("reference: {} unknowns, {} cells", reference.unknowns(), shown.cell_count()));
    if let Some(earlier) = earlier {
        let Row { unknowns, errors } = reference.errors(&earlier)?;
        out.line(format!(
            "the mesh before it, {unknowns} unknowns, differs by {:.3e} in u and {:.3e} in p",
            errors[0], errors[1]
        ));
    }
    out.line(format!("\n| meshes | unknowns | {} |", QUANTITIES.join(" | ")));
    out.line("| --- | --- | --- | --- | --- | --- |");
    let mut all: Vec<(&str, Vec<Row>)> = vec![];
    for (name, meshes) in
        [("uniform", Meshes::Uniform), ("for u", Meshes::ForDisplacement), ("for p", Meshes::ForAdjoint)]
    {
        let mut rows = vec![];
        series(meshes, options, options.unknowns, |states| {
            rows.push(reference.errors(&states)?);
            Ok(())
        })?;
        table(out, name, &rows);
        all.push((name, rows));
    }
    let mut plot = LinePlot::new()
        .title("Hollow cylinder, degree 2")
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis("relative error in H^{1}", Scale::Logarithmic)
        .grid()
        .size(400.0, 320.0);
    // p of (41) lies on p of (22) except for the last meshes: the table has it.
    for (quantity, adapted) in [(0, 1), (1, 2), (2, 2)] {
        let (adaptive, uniform) = (&all[adapted].1, &all[0].1);
        let name = QUANTITIES[quantity];
        plot = plot
            .curve(curve(&format!("{name}, adaptive"), adaptive, quantity).fitted_order(fitted(adaptive)))
            .curve(
                curve(&format!("{name}, uniform"), uniform, quantity).dashed().fitted_order(fitted(uniform)),
            );
    }
    plot.write_png(options.out.join("adaptive_cylinder.png"))?;
    Ok(())
}

fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    // Before the long computation: its results can be written.
    std::fs::create_dir_all(&options.out)
        .map_err(|error| format!("the output directory {} cannot be used: {error}", options.out.display()))?;
    goal::to_tolerance(options, out)?;
    goal::effectivity(options, out)?;
    study(options, out)
}

fn main() -> ExitCode {
    program_with_options(run)
}
