//! A cycle of adaptivity on the processes that started this: `mpirun -n 4 adaptive`. MUMPS solves; tells the estimated errors and the
//! solution on the last mesh.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::adaptive::adapted;
use forms_distributed::cases::report::tell;
use forms_distributed::{Method, PetscSolver, World};
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let found = adapted(|form, space, constraints| {
        let mut solver = PetscSolver::new(world, constraints, Method::Direct)?;
        let problem = Problem::new(form, space).threads(Threads::new(1)).constrained(constraints);
        Ok(problem.on(world).solver(&mut solver).solve()?.into_field())
    })?;
    tell(world, "estimates", &found.steps.iter().map(|step| step.estimate).collect::<Vec<_>>());
    tell(world, "u", found.solution.field.values());
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
