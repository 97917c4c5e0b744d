//! Results of a program, to be read by another: lines of a name and numbers.

use std::collections::BTreeMap;
use std::error::Error;

use forms_fem::prelude::*;

use crate::world::World;

/// Prints a line with a name and numbers, exact to the last bit, on the first process.
pub fn tell(world: &World, name: &str, numbers: &[f64]) {
    let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:e}")).collect();
    world.print(format!("{name} {}", numbers.join(" ")));
}

/// Prints the iterates of Newton's method, on the first process.
pub fn tell_steps(world: &World, history: &[NewtonStep]) {
    tell(world, "steps", &[history.len() as f64 - 1.0]);
    tell(world, "residuals", &history.iter().map(|step| step.residual).collect::<Vec<_>>());
    let active = history.iter().filter_map(|step| step.active_points).map(|count| count as f64);
    tell(world, "active", &active.collect::<Vec<_>>());
}

/// The largest of all processes' numbers.
///
/// # Errors
/// Those of an exchange.
pub fn largest(world: &World, own: f64) -> Result<f64, Box<dyn Error>> {
    Ok(world.gather(own.to_bits())?.into_iter().map(f64::from_bits).fold(f64::NAN, f64::max))
}

/// The largest memory of this process so far \[MB\]; NaN where the system does not tell.
pub fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<f64>().ok());
    kibibytes.map_or(f64::NAN, |count| count * 1024.0 / 1e6)
}

/// The numbers that were reported, by their names. Lines of another kind are left out.
pub fn read(told: &str) -> BTreeMap<&str, Vec<f64>> {
    fn parts(line: &str) -> Option<(&str, Vec<f64>)> {
        let (name, numbers) = line.split_once(' ')?;
        let numbers: Result<Vec<f64>, _> = numbers.split_whitespace().map(str::parse).collect();
        Some((name, numbers.ok()?))
    }
    told.lines().filter_map(parts).collect()
}
