//! Problems on parts of a mesh, on the processes that started this:
//! `mpirun -n 4 parts CASE [blocks along an edge] [degree] [direct | cg | gmres] [FILE.pvd]`. Tells values at the vertices, integrals,
//! reactions. `parts memory 80 1 cg` tells the peak memory of each process, and what it sent, instead.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::threshold::of_law;
use forms_distributed::cases::ball_on_flat::{is_near, place, pressed};
use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::parts::{Case, whole};
use forms_distributed::cases::report::{tell, tell_steps};
use forms_distributed::{MeshPart, Method, PetscSolver, World};
use forms_fem::cut::Cut;
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;

type Outcome = Result<(), Box<dyn Error>>;

fn run(world: &World) -> Outcome {
    let given = |place| std::env::args().nth(place);
    let name = given(1).unwrap_or_else(|| "diffusion".to_owned());
    let divisions = given(2).map_or(Ok(4), |number| number.parse())?;
    let degree = given(3).map_or(Ok(1), |number| number.parse())?;
    let method = Method::named(given(4).as_deref().unwrap_or("direct"))?;
    let cube = |shape| world.cuboid([0.0; 3], [1.0; 3], [divisions; 3], shape, 1);
    match name.as_str() {
        "diffusion" | "hanging" | "rubber" | "memory" => {
            solve(&cube(CellShape::Hexahedron)?, &name, degree, method)
        }
        "tetrahedra" => solve(&cube(CellShape::Tetrahedron)?, &name, degree, method),
        // All processes have this mesh, and drop it.
        "divided" => {
            let mesh = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Tetrahedron, 1)?;
            solve(&world.divide(&mesh)?, &name, degree, method)
        }
        "mixed" => mixed(&cube(CellShape::Hexahedron)?, method),
        "ball" => ball(world.structured([divisions; 3], CellShape::Hexahedron, 2, place)?, method),
        _ => refused(&cube(CellShape::Hexahedron)?, &name),
    }
}

fn solve(part: &MeshPart<'_, 3>, name: &str, degree: usize, method: Method) -> Outcome {
    let (world, case, before) = (part.world(), Case::new(name, part, degree)?, part.world().traffic());
    let mut solver = PetscSolver::for_part(part, &[&case.held], method)?;
    let solved = case.problem().on(part).solver(&mut solver).solve()?;
    let (u, now, steps) = (solved.field(), world.traffic(), solved.iterations() as f64);
    let (messages, bytes) = (now.messages - before.messages, now.bytes - before.bytes);
    let calls = (now.collective - before.collective) as f64;
    tell(
        world,
        "sent",
        &[largest(world, messages as f64)? / steps, largest(world, bytes as f64)? / steps, calls / steps],
    );
    let iterations = solver.report().iterations.iter().map(|count| *count as f64);
    tell(world, "iterations", &iterations.collect::<Vec<_>>());
    tell(world, "megabytes", &[largest(world, peak())?]);
    if name == "memory" {
        return Ok(());
    }
    tell_steps(world, &solved.history);
    tell(world, "u", &whole(part, u)?);
    tell(world, "size", &[part.functional(solved.assembler(), &Case::size(u))?]);
    tell(
        world,
        "reactions",
        &[part.reaction(&solved, 0, "left")?, part.reaction(&solved, 0, "top")?].concat(),
    );
    if let Some(path) = std::env::args().nth(5) {
        part.write(path, &VtuFile::new(part).point_data("u", u)?)?;
    }
    Ok(())
}

fn mixed(part: &MeshPart<'_, 3>, method: Method) -> Outcome {
    let (world, block) = (part.world(), MixedBlock::on(part)?);
    let mut solver = PetscSolver::for_part(part, &[&block.held, &block.free], method)?;
    let solved = block.problem().on(part).solver(&mut solver).solve()?;
    let [u, p] = &solved.fields;
    tell(world, "u", &whole(part, u)?);
    tell(world, "p", &whole(part, p)?);
    tell(world, "reactions", &part.reaction(&solved, 0, "bottom")?);
    Ok(())
}

fn ball(mut part: MeshPart<'_, 3>, method: Method) -> Outcome {
    let world = part.world();
    part.name_facets("contact", "bottom", is_near)?;
    let mut problem = pressed(&part, 1.0)?;
    // The worst contact cell is on one of the processes.
    let required = of_law(&problem.law, &problem.assembler, &problem.space)?.required;
    problem.law.data.gamma0 = 1.5 * largest(world, required)?;
    problem.law.data.theta = if matches!(method, Method::ConjugateGradients { .. }) { 1.0 } else { -1.0 };
    let mut solver = PetscSolver::for_part(&part, &[&problem.constraints], method)?;
    let solved = problem.direct()?.on(&part).solver(&mut solver).solve()?;
    let (u, law) = (solved.field(), &problem.law);
    tell(world, "megabytes", &[largest(world, peak())?]);
    tell_steps(world, &solved.history);
    tell(world, "J", &[part.functional(&problem.assembler, &law.criterion(u))?]);
    tell(world, "force", &[part.functional(&problem.assembler, &law.contact_force(u))?]);
    tell(world, "u", &whole(&part, u)?);
    let adjoint = problem.adjoint(u)?.on(&part).solver(&mut solver).solve()?;
    tell(world, "adjoint", &whole(&part, adjoint.field())?);
    Ok(())
}

/// The largest of all processes' numbers.
fn largest(world: &World, own: f64) -> Result<f64, Box<dyn Error>> {
    Ok(world.gather(own.to_bits())?.into_iter().map(f64::from_bits).fold(f64::NAN, f64::max))
}

/// The largest memory of this process so far \[MB\]; NaN where the system does not tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<f64>().ok());
    kibibytes.map_or(f64::NAN, |count| count * 1024.0 / 1e6)
}

/// A problem that parts refuse, by a name.
fn refused(part: &MeshPart<'_, 3>, name: &str) -> Outcome {
    let mut case = Case::new("rubber", part, 1)?;
    match name {
        "without on" => return Ok(case.problem().solve().map(drop)?),
        "refined" => return Ok(part.refined().map(drop)?),
        "cut" => {
            let phi = Field::interpolate(&Space::scalar(part, 1)?, |x| x[0] - 0.3)?;
            return Ok(Cut::by(&phi).map(drop)?);
        }
        "on facets" => {
            let traces = Constraints::new(&Space::vector_on_facets(part, "top", 1)?);
            return Ok(PetscSolver::for_part(part, &[&traces], Method::Direct).map(drop)?);
        }
        "nearest" => case.held.fix_nearest(&[0.5; 3], [0.0; 3])?,
        "sliding" => {
            case.held = Constraints::new(&case.space);
            case.held.slide("top", |_| [0.6, 0.0, 0.8], |_| 0.0)?;
        }
        "interior" => {
            case.form =
                form!(|u: Unknown<Vector>, v: Test<Vector>| integral(cells("all"), inner(eps(u), eps(v)))
                    + integral(interior_facets("interior"), dot(jump(u), jump(v))));
        }
        _ => {}
    }
    let mut solver = PetscSolver::for_part(part, &[&case.held], Method::Direct)?;
    if name == "on the world" {
        return Ok(case.problem().on(part.world()).solver(&mut solver).solve().map(drop)?);
    }
    let solved = case.problem().on(part).solver(&mut solver).solve()?;
    match name {
        "reaction" => solved.reaction("left").map(drop)?,
        "functional" => solved.functional(&Case::size(solved.field())).map(drop)?,
        _ => return Err(format!("there is no case \"{name}\", or it was not refused").into()),
    }
    Ok(())
}

fn main() -> ExitCode {
    World::run(run)
}
