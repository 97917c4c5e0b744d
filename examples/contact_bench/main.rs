//! All formulations of contact on problems with known answers: a table, JSON and plots in out/contact_bench.
//!
//! Run it with `cargo run --release --bin contact_bench -- --problems lame,hertz --formulations all`; `--list` prints the names.

mod formulations;

use std::process::ExitCode;

fn main() -> ExitCode {
    let all = formulations::all();
    let all: Vec<&dyn contact_bench::Formulation> = all.iter().map(Box::as_ref).collect();
    contact_bench::program(&all)
}
