//! Two inverse problems of a public benchmark of differentiable solvers (arXiv 2606.27895): the conductivity of a slab from
//! temperatures, and a cantilever of least compliance, with a control per cell. It prints values, gradients and differences,
//! and what they cost, for examples/results.md.
//!
//! `cargo run --release --bin inverse_problems -- heat --cells 16 32 64 --solver direct`, `structure`, `inversion`, or `motion`, which is a motion in time
//! of this project's own.

mod heat;
mod measured;
mod motion;
mod structure;

use std::error::Error;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use forms_examples::command_line::program_with_options;
use forms_fem::output::StandardOutput;

#[derive(Parser)]
#[command(about, version)]
struct Options {
    #[command(subcommand)]
    problem: Which,
}

/// The linear solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Cholesky's factor.
    Direct,
    /// Conjugate gradients with multigrid.
    Multigrid,
}

#[derive(Subcommand)]
enum Which {
    /// Compliance of a slab that conducts heat, with its gradient by a density per cell.
    Heat {
        /// Cells along the slab.
        #[arg(long, num_args = 1.., default_values_t = [16, 32, 64, 128])]
        cells: Vec<usize>,
        /// The linear solver.
        #[arg(long, value_enum, default_value = "direct")]
        solver: Method,
    },
    /// The density of the slab from the temperatures at its nodes: L-BFGS, 200 iterations.
    Inversion {
        /// Cells along the slab.
        #[arg(long, default_value_t = 16)]
        cells: usize,
    },
    /// A motion in time with its gradient by material, loads and start, by one scheme after the other.
    Motion {
        /// Cells along the body.
        #[arg(long, default_value_t = 120)]
        cells: usize,
        /// Steps in time.
        #[arg(long, default_value_t = 6)]
        steps: usize,
    },
    /// Compliance of a cantilever with its gradient, and the density that minimises it.
    Structure {
        /// Numbers of the cases: 16 × 2 × 8, 16 × 8 × 8 and 32 × 8 × 8 cells.
        #[arg(long = "case", num_args = 1.., default_values_t = [0, 1, 2], value_parser = case)]
        cases: Vec<usize>,
        /// The linear solver.
        #[arg(long, value_enum, default_value = "direct")]
        solver: Method,
        /// Iterations of L-BFGS on the smallest mesh; with 0 there is no minimisation.
        #[arg(long, default_value_t = 60)]
        iterations: usize,
    },
}

/// A number of a case of the cantilever.
fn case(text: &str) -> Result<usize, String> {
    let last = structure::DIVISIONS.len() - 1;
    text.parse().ok().filter(|case| *case <= last).ok_or_else(|| format!("there are the cases 0 to {last}"))
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    match &options.problem {
        Which::Heat { cells, solver } => heat::costs(cells, *solver, out),
        Which::Inversion { cells } => heat::inversion(*cells, out),
        Which::Motion { cells, steps } => motion::costs(*cells, *steps, out),
        Which::Structure { cases, solver, iterations } => structure::costs(cases, *solver, *iterations, out),
    }
}

fn main() -> ExitCode {
    program_with_options(run)
}
