//! A ball on a rigid flat in space on the processes that started this:
//! `mpirun -n 4 ball [cells along an edge] [θ] [direct | cg | gmres]`. Tells u, J and the contact force.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::ball_on_flat::ball_on_flat;
use forms_distributed::cases::report::{tell, tell_steps};
use forms_distributed::{Method, PetscSolver, World, distributed_functional};

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let given = |place| std::env::args().nth(place);
    let divisions = given(1).map_or(Ok(4), |number| number.parse())?;
    let theta = given(2).map_or(Ok(-1.0), |number| number.parse())?;
    let method = Method::named(given(3).as_deref().unwrap_or("direct"))?;
    let problem = ball_on_flat(divisions, theta)?;
    let mut solver = PetscSolver::new(world, &problem.constraints, method)?;
    let solved = problem.direct()?.on(world).solver(&mut solver).solve()?;
    let (u, law) = (solved.field(), &problem.law);
    tell_steps(world, &solved.history);
    tell(world, "J", &[distributed_functional(world, &problem.assembler, &law.criterion(u))?]);
    tell(world, "force", &[distributed_functional(world, &problem.assembler, &law.contact_force(u))?]);
    tell(world, "u", u.values());
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
