//! Problems on parts of a mesh, on the processes that started this:
//! `mpirun -n 4 parts CASE [blocks along an edge] [degree] [direct | cg | gmres] [file of hanging]`. Tells values at the vertices, integrals, reactions.
//! `parts memory 80 1 cg` tells the peak memory of each process, and what it sent, instead.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::threshold::of_law;
use forms_distributed::cases::ball_on_flat::{is_near, place, pressed};
use forms_distributed::cases::hanging_block::HangingBlock;
use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::parts::{by_tangent, model, scalars, stretched, whole};
use forms_distributed::cases::report::{tell, tell_steps};
use forms_distributed::{MeshPart, Method, PetscSolver, World};
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;

type Outcome = Result<(), Box<dyn Error>>;

fn run(world: &World) -> Outcome {
    let given = |place| std::env::args().nth(place);
    let name = given(1).unwrap_or_else(|| "poisson".to_owned());
    let divisions = given(2).map_or(Ok(4), |number| number.parse())?;
    let degree = given(3).map_or(Ok(1), |number| number.parse())?;
    let method = Method::named(given(4).as_deref().unwrap_or("direct"))?;
    let cube = |shape| world.cuboid([0.0; 3], [1.0; 3], [divisions; 3], shape, 1);
    match name.as_str() {
        "memory" => memory(&cube(CellShape::Hexahedron)?, degree, method),
        "poisson" => poisson(&cube(CellShape::Hexahedron)?, degree, method),
        "tetrahedra" => poisson(&cube(CellShape::Tetrahedron)?, degree, method),
        // All processes have this mesh, and drop it.
        "divided" => {
            let mesh = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Tetrahedron, 1)?;
            poisson(&world.divide(&mesh)?, degree, method)
        }
        "hanging" => hanging(&cube(CellShape::Hexahedron)?, method),
        "mixed" => mixed(&cube(CellShape::Hexahedron)?, method),
        "rubber" => rubber(&cube(CellShape::Hexahedron)?, degree, method),
        "ball" => ball(world.structured([divisions; 3], CellShape::Hexahedron, 2, place)?, method),
        _ => refused(&cube(CellShape::Hexahedron)?, &name),
    }
}

/// Nodes of the whole mesh.
fn nodes(part: &MeshPart<'_, 3>) -> Result<usize, Box<dyn Error>> {
    let largest = part.node_numbers().iter().max().copied().unwrap_or(0);
    Ok(part.world().gather(largest)?.into_iter().max().unwrap_or(0) as usize + 1)
}

fn poisson(part: &MeshPart<'_, 3>, degree: usize, method: Method) -> Outcome {
    let (world, (space, held), model) = (part.world(), scalars(part, degree)?, model());
    let mut solver = PetscSolver::for_part(part, &[&held], method)?;
    let form = model.diffusion();
    let problem = Problem::new(&form, &space).on(part).constrained(&held).threads(Threads::new(1));
    let solved = problem.solver(&mut solver).solve()?;
    let u = solved.field();
    tell(world, "u", &whole(part, u, nodes(part)?)?);
    tell(world, "size", &[part.functional(solved.assembler(), &model.scalar_size(u))?]);
    tell(
        world,
        "reactions",
        &[part.reaction(&solved, 0, "left")?, part.reaction(&solved, 0, "top")?].concat(),
    );
    Ok(())
}

fn hanging(part: &MeshPart<'_, 3>, method: Method) -> Outcome {
    let (world, model) = (part.world(), model());
    let HangingBlock { form, space, constraints } =
        HangingBlock::on(part, Given::constant([0.0, 0.0, -1.0]))?;
    let mut solver = PetscSolver::for_part(part, &[&constraints], method)?;
    let problem = Problem::new(&form, &space).on(part).constrained(&constraints).threads(Threads::new(1));
    let solved = problem.solver(&mut solver).solve()?;
    let u = solved.field();
    tell(world, "u", &whole(part, u, nodes(part)?)?);
    tell(world, "size", &[part.functional(solved.assembler(), &model.vector_size(u))?]);
    tell(world, "reactions", &part.reaction(&solved, 0, "top")?);
    if let Some(path) = std::env::args().nth(5) {
        part.write(path, &VtuFile::new(part).point_data("u", u)?)?;
    }
    tell(
        world,
        "iterations",
        &solver.report().iterations.iter().map(|count| *count as f64).collect::<Vec<_>>(),
    );
    Ok(())
}

fn mixed(part: &MeshPart<'_, 3>, method: Method) -> Outcome {
    let (world, block) = (part.world(), MixedBlock::on(part)?);
    let mut solver = PetscSolver::for_part(part, &[&block.held, &block.free], method)?;
    let solved = block.problem().on(part).solver(&mut solver).solve()?;
    let [u, p] = &solved.fields;
    tell(world, "u", &whole(part, u, nodes(part)?)?);
    tell(world, "p", &whole(part, p, nodes(part)?)?);
    tell(world, "reactions", &part.reaction(&solved, 0, "bottom")?);
    Ok(())
}

fn rubber(part: &MeshPart<'_, 3>, degree: usize, method: Method) -> Outcome {
    let (world, (space, held), model) = (part.world(), stretched(part, degree)?, model());
    let mut solver = PetscSolver::for_part(part, &[&held], method)?;
    let form = model.rubber();
    let before = world.traffic();
    let problem = Problem::new(&form, &space).on(part).constrained(&held).threads(Threads::new(1));
    let solved = problem.options(by_tangent()).solver(&mut solver).solve()?;
    tell_traffic(world, before, solved.iterations())?;
    let u = solved.field();
    tell_steps(world, &solved.history);
    tell(world, "u", &whole(part, u, nodes(part)?)?);
    tell(world, "size", &[part.functional(solved.assembler(), &model.vector_size(u))?]);
    tell(world, "reactions", &part.reaction(&solved, 0, "right")?);
    Ok(())
}

fn ball(mut part: MeshPart<'_, 3>, method: Method) -> Outcome {
    let world = part.world();
    part.name_facets("contact", "bottom", is_near)?;
    let theta = if matches!(method, Method::ConjugateGradients { .. }) { 1.0 } else { -1.0 };
    let mut problem = pressed(&part, 1.0)?;
    // The worst contact cell is on one of the processes.
    let required = of_law(&problem.law, &problem.assembler, &problem.space)?.required;
    let all = world.gather(required.to_bits())?.into_iter().map(f64::from_bits);
    problem.law.data.gamma0 = 1.5 * all.fold(0.0, f64::max);
    problem.law.data.theta = theta;
    let mut solver = PetscSolver::for_part(&part, &[&problem.constraints], method)?;
    let solved = problem.direct()?.on(&part).solver(&mut solver).solve()?;
    let (u, law) = (solved.field(), &problem.law);
    tell_steps(world, &solved.history);
    tell(world, "J", &[part.functional(&problem.assembler, &law.criterion(u))?]);
    tell(world, "force", &[part.functional(&problem.assembler, &law.contact_force(u))?]);
    tell(world, "u", &whole(&part, u, nodes(&part)?)?);
    let adjoint = problem.adjoint(u)?.on(&part).solver(&mut solver).solve()?;
    tell(world, "adjoint", &whole(&part, adjoint.field(), nodes(&part)?)?);
    Ok(())
}

fn memory(part: &MeshPart<'_, 3>, degree: usize, method: Method) -> Outcome {
    let (world, fixed) = (part.world(), peak());
    let ((space, held), model) = (scalars(part, degree)?, model());
    let mut solver = PetscSolver::for_part(part, &[&held], method)?;
    let form = model.diffusion();
    let before = world.traffic();
    let problem = Problem::new(&form, &space).on(part).constrained(&held).threads(Threads::new(1));
    let solved = problem.solver(&mut solver).solve()?;
    tell_traffic(world, before, solved.iterations())?;
    tell(world, "unknowns", &[solver.report().rows as f64, space.unknowns() as f64]);
    tell(
        world,
        "iterations",
        &solver.report().iterations.iter().map(|count| *count as f64).collect::<Vec<_>>(),
    );
    let of_all = |own: f64| -> Result<Vec<f64>, Box<dyn Error>> {
        Ok(world.gather(own.to_bits())?.into_iter().map(f64::from_bits).collect())
    };
    tell(world, "mesh_megabytes", &of_all(fixed)?);
    tell(world, "peak_megabytes", &of_all(peak())?);
    Ok(())
}

/// Messages and bytes for each step, of the process that sends most, and collective calls.
fn tell_traffic(world: &World, before: forms_distributed::Traffic, steps: usize) -> Outcome {
    let (now, steps) = (world.traffic(), steps as f64);
    let most = |own: u64| -> Result<f64, Box<dyn Error>> {
        Ok(world.gather(own)?.into_iter().max().unwrap_or(0) as f64 / steps)
    };
    let messages = most(now.messages - before.messages)?;
    let bytes = most(now.bytes - before.bytes)?;
    tell(world, "sent_per_step", &[messages, bytes, (now.collective - before.collective) as f64 / steps]);
    Ok(())
}

/// The largest memory of this process so far \[MB\]; NaN where the system does not tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes =
        line.and_then(|line| line.trim().strip_suffix(" kB")).and_then(|text| text.parse::<f64>().ok());
    kibibytes.map_or(f64::NAN, |count| count * 1024.0 / 1e6)
}

/// What a part does not have, by a name.
fn refused(part: &MeshPart<'_, 3>, name: &str) -> Outcome {
    let (space, mut held) = stretched(part, 1)?;
    let form = model().rubber();
    match name {
        "without on" => Problem::new(&form, &space).constrained(&held).solve().map(drop)?,
        "on the world" => {
            let mut solver = PetscSolver::for_part(part, &[&held], Method::Direct)?;
            let problem = Problem::new(&form, &space).on(part.world()).constrained(&held);
            problem.solver(&mut solver).solve().map(drop)?;
        }
        "nearest" => held.fix_nearest(&[0.5; 3], [0.0; 3])?,
        "sliding" => {
            held = Constraints::new(&space);
            held.slide("top", |_| [0.6, 0.0, 0.8], |_| 0.0)?;
            let mut solver = PetscSolver::for_part(part, &[&held], Method::Direct)?;
            Problem::new(&form, &space).on(part).constrained(&held).solver(&mut solver).solve().map(drop)?;
        }
        "interior" => {
            let jumps =
                form!(|u: Unknown<Vector>, v: Test<Vector>| integral(cells("all"), inner(eps(u), eps(v)))
                    + integral(interior_facets("interior"), dot(jump(u), jump(v))));
            let mut solver = PetscSolver::for_part(part, &[&held], Method::Direct)?;
            Problem::new(&jumps, &space).on(part).constrained(&held).solver(&mut solver).solve().map(drop)?;
        }
        "reaction" => {
            let mut solver = PetscSolver::for_part(part, &[&held], Method::Direct)?;
            let problem = Problem::new(&form, &space).on(part).constrained(&held);
            problem.solver(&mut solver).solve()?.reaction("left").map(drop)?;
        }
        "functional" => {
            let mut solver = PetscSolver::for_part(part, &[&held], Method::Direct)?;
            let problem = Problem::new(&form, &space).on(part).constrained(&held);
            let solved = problem.solver(&mut solver).solve()?;
            solved.functional(&model().vector_size(solved.field())).map(drop)?;
        }
        name => return Err(format!("there is no case \"{name}\"").into()),
    }
    Err(format!("\"{name}\" was not refused").into())
}

fn main() -> ExitCode {
    World::run(run)
}
