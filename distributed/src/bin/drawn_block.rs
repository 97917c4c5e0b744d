//! A block that is drawn along a slab with friction, at large sliding, on the processes that started this:
//! `mpirun -n 4 drawn_block [cells along its side]`. MUMPS solves; tells u, the steps of Newton's method in each load step, the force
//! on the block, J of the last state and its adjoint state.

use std::error::Error;
use std::process::ExitCode;

use forms_distributed::cases::drawn_block::DrawnBlock;
use forms_distributed::cases::report::tell;
use forms_distributed::{Method, PetscSolver, World, distributed_functional};

fn run(world: &World) -> Result<(), Box<dyn Error>> {
    let cells = std::env::args().nth(1).map_or(Ok(4), |number| number.parse())?;
    let block = DrawnBlock::new(cells)?;
    let mut solver = PetscSolver::new(world, &block.held(1.0)?, Method::Direct)?;
    let (mut steps, mut before) = (vec![], None);
    let path = block.draw(|problem, step| {
        let solved = problem.direct()?.on(world).solver(&mut solver).increment(step).solve()?;
        steps.push(solved.iterations() as f64);
        before = Some(step.before.clone());
        Ok(solved)
    })?;
    let (u, before) = (&path.state, before.ok_or("no step was taken")?);
    let problem = block.step(1.0, &before)?;
    let adjoint = problem.adjoint(u)?.on(world).solver(&mut solver).solve()?;
    let force = block.of_block(&before)?.contact_force(u);
    tell(world, "unknowns", &[u.values().len() as f64]);
    tell(world, "steps", &steps);
    tell(world, "patterns", &[solver.report().patterns as f64]);
    tell(world, "J", &[distributed_functional(world, block.assembler(), &problem.law.criterion(u))?]);
    tell(world, "force", &[distributed_functional(world, block.assembler(), &force)?]);
    tell(world, "u", u.values());
    tell(world, "adjoint", adjoint.field().values());
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
