//! All formulations of contact on problems with known answers: a table, JSON and plots in out/contact_bench.
//!
//! Run it with `cargo run --release --bin contact_bench -- --problems lame,hertz --formulations all`; `--list` prints the names.
//!
//! A new formulation is a file in this folder and two lines here: `mod mine;`, and `add(&mut all, mine::all());`.

use std::process::ExitCode;

use contact_bench::Formulation;

/// All formulations, with their variants.
fn all() -> Vec<Box<dyn Formulation>> {
    let mut all = vec![];
    add(&mut all, nitsche::all());
    add(&mut all, penalty::all());
    add(&mut all, augmented_lagrangian::all());
    add(&mut all, uzawa::all());
    add(&mut all, mean_nitsche::all());
    add(&mut all, mortar::all());
    add(&mut all, bounds::all());
    add(&mut all, proximal::all());
    add(&mut all, barrier::all());
    add(&mut all, exponential::all());
    add(&mut all, third_medium::all());
    add(&mut all, cut_nitsche::all());
    all
}

fn add<F: Formulation + 'static>(all: &mut Vec<Box<dyn Formulation>>, more: Vec<F>) {
    all.extend(more.into_iter().map(|one| -> Box<dyn Formulation> { Box::new(one) }));
}

fn main() -> ExitCode {
    let all = all();
    let all: Vec<&dyn Formulation> = all.iter().map(Box::as_ref).collect();
    contact_bench::program(&all)
}
