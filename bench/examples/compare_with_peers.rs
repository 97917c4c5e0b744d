//! Element kernels, whole assembly and contact of two bodies compared with FFCx, DOLFINx, GetFEM, FreeFEM and scikit-fem, in one run.
//!
//! `cargo run --release --bin compare_with_peers -- [--quick] [--only kernels|assembly|contact] [--out DIRECTORY]` writes
//! `comparison.md`, `kernels.png`, `assembly.png` and `comparison.json`. Peers that are not installed are named
//! there; `bench/README.md` says how to install them.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use forms_bench::comparison::{Options, WORKER, compare, work};
use forms_fem::output::{StandardOutput, program};

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    Kernels,
    Assembly,
    Contact,
}

/// Compares element kernels, whole assembly and contact of two bodies with other programs, side by side.
#[derive(Parser)]
struct Arguments {
    /// Few samples, and small meshes.
    #[arg(long)]
    quick: bool,
    /// Only one of the parts.
    #[arg(long)]
    only: Option<Part>,
    /// Only kernels with this in their name.
    #[arg(long)]
    forms: Option<String>,
    /// The directory of the results.
    #[arg(long, default_value = "out/comparison")]
    out: PathBuf,
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some((first, rest)) = arguments.split_first()
        && first == WORKER
    {
        return work(rest, out);
    }
    let arguments = Arguments::parse();
    let wants = |part: Part| arguments.only.is_none_or(|only| only == part);
    let options = Options {
        quick: arguments.quick,
        kernels: wants(Part::Kernels),
        assembly: wants(Part::Assembly),
        contact: wants(Part::Contact),
        directory: arguments.out,
        only_forms: arguments.forms,
    };
    let report = compare(&options)?;
    out.line(report.markdown().trim_end_matches('\n'));
    out.line(format!("Written to {}.", options.directory.display()));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
