//! A motion step by step, on the processes that started this: `mpirun -n 4 motions [impact | explicit | lumped | porous] [steps]`. MUMPS solves;
//! tells the values and rates of all unknowns.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::motions::Motion;
use forms_distributed::cases::report::tell;
use forms_distributed::{Method, PetscSolver, World};

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let given = |place| std::env::args().nth(place);
    let motion = Motion::named(given(1).as_deref().unwrap_or("impact"))?;
    let steps = given(2).map_or(Ok(8), |number| number.parse())?;
    let conditions = motion.conditions()?;
    let conditions_of_all: Vec<_> = conditions.iter().collect();
    let mut solver = PetscSolver::coupled(world, &conditions_of_all, Method::Direct)?;
    let (begun, size) = motion.begin(&conditions)?;
    let mut begun = begun.on(world).solver(&mut solver);
    for _ in 0..steps {
        begun.take(size)?;
    }
    for (number, state) in begun.states().iter().enumerate() {
        tell(world, &format!("value{number}"), state.value.values());
        tell(world, &format!("rate{number}"), state.rate.values());
    }
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
