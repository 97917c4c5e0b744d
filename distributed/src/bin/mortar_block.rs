//! A block that is drawn along a slab with friction by multipliers or means on moving segments, on the processes that started this:
//! `mpirun -n 4 mortar_block [means | hats | bernstein | dual | dual_of_bernstein] [block | slab] [direct | gmres] [cells]`. Tells the
//! last state, the force and the steps of Newton's method; of `gradient` in place of a method, a criterion and its gradient by friction.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::mortar_block::MortarBlock;
use forms_distributed::cases::report::tell;
use forms_distributed::{Method, PetscSolver, World};
use forms_fem::inverse::ReducedProblem;
use forms_fem::prelude::*;

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let given = |place, default: &str| std::env::args().nth(place).unwrap_or_else(|| default.to_owned());
    let (name, own, method) = (given(1, "hats"), given(2, "block"), given(3, "direct"));
    let block = MortarBlock::of(&name, given(4, "4").parse()?, own == "slab")?;
    if method == "gradient" {
        let traces = block.multipliers(&name)?;
        let (held, free) = (block.held(0)?, Constraints::new(&traces));
        let mut solver = PetscSolver::coupled(world, &[&held, &free, &free], Method::Direct)?;
        let history = block.history(&traces);
        let m = history.start();
        let found = history.on(world).solver(&mut solver).gradient(&m)?;
        tell(world, "value", &[found.value]);
        tell(world, "gradient", &found.gradient);
        return Ok(());
    }
    let method = match Method::named(&method)? {
        Method::Gmres { max_iterations, .. } => Method::Gmres { tolerance: 1e-12, max_iterations },
        method => method,
    };
    let drawn = block.drawn(&name, Some((world, method)))?;
    tell(world, "steps", &drawn.steps);
    tell(world, "iterations", &drawn.iterations);
    tell(world, "force", &[drawn.force]);
    for (field, name) in drawn.fields.iter().zip(["u", "multipliers", "means"]) {
        tell(world, name, field.values());
    }
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
