//! Elasticity of degree 2 in space on the processes that started this:
//! `mpirun -n 4 hanging_block [cells along an edge] [direct | cg] [u]`. Tells seconds and iterations, and u where asked for.
//! `hanging_block [cells along an edge] multigrid [threads]` is the same in one process by `forms_fem` only.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_distributed::cases::hanging_block::HangingBlock;
use forms_distributed::cases::parts::Case;
use forms_distributed::cases::report::{largest, peak, tell};
use forms_distributed::{Method, PetscSolver, TOLERANCE, World};
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let given = |place| std::env::args().nth(place);
    let divisions = given(1).map_or(Ok(4), |number| number.parse())?;
    let name = given(2).unwrap_or_else(|| "cg".to_owned());
    let start = Instant::now();
    let block = HangingBlock::new(divisions, Given::constant([0.0, 0.0, -1.0]))?;
    if name == "multigrid" && world.size() == 1 {
        let threads = given(3).map_or(Ok(1), |number| number.parse())?;
        return by_multigrid(world, block, Threads::new(threads), start);
    }
    let method = Method::named(&name)?;
    let HangingBlock { form, space, constraints } = block;
    let mut solver = PetscSolver::new(world, &constraints, method)?;
    let solved = Problem::new(&form, &space)
        .threads(Threads::new(1))
        .on(world)
        .constrained(&constraints)
        .solver(&mut solver)
        .solve()?;
    let seconds = start.elapsed().as_secs_f64();
    let (u, report) = (solved.field(), solver.report());
    tell(world, "unknowns", &[space.unknowns() as f64]);
    tell(world, "iterations", &report.iterations.iter().map(|count| *count as f64).collect::<Vec<_>>());
    tell(world, "residual", &[report.largest_residual]);
    tell(world, "matrix_seconds", &[report.assembly_seconds]);
    tell(world, "solve_seconds", &[report.solve_seconds]);
    tell(world, "seconds", &[seconds]);
    tell(world, "megabytes", &[largest(world, peak())?]);
    tell(world, "size", &[solved.functional(&Case::size(u))?]);
    if given(3).as_deref() == Some("u") {
        tell(world, "u", u.values());
    }
    Ok(())
}

/// The multigrid of `forms_fem`, to the same tolerance, for a block that was made from `start` on.
fn by_multigrid(
    world: &World,
    block: HangingBlock,
    threads: Threads,
    start: Instant,
) -> Result<(), Box<dyn Error>> {
    let HangingBlock { form, space, constraints } = block;
    let assembler = Assembler::new(space.mesh()).with_threads(threads);
    let options =
        MultigridSolverOptions { tolerance: TOLERANCE, threads, ..MultigridSolverOptions::default() };
    let mut solver = MultigridSolver::new(&constraints, options)?;
    let solved = Problem::new(&form, &space)
        .assembler(&assembler)
        .constrained(&constraints)
        .solver(&mut solver)
        .solve()?;
    let seconds = start.elapsed().as_secs_f64();
    let report = solver.report();
    tell(world, "unknowns", &[space.unknowns() as f64]);
    tell(world, "iterations", &report.iterations.iter().map(|count| *count as f64).collect::<Vec<_>>());
    tell(world, "residual", &[report.largest_residual]);
    tell(world, "solve_seconds", &[report.setup_seconds + report.solve_seconds]);
    tell(world, "seconds", &[seconds]);
    tell(world, "megabytes", &[peak()]);
    tell(world, "size", &[solved.functional(&Case::size(solved.field()))?]);
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
