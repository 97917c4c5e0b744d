//! Failures on all processes, which must not leave one waiting: `mpirun -n 2 failures [assembly | convergence | twice]`.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::hanging_block::HangingBlock;
use forms_distributed::{Method, PetscSolver, World};
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let which = std::env::args().nth(1).unwrap_or_default();
    if which == "twice" {
        World::start()?;
    }
    // In the last cells of the walk the load is no number.
    let last = 0.8;
    let fails = which == "assembly";
    let weight = move |x: &[f64; 3]| [0.0, 0.0, if fails && x[0] > last { f64::NAN } else { -1.0 }];
    let HangingBlock { form, space, constraints } = HangingBlock::new(4, Given::function(weight))?;
    let assembler = Assembler::new(space.mesh()).with_threads(Threads::new(1));
    let method = Method::ConjugateGradients { tolerance: 1e-10, max_iterations: 3 };
    let mut solver = PetscSolver::new(world, &constraints, method)?;
    Problem::new(&form, &space)
        .assembler(&assembler)
        .on(world)
        .constrained(&constraints)
        .solver(&mut solver)
        .solve()?;
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
