//! Failures that must not leave a process waiting for another: `mpirun -n 2 failures NAME`. Most of them are those of the last process.

use std::error::Error;
use std::process::ExitCode;
use std::time::Duration;

use forms_distributed::cases::hanging_block::HangingBlock;
use forms_distributed::cases::parts::Case;
use forms_distributed::cases::poisson::{Given as Numbers, Poisson};
use forms_distributed::{Method, PetscSolver, World};
use forms_fem::mesh::GmshMesh;
use forms_fem::output::tell;
use forms_fem::prelude::*;

type Outcome = Result<(), Box<dyn Error>>;

fn run(world: &World) -> Outcome {
    // That none is left is seen from outside.
    tell(format_args!("pid {}", std::process::id()));
    let name = std::env::args().nth(1).unwrap_or_default();
    let is_last = world.rank() + 1 == world.size();
    // The place in a pair of what the others have and what the last one has.
    let here = usize::from(is_last);
    let usual = Numbers::default();
    let solve = |given| Poisson::new(given)?.solve(world);
    match name.as_str() {
        "assembly" => hanging_block(world, 500, f64::NAN),
        "convergence" => hanging_block(world, 3, -1.0),
        "twice" => World::start().map(drop).map_err(Box::from),
        // What one process was given, or not.
        "argument" => solve(Numbers { cells: ["8", "8x"][here].parse()?, ..usual }).map(drop),
        "region" => solve(Numbers { region: ["boundary", "boundry"][here], ..usual }).map(drop),
        "file" if is_last => Poisson::on(GmshMesh::read("missing.msh")?.mesh, usual)?.solve(world).map(drop),
        "file" => solve(usual).map(drop),
        "mesh" => solve(Numbers { cells: [8, 7][here], ..usual }).map(drop),
        "space" => solve(Numbers { degree: [2, 1][here], ..usual }).map(drop),
        "parameter" => solve(Numbers { load: [1.0, 2.0][here], ..usual }).map(drop),
        "boundary" => solve(Numbers { boundary: [0.0, 1.0][here], ..usual }).map(drop),
        "cells" => {
            let problem = Poisson::new(usual)?;
            let mut solver = PetscSolver::new(world, &problem.constraints, Method::Direct)?;
            let first = Assembler::new(problem.space.mesh()).on_owned_cells(&[0])?;
            Ok(problem.problem().assembler(&first).on(world).solver(&mut solver).solve().map(drop)?)
        }
        "without on" => {
            let problem = Poisson::new(usual)?;
            let mut solver = PetscSolver::new(world, &problem.constraints, Method::Direct)?;
            let solved = problem.problem().solver(&mut solver).solve()?;
            Err(format!("solved, ∫u = {}", problem.total(&solved)?).into())
        }
        "without PETSc" => {
            let problem = Poisson::new(usual)?;
            let solved = problem.problem().on(world).solve()?;
            Err(format!("solved, ∫u = {}", problem.total(&solved)?).into())
        }
        // Others exchange values at shared nodes when the last one has failed.
        "part" => {
            let part = world.cuboid([0.0; 3], [1.0; 3], [3; 3], CellShape::Hexahedron, 1)?;
            let case = Case::new("diffusion", &part, 1)?;
            let mut solver = PetscSolver::for_part(&part, &[&case.held], Method::Direct)?;
            let solved = case.problem().on(&part).solver(&mut solver).solve()?;
            if is_last {
                return Err("no reaction on this process".into());
            }
            Ok(part.reaction(&solved, 0, "left").map(drop)?)
        }
        // What one process does after a solution, while its solver waits for the next matrix.
        name => {
            let problem = Poisson::new(usual)?;
            let mut solver = PetscSolver::new(world, &problem.constraints, Method::Direct)?;
            let mut solve = || problem.problem().on(world).solver(&mut solver).solve().map(drop);
            solve()?;
            match name {
                "error" if is_last => return Err("no further step on this process".into()),
                "panic" if is_last => panic!("a mistake on this process"),
                "early" if is_last => return Ok(()),
                "exit" if is_last => std::process::exit(3),
                "busy" if is_last => return Err("no further step while others are busy".into()),
                "busy" => loop {
                    std::thread::sleep(Duration::from_millis(100));
                },
                _ => {}
            }
            Ok(solve()?)
        }
    }
}

/// Elasticity of a hanging block: with a given weight in the last cells, and at most a given number of iterations.
fn hanging_block(world: &World, max_iterations: u16, last_weight: f64) -> Outcome {
    let last = 0.8;
    let weight = move |x: &[f64; 3]| [0.0, 0.0, if x[0] > last { last_weight } else { -1.0 }];
    let HangingBlock { form, space, constraints } = HangingBlock::new(4, Given::function(weight))?;
    let method = Method::ConjugateGradients { tolerance: 1e-10, max_iterations };
    let mut solver = PetscSolver::new(world, &constraints, method)?;
    Problem::new(&form, &space)
        .threads(Threads::new(1))
        .on(world)
        .constrained(&constraints)
        .solver(&mut solver)
        .solve()?;
    Ok(())
}

/// As a program does that starts the world itself.
fn by_hand() -> Outcome {
    let world = World::start()?;
    run(&world)
}

fn main() -> ExitCode {
    if std::env::args().nth(2).is_none() {
        return World::run(run);
    }
    match by_hand() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // In one write, as `World::run` does: what the others write does not come between.
            tell(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}
