//! ∫ u of Poisson's equation on the unit square, as each process has it from the solution: `mpirun -n 4 total`.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::World;
use forms_distributed::cases::poisson::{Given, Poisson};
use forms_distributed::cases::report::tell;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let problem = Poisson::new(Given::default())?;
    let solved = problem.solve(world)?;
    let mut totals = vec![0.0; world.size()];
    totals[world.rank()] = problem.total(&solved)?;
    tell(world, "totals", &world.sum(&totals)?);
    tell(world, "u", solved.field().values());
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
