//! The criterion of a history with its gradient, and its Hessian along a direction, on the processes that started this:
//! `mpirun -n 4 histories [creep | swing | lumped]`. MUMPS solves.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::histories::{creeping, held, swinging_motion};
use forms_distributed::cases::report::tell;
use forms_distributed::{Method, PetscSolver, World};
use forms_fem::inverse::Hessian;
use forms_fem::time::Mass;

/// The direction of the Hessian.
const DIRECTION: [f64; 2] = [0.3, -0.7];

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "creep".into());
    let held = held(&name)?;
    let mut solver = PetscSolver::new(world, &held, Method::Direct)?;
    let Hessian { value, gradient, along, .. } = match name.as_str() {
        "creep" => {
            let (history, m) = creeping(&held);
            history.on(world).solver(&mut solver).hessian(&m, &DIRECTION)?
        }
        _ => {
            let mass = if name == "lumped" { Mass::Lumped } else { Mass::Consistent };
            let (history, m) = swinging_motion(&held, mass)?;
            history.on(world).solver(&mut solver).hessian(&m, &DIRECTION)?
        }
    };
    tell(world, "value", &[value]);
    tell(world, "gradient", &gradient);
    tell(world, "along", &along);
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
