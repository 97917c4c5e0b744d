//! A ball on a rigid flat in space on the processes that started this:
//! `mpirun -n 4 ball [cells along an edge] [θ] [direct | cg]`. Tells u, J and the contact force.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::ball_on_flat::ball_on_flat;
use forms_distributed::cases::report::{tell, tell_steps};
use forms_distributed::{DistributedContact, Method, PetscSolver, World};
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let given = |place| std::env::args().nth(place);
    let divisions = given(1).map_or(Ok(4), |number| number.parse())?;
    let theta = given(2).map_or(Ok(-1.0), |number| number.parse())?;
    let method = Method::named(given(3).as_deref().unwrap_or("direct"))?;
    let contact = DistributedContact::new(world, ball_on_flat(divisions, theta)?)?;
    let mut solver = PetscSolver::new(world, &contact.problem().constraints, method)?;
    let solved = contact.direct()?.solver(&mut solver).solve()?;
    tell_steps(world, &solved.history);
    tell(world, "J", &[contact.criterion(&solved.field)?]);
    tell(world, "force", &[contact.contact_force(&solved.field)?]);
    tell(world, "u", solved.field.values());
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
