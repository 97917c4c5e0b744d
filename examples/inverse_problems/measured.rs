//! What a value and a gradient cost, and how far the gradient is from differences.

use std::error::Error;
use std::time::Instant;

use forms_fem::inverse::ReducedProblem;
use forms_fem::output::StandardOutput;

/// Steps of the differences.
const STEPS: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];

/// The heading of the lines of [`line`].
pub const HEADING: &str = "| cells | unknowns | value | seconds of a value | of value and gradient | error by step 1e-1, 1e-2, … 1e-5 | peak memory \\[MB\\] |\n| --- | --: | --: | --: | --: | --- | --: |";

/// Prints a line: sizes, J, seconds, the error of the gradient along a direction by central differences, relative to the slope.
pub fn line<P: ReducedProblem>(
    name: &str,
    unknowns: usize,
    problem: &mut P,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    let m = problem.start();
    let begun = Instant::now();
    let value = problem.value(&m)?;
    let of_value = begun.elapsed().as_secs_f64();
    let begun = Instant::now();
    let (_, gradient) = problem.value_and_gradient(&m)?;
    let of_both = begun.elapsed().as_secs_f64();
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
        "| {name} | {unknowns} | {value:.9} | {of_value:.3} | {of_both:.3} | {errors} | {memory} |"
    ));
    Ok(())
}

/// The most memory that the process has held \[MB\], where the system tells it.
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kilobytes.map_or_else(|| "?".to_owned(), |kilobytes| format!("{:.0}", kilobytes / 1024.0))
}
