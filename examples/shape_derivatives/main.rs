//! The shape derivative of the paper's cylinder in four ways, on free, clamped and contact boundary: the table of
//! README.md next to this file.
//!
//! `cargo run --release --bin shape_derivatives -- --finest 64`

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use forms_contact::boundary_form::boundary_form;
use forms_contact::hollow_cylinder::{
    CONTACT, INNER_RADIUS, OUTER_RADIUS, Settings, hollow_cylinder, hollow_cylinder_on,
};
use forms_contact::shape_gradient::Diameters;
use forms_contact::{Adjoint, ContactProblem};
use forms_examples::command_line::program_with_options;
use forms_examples::memory;
use forms_fem::output::{StandardOutput, tell};
use forms_fem::prelude::*;

/// The shape derivative of the paper's cylinder in four ways.
#[derive(Parser)]
struct Options {
    /// The finest mesh: cells across the thickness.
    #[arg(long, default_value_t = 64)]
    finest: usize,
    /// θ of Nitsche's method.
    #[arg(long, default_value_t = -1.0, allow_hyphen_values = true)]
    theta: f64,
    /// Central differences are taken up to this number of cells across the thickness.
    #[arg(long, default_value_t = 8)]
    differences: usize,
    /// Runs even if the estimated memory exceeds what is available.
    #[arg(long)]
    any_memory: bool,
}

/// Which boundary moves.
#[derive(Clone, Copy)]
enum Piece {
    Free,
    Clamped,
    Contact,
}

const PIECES: [(Piece, &str); 3] =
    [(Piece::Free, "free"), (Piece::Clamped, "clamped"), (Piece::Contact, "contact")];

/// Step of the central differences, in units of Θ, which is about 1 cm.
const STEP: f64 = 1e-3;

impl Piece {
    /// A smooth radial movement of one piece: of the outer circle above, of the inner circle, of the outer circle below.
    fn movement(self, x: &[f64; 2]) -> [f64; 2] {
        let radius = x[0].hypot(x[1]);
        let outwards = (radius - INNER_RADIUS) / (OUTER_RADIUS - INNER_RADIUS);
        let weight = match self {
            Piece::Free => outwards * (x[1] / radius).max(0.0).powi(3),
            Piece::Clamped => {
                (1.0 - outwards) * (1.0 + x[0] * x[1] / (radius * radius) - 0.5 * x[1] / radius)
            }
            Piece::Contact => outwards * (-x[1] / radius).max(0.0).powi(3),
        };
        x.map(|x| weight * x / radius)
    }

    fn region(self) -> &'static str {
        match self {
            Piece::Free => "outer",
            Piece::Clamped => "inner",
            Piece::Contact => CONTACT,
        }
    }
}

/// DJ along a movement.
struct Derivatives {
    volume: f64,
    boundary_consistent: f64,
    boundary_discrete: f64,
    /// The volume form less what it has without an adjoint state.
    adjoint_part: f64,
    difference: Option<f64>,
}

fn criterion(problem: &ContactProblem<2>) -> Result<(f64, Field<2>), Box<dyn Error>> {
    let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
    let u = problem.direct()?.options(options).solve()?.into_field();
    Ok((problem.criterion(&u)?, u))
}

fn measure(settings: &Settings, with_differences: bool) -> Result<Vec<Derivatives>, Box<dyn Error>> {
    let problem = hollow_cylinder(settings)?;
    let (_, u) = criterion(&problem)?;
    let mut solver = TangentSolver::default();
    let discrete = problem.solve_adjoint(Adjoint::Discrete, &u, &mut solver)?.into_field();
    let consistent = problem.solve_adjoint(Adjoint::Consistent, &u, &mut solver)?.into_field();
    let gradient = problem.shape_gradient(&u, &discrete, Diameters::Moving, None)?;
    let imposed = forms_contact::hollow_cylinder::IMPOSED_DISPLACEMENT;
    let data = boundary_form::data_from(problem.law.data.clone()).imposed(imposed);
    let assembler = &problem.assembler;
    let mut all = Vec::new();
    for (piece, _) in PIECES {
        let along = Field::interpolate(&gradient.movements, |x| piece.movement(x))?;
        let region = piece.region();
        let boundary = |p: &Field<2>| match piece {
            Piece::Free => {
                let form = boundary_form::on_free(&data, &boundary_form::Free::on(region), &u, p, &along);
                assembler.functional(&form)
            }
            Piece::Clamped => {
                let form =
                    boundary_form::on_clamped(&data, &boundary_form::Clamped::on(region), &u, p, &along);
                assembler.functional(&form)
            }
            Piece::Contact => {
                let form =
                    boundary_form::on_contact(&data, &boundary_form::Contact::on(region), &u, p, &along);
                assembler.functional(&form)
            }
        };
        let volume = gradient.along(&along)?;
        let explicit = boundary_form::explicit_on_free(&data, &boundary_form::Free::on(region), &u, &along);
        let moved = |step: f64| -> Result<f64, Box<dyn Error>> {
            Ok(criterion(&hollow_cylinder_on(&along.move_mesh(step)?, settings)?)?.0)
        };
        let difference = match with_differences {
            true => Some((moved(STEP)? - moved(-STEP)?) / (2.0 * STEP)),
            false => None,
        };
        all.push(Derivatives {
            volume,
            boundary_consistent: boundary(&consistent)?,
            boundary_discrete: boundary(&discrete)?,
            adjoint_part: volume - assembler.functional(&explicit)?,
            difference,
        });
    }
    Ok(all)
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    if !options.any_memory {
        let unknowns = Settings { radial: options.finest, ..Settings::default() }.unknowns();
        memory::check(&format!("--finest {}", options.finest), unknowns, memory::of_contact(unknowns))?;
    }
    let meshes: Vec<usize> = std::iter::successors(Some(4), |radial| Some(2 * radial))
        .take_while(|radial| *radial <= options.finest)
        .collect();
    let mut rows = Vec::new();
    for &radial in &meshes {
        let settings = Settings { radial, theta: options.theta, ..Settings::default() };
        rows.push(measure(&settings, radial <= options.differences)?);
        tell(format!("n_r = {radial}"));
    }
    for (index, (_, name)) in PIECES.iter().enumerate() {
        out.line(format!("\n### The {name} boundary moves\n"));
        out.line("| n_r | volume (21) | its adjoint part | boundary (22) off by | order | boundary (21) off by | order | central differences off by |");
        out.line("| --- | --- | --- | --- | --- | --- | --- | --- |");
        let mut before: Option<[f64; 2]> = None;
        for (radial, row) in meshes.iter().zip(&rows) {
            let Derivatives { volume, boundary_consistent, boundary_discrete, adjoint_part, difference } =
                &row[index];
            let off = |value: f64| (value - volume).abs() / adjoint_part.abs();
            let now = [off(*boundary_consistent), off(*boundary_discrete)];
            let order = |which: usize| {
                before
                    .map_or_else(|| "".into(), |before| format!("{:.2}", (before[which] / now[which]).log2()))
            };
            let difference = difference
                .map_or_else(String::new, |value| format!("{:.1e}", ((value - volume) / volume).abs()));
            out.line(format!(
                "| {radial} | {volume:.6} | {adjoint_part:.4} | {:.2e} | {} | {:.2e} | {} | {difference} |",
                now[0],
                order(0),
                now[1],
                order(1)
            ));
            before = Some(now);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    program_with_options(run)
}
