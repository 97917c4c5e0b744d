//! Factors of the unsymmetric tangent of the hollow cylinder in contact for θ = −1: LU with partial pivoting, and LU without it on threads.
//!
//! `cargo run --release -p forms-bench --example unsymmetric_factors [-- RADIAL]`, with 32 cells across the radius unless told otherwise: 133,120
//! unknowns.

use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use forms_contact::hollow_cylinder::{Settings, hollow_cylinder};
use forms_fem::linear_algebra::{Analysis, CsrMatrix, LuFactor, Ordering, Transpose, UnpivotedLu};
use forms_fem::output::{StandardOutput, program};
use forms_fem::solve::LuSolver;
use forms_fem::threads::Threads;

/// Factorisations of each kind; the fastest counts.
const REPETITIONS: usize = 3;

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let radial: usize = std::env::args().nth(1).map_or(Ok(32), |count| count.parse())?;
    let problem = hollow_cylinder(&Settings { radial, theta: -1.0, ..Settings::default() })?;
    let mut solver = LuSolver::default();
    problem.direct()?.solver(&mut solver).solve()?;
    let matrix = solver.matrix().ok_or("no matrix was factored")?;
    out.line(format!("{} unknowns, asymmetry {:.1e}", matrix.rows(), matrix.asymmetry()?));
    out.line("| factor | threads | factorisation, s | solve, ms | backward error |");
    out.line("| --- | --- | --- | --- | --- |");
    let start = Instant::now();
    let factor = LuFactor::new(matrix, None)?;
    let seconds = start.elapsed().as_secs_f64();
    row(out, matrix, ("partial pivoting", 1, seconds), |b| Ok(factor.solve_in_place(b, Transpose::No)?))?;
    drop(factor);
    let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::default())?);
    out.line(format!("analysis {:.2} s, {} entries of L", analysis.seconds(), analysis.factor_entries()));
    for threads in [1, 2, Threads::all().count()] {
        let (mut best, mut storage) = (f64::INFINITY, vec![]);
        for repetition in 1..=REPETITIONS {
            let start = Instant::now();
            let factor = UnpivotedLu::new_on(Threads::new(threads), &analysis, matrix, storage)?;
            best = best.min(start.elapsed().as_secs_f64());
            if repetition == REPETITIONS {
                let solve = |b: &mut [f64]| Ok(factor.solve_in_place(b, Transpose::No)?);
                row(out, matrix, ("without pivoting", threads, best), solve)?;
            }
            storage = factor.into_storage();
        }
    }
    Ok(())
}

/// A row of the table, with the largest residual of a solve relative to ‖A‖∞ ‖x‖∞.
fn row(
    out: &mut StandardOutput,
    matrix: &CsrMatrix,
    (name, threads, seconds): (&str, usize, f64),
    solve: impl Fn(&mut [f64]) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let b: Vec<f64> = (0..matrix.rows()).map(|k| (k as f64 * 0.7).sin()).collect();
    let mut x = b.clone();
    solve(&mut x)?;
    x.clone_from(&b);
    let start = Instant::now();
    solve(&mut x)?;
    let solved = 1e3 * start.elapsed().as_secs_f64();
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let rest: Vec<f64> = matrix.multiply(&x)?.iter().zip(&b).map(|(product, b)| b - product).collect();
    let error = largest(&rest) / (matrix.row_sum_norm() * largest(&x));
    out.line(format!("| {name} | {threads} | {seconds:.3} | {solved:.1} | {error:.1e} |"));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
