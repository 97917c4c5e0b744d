//! A nearly incompressible block with the pressure as an unknown, on the processes that started this:
//! `mpirun -n 4 mixed_block [cells along an edge] [direct | gmres]`. Tells both unknowns and the iterations.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::report::tell;
use forms_distributed::{Method, PetscSolver, World};

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let given = |place| std::env::args().nth(place);
    let divisions = given(1).map_or(Ok(4), |number| number.parse())?;
    let method = match Method::named(given(2).as_deref().unwrap_or("direct"))? {
        // Pressures are 1000 times as sensitive as displacements.
        Method::Gmres { max_iterations, .. } => Method::Gmres { tolerance: 1e-12, max_iterations },
        method => method,
    };
    let block = MixedBlock::new(divisions)?;
    let mut solver =
        PetscSolver::coupled(world, &[&block.held, &block.free], method)?.with_options_prefix("block_")?;
    let solved = block.problem().on(world).solver(&mut solver).solve()?;
    let [u, p] = &solved.fields;
    let report = solver.report();
    tell(world, "iterations", &report.iterations.iter().map(|count| *count as f64).collect::<Vec<_>>());
    tell(world, "residual", &[report.largest_residual]);
    tell(world, "u", u.values());
    tell(world, "p", p.values());
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
