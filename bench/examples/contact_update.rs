//! Cost of a Newton step's update of the tangent on finer and finer meshes of the hollow cylinder.
//!
//! `cargo run --release -p forms-bench --example contact_update [-- THREADS]`
//!
//! Only the contact integrals depend on the iterate, so the update costs a time per contact facet, whatever the
//! number of cells. It also prints the assembly of everything from scratch.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_contact::hollow_cylinder::{CONTACT, Settings, hollow_cylinder};
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::NonlinearProblem;

/// Least seconds of some runs.
fn best<E>(runs: usize, mut run: impl FnMut() -> Result<(), E>) -> Result<f64, E> {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let start = Instant::now();
        run()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let threads: Threads = std::env::args().nth(1).map_or(Ok(Threads::ONE), |count| count.parse())?;
    out.line(
        "| n_r | cells | contact facets | entries that change | update, µs | per facet, ns | whole, ms |",
    );
    out.line("| --- | --- | --- | --- | --- | --- | --- |");
    for radial in [4, 8, 16, 32, 64] {
        let problem = hollow_cylinder(&Settings { radial, threads, ..Settings::default() })?;
        let (mesh, space, assembler) = (problem.space.mesh(), &problem.space, &problem.assembler);
        let form = problem.law.direct();
        let mut system = Problem::new(&form, space).assembler(assembler);
        // About half of Γ_C penetrates.
        let u = Field::interpolate(space, |_| [0.0, -5.0])?;
        let changed: usize = system.changed_places()?.iter().map(|places| places.len()).sum();
        // For the iterate of the last tangent nothing would be computed.
        let other: Vec<f64> = u.values().iter().map(|value| 1.000_001 * value).collect();
        let mut iterates = [&other[..], u.values()].into_iter().cycle();
        let update = best(20, || iterates.next().map_or(Ok(()), |u| system.tangent(u).map(|_| ())))?;
        let pattern = system.pattern()?.clone();
        let mut whole = BlockMatrix::zero(pattern.sparsity());
        let assembly =
            best(3, || assembler.assemble_tangent(&form, &[&u], &[space], Parts::ALL, &pattern, &mut whole))?;
        let tangent = system.tangent(u.values())?.matrix;
        let largest = whole.values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-12 * largest;
        if tangent.values().iter().zip(whole.values()).any(differ) {
            return Err("the updated tangent is not that of an assembly from scratch".into());
        }
        let facets = mesh.facet_region(CONTACT)?.len();
        let cells = mesh.cell_count();
        let (micro, nano) = (1e6 * update, 1e9 * update / facets as f64);
        out.line(format!(
            "| {radial} | {cells} | {facets} | {changed} | {micro:.1} | {nano:.0} | {:.2} |",
            1e3 * assembly
        ));
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
