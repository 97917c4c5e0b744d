//! Results of a program, to be read by another: lines of a name and numbers.

use std::collections::BTreeMap;

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

/// The numbers that were reported, by their names. Lines of another kind are left out.
pub fn read(told: &str) -> BTreeMap<&str, Vec<f64>> {
    fn parts(line: &str) -> Option<(&str, Vec<f64>)> {
        let (name, numbers) = line.split_once(' ')?;
        let numbers: Result<Vec<f64>, _> = numbers.split_whitespace().map(str::parse).collect();
        Some((name, numbers.ok()?))
    }
    told.lines().filter_map(parts).collect()
}
