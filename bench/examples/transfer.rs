//! Seconds to carry a field of degree 2 between two meshes of 100,000 triangles that do not match.
//!
//! `cargo run --release -p forms-bench --example transfer [-- THREADS]`

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// Runs; the fastest is shown.
const RUNS: usize = 5;

/// The shortest time of some runs, in seconds.
fn fastest<E: Error + 'static>(mut work: impl FnMut() -> Result<Field<2>, E>) -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let start = Instant::now();
        work()?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let threads = match std::env::args().nth(1) {
        Some(count) => count.parse().map_err(|error| format!("threads \"{count}\": {error}"))?,
        None => Threads::all(),
    };
    let mesh = |divisions| rectangle([0.0; 2], [1.0; 2], divisions, CellShape::Triangle, 1);
    let (from, to) = (mesh([224, 224])?, mesh([250, 200])?);
    let wave = |x: &[f64; 2]| (3.0 * x[0]).exp() * (5.0 * x[1]).sin();
    let (source, target) = (Space::scalar(&from, 2)?, Space::scalar(&to, 2)?);
    let field = Field::interpolate(&source, wave)?;
    let transfer = field.onto(&target).with_threads(threads);
    let start = Instant::now();
    source.locator();
    out.line(format!(
        "{} to {} triangles, {} threads; boxes of the cells, once: {:.3} s",
        from.cell_count(),
        to.cell_count(),
        threads.count(),
        start.elapsed().as_secs_f64()
    ));
    out.line(format!("interpolated: {:.3} s", fastest(|| transfer.interpolated())?));
    out.line(format!("projected: {:.3} s", fastest(|| transfer.projected())?));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
