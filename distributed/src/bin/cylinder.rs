//! The paper's hollow cylinder on the processes that started this: `mpirun -n 4 cylinder [cells across the thickness] [split | gmres]`.
//! With `split` facets are split where contact ends. MUMPS solves, or GMRES; tells u, the discrete adjoint state, J and the contact force.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::hollow_cylinder::{Settings, hollow_cylinder};
use forms_distributed::cases::report::{tell, tell_steps};
use forms_distributed::{Method, PetscSolver, World, distributed_functional};
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let radial = std::env::args().nth(1).map_or(Ok(4), |number| number.parse())?;
    let settings = Settings { radial, threads: Threads::new(1), ..Settings::default() };
    let mut problem = hollow_cylinder(&settings)?;
    let mut method = Method::Direct;
    match std::env::args().nth(2).as_deref() {
        Some("split") => problem = problem.with_split_facets(),
        // So that Newton's method takes the same steps.
        Some("gmres") => method = Method::Gmres { tolerance: 1e-13, max_iterations: 500 },
        _ => {}
    }
    let mut solver = PetscSolver::new(world, &problem.constraints, method)?;
    let solved = problem.direct()?.on(world).solver(&mut solver).solve()?;
    let (u, law) = (solved.field(), &problem.law);
    let adjoint = problem.adjoint(u)?.on(world).solver(&mut solver).solve()?;
    tell_steps(world, &solved.history);
    tell(world, "J", &[distributed_functional(world, &problem.assembler, &law.criterion(u))?]);
    tell(world, "force", &[distributed_functional(world, &problem.assembler, &law.contact_force(u))?]);
    tell(world, "u", u.values());
    tell(world, "adjoint", adjoint.field().values());
    tell(world, "residual", &[solver.report().largest_residual]);
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
