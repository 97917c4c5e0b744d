//! The paper's hollow cylinder on the processes that started this: `mpirun -n 4 cylinder [cells across the thickness]`.
//! MUMPS solves; tells u, the discrete adjoint state, J and the contact force.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::hollow_cylinder::{Settings, hollow_cylinder};
use forms_contact::Adjoint;
use forms_distributed::cases::report::{tell, tell_steps};
use forms_distributed::{DistributedContact, Method, PetscSolver, World};
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let radial = std::env::args().nth(1).map_or(Ok(4), |number| number.parse())?;
    let settings = Settings { radial, threads: Threads::new(1), ..Settings::default() };
    let contact = DistributedContact::new(world, hollow_cylinder(&settings)?)?;
    let mut solver = PetscSolver::new(world, &contact.problem().constraints, Method::Direct)?;
    let solved = contact.direct()?.solver(&mut solver).solve()?;
    let u = solved.field;
    let adjoint = contact.solve_adjoint(Adjoint::Discrete, &u, &mut solver)?;
    tell_steps(world, &solved.history);
    tell(world, "J", &[contact.criterion(&u)?]);
    tell(world, "force", &[contact.contact_force(&u)?]);
    tell(world, "u", u.values());
    tell(world, "adjoint", adjoint.values());
    tell(world, "residual", &[solver.report().largest_residual]);
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
