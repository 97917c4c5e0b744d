//! Time and memory of a value and of a gradient, and the gradient's error compared with differences.

use std::error::Error;
use std::time::Instant;

use forms_fem::inverse::{LoadHistory, ReducedProblem};
use forms_fem::output::StandardOutput;

/// Steps of the differences.
const STEPS: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];

/// The heading of the lines of [`line()`].
pub const HEADING: &str = "| cells | unknowns | value | seconds of the first value | of a value | of value and gradient | processor seconds of both | of which in factor and solves | error by step 1e-1, 1e-2, … 1e-5 | peak memory [MB] |\n| --- | --: | --: | --: | --: | --: | --: | --: | --- | --: |";

/// Prints a line: sizes, J, seconds, the error of the gradient along a direction by central differences, relative to the slope.
pub fn line(
    name: &str,
    unknowns: usize,
    problem: &mut LoadHistory<'_, 3>,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    let m = problem.start();
    let begun = Instant::now();
    problem.value(&m)?;
    let first = begun.elapsed().as_secs_f64();
    let (value, of_value, _) = repeated(|| problem.value(&m))?;
    let mut in_solver = 0.0;
    let ((_, gradient), of_both, processor) = repeated(|| {
        let before = solver_seconds(problem);
        let found = problem.value_and_gradient(&m);
        in_solver = solver_seconds(problem) - before;
        found
    })?;
    let direction: Vec<f64> = (0..m.len()).map(|k| 0.1 + (0.7 * k as f64).sin()).collect();
    let slope: f64 = gradient.iter().zip(&direction).map(|(gradient, along)| gradient * along).sum();
    let mut errors = vec![];
    for step in STEPS {
        let mut at = |t: f64| {
            let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + t * along).collect();
            problem.value(&moved)
        };
        let difference = (at(step)? - at(-step)?) / (2.0 * step);
        errors.push(format!("{:.0e}", ((difference - slope) / slope).abs()));
    }
    let (errors, memory) = (errors.join(", "), peak_memory());
    out.line(format!(
        "| {name} | {unknowns} | {value:.9} | {first:.4} | {of_value:.4} | {of_both:.4} | {processor:.4} | {in_solver:.4} | {errors} | {memory} |"
    ));
    Ok(())
}

/// Seconds of factorisations and solves so far.
fn solver_seconds(problem: &mut LoadHistory<'_, 3>) -> f64 {
    problem.solver_report().map_or(f64::NAN, |report| report.factorisation_seconds + report.solve_seconds)
}

/// The result of a computation, its seconds by the clock, and those of all threads: means over repetitions that take half a second in
/// all, after one that does not count.
fn repeated<T, E>(mut compute: impl FnMut() -> Result<T, E>) -> Result<(T, f64, f64), E> {
    compute()?;
    let (begun, begun_processor) = (Instant::now(), processor_seconds());
    let mut repetitions = 0.0;
    loop {
        let found = compute()?;
        repetitions += 1.0;
        let elapsed = begun.elapsed().as_secs_f64();
        if elapsed > 0.5 {
            let processor =
                processor_seconds().zip(begun_processor).map_or(f64::NAN, |(now, begun)| now - begun);
            return Ok((found, elapsed / repetitions, processor / repetitions));
        }
    }
}

/// Processor time of the process, all threads, in hundredths of a second as Linux counts it.
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // User and system time are twelfth and thirteenth after the name, which is in parentheses.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

/// The most memory that the process has held \[MB\], where the system tells it.
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kilobytes.map_or_else(|| "?".to_owned(), |kilobytes| format!("{:.0}", kilobytes / 1024.0))
}
