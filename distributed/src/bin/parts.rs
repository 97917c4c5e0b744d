//! Problems on parts of a mesh, on the processes that started this:
//! `mpirun -n 4 parts CASE [blocks along an edge] [degree] [direct | cg | gmres] [FILE.pvd]`. Tells values at the vertices, integrals,
//! reactions. `parts memory 80 1 cg` tells the peak memory of each process, and what it sent, instead.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_contact::ContactProblem;
use forms_contact::threshold::of_law;
use forms_distributed::cases::adaptive_contact;
use forms_distributed::cases::ball_on_flat::{is_near, place, pressed, refined_quarter};
use forms_distributed::cases::divided_contact;
use forms_distributed::cases::eigenmodes::{self, Eigenmodes};
use forms_distributed::cases::facets_between;
use forms_distributed::cases::field_controls;
use forms_distributed::cases::histories;
use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::motions::Motion;
use forms_distributed::cases::pair_histories;
use forms_distributed::cases::part_adaptivity;
use forms_distributed::cases::part_steps::{FACTORS, HALF, Softening, softening};
use forms_distributed::cases::parts::{Case, even_trees, trees, whole};
use forms_distributed::cases::report::{largest, peak, tell, tell_steps};
use forms_distributed::cases::whole_body;
use forms_distributed::{MeshPart, Method, PartCheckpoint, PetscSolver, World};
use forms_fem::constraints::RigidMap;
use forms_fem::cut::Cut;
use forms_fem::output::{VtuFile, VtuSeries};
use forms_fem::prelude::*;
use forms_fem::time::Mass;

/// The weight of a cell at the top, in a mesh that is divided by weights.
const HEAVY: u32 = 6;

type Outcome = Result<(), Box<dyn Error>>;

fn run(world: &World) -> Outcome {
    let given = |place| std::env::args().nth(place);
    let name = given(1).unwrap_or_else(|| "diffusion".to_owned());
    let divisions = given(2).map_or(Ok(4), |number| number.parse())?;
    let degree = given(3).map_or(Ok(1), |number| number.parse())?;
    let method = Method::named(given(4).as_deref().unwrap_or("direct"))?;
    let start = Instant::now();
    let cube = |shape| world.cuboid([0.0; 3], [1.0; 3], [divisions; 3], shape, 1);
    match name.as_str() {
        "diffusion" | "hanging" | "rubber" | "memory" => {
            solve(&cube(CellShape::Hexahedron)?, &name, degree, method, start)
        }
        "slides" => solve(&cube(CellShape::Hexahedron)?, &name, degree, method, start),
        "trees" | "strip trees" | "rubber trees" => {
            solve(&world.scatter(|| trees(divisions))?, &name, degree, method, start)
        }
        "hanging trees" => solve(&world.divide(&trees(divisions)?)?, &name, degree, method, start),
        "rigid trees" => {
            let part = world.scatter(|| trees(divisions))?.with_surfaces(&["top"])?;
            solve(&part, &name, degree, method, start)
        }
        "periodic trees" => {
            let part = world.scatter(|| even_trees(divisions))?.with_surfaces(&["left", "right"])?;
            solve(&part, &name, degree, method, start)
        }
        "loose" | "late" => continuity(world, &name),
        "periodic" => {
            let part = cube(CellShape::Hexahedron)?.with_surfaces(&["left", "right"])?;
            solve(&part, &name, degree, method, start)
        }
        "rigid" => {
            let part = cube(CellShape::Hexahedron)?.with_surfaces(&["top"])?;
            solve(&part, &name, degree, method, start)
        }
        "tetrahedra" => solve(&cube(CellShape::Tetrahedron)?, &name, degree, method, start),
        // All processes have this mesh, and drop it.
        "divided" => {
            let mesh = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Tetrahedron, 1)?;
            solve(&world.divide(&mesh)?, &name, degree, method, start)
        }
        "weighted" => {
            let mesh = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Tetrahedron, 1)?;
            let mut weights = vec![1; mesh.cell_count()];
            mesh.facet_region("top")?.iter().for_each(|facet| weights[facet.cell as usize] = HEAVY);
            let part = world.divide_weighted(&mesh, |cell| weights[cell])?;
            let heavy = part.facet_region("top")?.len() as u64;
            let own = part.cell_count() as u64 + u64::from(HEAVY - 1) * heavy;
            tell(world, "weights", &world.gather(own)?.iter().map(|own| *own as f64).collect::<Vec<_>>());
            solve(&part, "divided", degree, method, start)
        }
        // The first process has it.
        "scattered" => {
            let part = world.scatter(|| scattered(given(5).as_deref()))?;
            solve(&part, &name, degree, method, start)
        }
        "missing" => world.read_gmsh::<3>("no/such.msh").map(drop).map_err(Into::into),
        "mixed" => mixed(&cube(CellShape::Hexahedron)?, method),
        "softening" => softening(world, given(5).as_deref()),
        "drawn" | "one sided" | "segments" | "blocks" | "ring" | "springs" | "material" | "unnamed"
        | "blocks trees" => {
            divided_contact::run(world, &name, divisions)?;
            tell(world, "megabytes", &[largest(world, peak())?]);
            Ok(())
        }
        "slid" | "uncompleted" | "thrown" | "sprung" | "means" | "means on segments" | "thrown trees" => {
            pair_histories::run(world, &name, given(5).as_deref())
        }
        "fields" | "cell fields" | "minima" | "order" | "far" => field_controls::run(world, &name),
        "adapted" => part_adaptivity::run(world, (CellShape::Triangle, 2)),
        "adapted trees" => part_adaptivity::run(world, (CellShape::Quadrilateral, degree)),
        "adapted contact" => adaptive_contact::run(world, CellShape::Triangle),
        "adapted contact of trees" => adaptive_contact::run(world, CellShape::Quadrilateral),
        "multiplier" | "pinned" => whole_body::run(world, &name),
        "penalty" | "smooth" | "penalty trees" | "smooth trees" => facets_between::run(world, &name),
        "creep" | "swing" => history(world, &name),
        "vibrates" | "floats" | "closed" | "buckles" | "shared" | "uncounted" | "vibrates trees" => {
            eigenmodes(world, &name)
        }
        "heavy" => {
            let mesh = rectangle([0.0; 2], [1.0; 2], [2; 2], CellShape::Quadrilateral, 1)?;
            world.divide_weighted(&mesh, |_| 1 << 30).map(drop).map_err(Into::into)
        }
        name if Motion::named(name).is_ok() => {
            motion(world, Motion::named(name)?, divisions, given(5).as_deref())
        }
        "ball" => ball(world.structured([divisions; 3], CellShape::Hexahedron, 2, place)?, method),
        "ball trees" => {
            let part = world.scatter(|| refined_quarter(divisions))?;
            press(&part, &pressed(&part, -1.0)?, method)
        }
        _ => refused(&cube(CellShape::Hexahedron)?, &name),
    }
}

/// Solves a case on a part that was made from `start` on.
fn solve(part: &MeshPart<'_, 3>, name: &str, degree: usize, method: Method, start: Instant) -> Outcome {
    let (world, case, before) = (part.world(), Case::new(name, part, degree)?, part.world().traffic());
    let mut solver = PetscSolver::for_part(part, &[&case.held], method)?;
    let solved = case.problem().on(part).solver(&mut solver).solve()?;
    let seconds = start.elapsed().as_secs_f64();
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
    tell(world, "solve_seconds", &[solver.report().solve_seconds]);
    tell(world, "seconds", &[seconds]);
    tell(world, "megabytes", &[largest(world, peak())?]);
    let cells = [part.body_cells().len(), part.ghost_cells()];
    tell(world, "cells", &cells.map(|count| count as f64));
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
    if let (Some(path), true) = (std::env::args().nth(5), name == "diffusion") {
        let file = VtuFile::new(part).point_data("u", u)?.on(part);
        let mut series = VtuSeries::new(path)?;
        series.write(0.0, &file)?;
        series.write(1.0, &file)?;
    }
    Ok(())
}

/// The mesh of a file with the sides that the diffusion has.
fn scattered(path: Option<&str>) -> Result<Mesh<3>, Box<dyn Error>> {
    let mut mesh = Mesh::read_vtk(path.unwrap_or("no/such.vtu"))?;
    mesh.name_facets("left", "boundary", |x| x[0] < 1e-9)?;
    mesh.name_facets("right", "boundary", |x| x[0] > 1.0 - 1e-9)?;
    mesh.name_facets("top", "boundary", |x| x[2] > 1.0 - 1e-9)?;
    Ok(mesh)
}

/// Load steps with a memory. With a file they stop after the first half, or go on from the checkpoint there, and leave one at the end.
fn softening(world: &World, path: Option<&str>) -> Outcome {
    let part = world.rectangle([0.0; 2], [2.0, 1.0], [6, 4], CellShape::Triangle, 1)?;
    let body = Softening::on(&part)?;
    let mut solver = PetscSolver::for_part(&part, &[&body.held(1.0)?], Method::Direct)?;
    let (mut from, mut u, mut factors) = (0.0, Field::zero(&body.space), &FACTORS[..]);
    let stored = path.map(|path| PartCheckpoint::read(&part, path)).transpose()?.flatten();
    if let Some(stored) = &stored {
        (from, u, factors) = (stored.number("factor")?, stored.field("u", &body.space)?, &FACTORS[HALF..]);
        stored.history("memory", &body.assembler, &body.data.largest)?;
    } else if path.is_some() {
        factors = &FACTORS[..HALF];
    }
    let u = body.pulled((from, u), factors, |form, held, step| {
        let problem = Problem::new(form, &body.space).assembler(&body.assembler).constrained(held);
        Ok(problem.on(&part).solver(&mut solver).increment(step).solve()?.into_field())
    })?;
    if let Some(path) = path {
        let checkpoint = PartCheckpoint::new(&part).number("factor", factors[HALF - 1])?.field("u", &u)?;
        checkpoint.history("memory", &body.assembler, &body.data.largest)?.write(path)?;
    }
    tell(world, "u", &whole(&part, &u)?);
    let memory = softening::memory(&body.data, &softening::Omega::on("all"), &u);
    let assembler = body.assembler.clone();
    tell(world, "memory", &[part.functional(&assembler, &memory)?]);
    Ok(())
}

/// A motion of some steps; with a file it stops after half of them and leaves a checkpoint there, or goes on from that.
fn motion(world: &World, motion: Motion, steps: usize, path: Option<&str>) -> Outcome {
    let (upper, cells) = Motion::SIZE;
    let part = world.rectangle([0.0; 2], upper, cells, CellShape::Quadrilateral, 1)?;
    let conditions = motion.conditions_on(&part)?;
    let all: Vec<_> = conditions.iter().collect();
    let spaces: Vec<_> = conditions.iter().map(Constraints::space).collect();
    let mut solver = PetscSolver::for_part(&part, &all, Method::Direct)?;
    let (begun, size) = motion.begin(&conditions)?;
    let mut begun = begun.on(&part).solver(&mut solver);
    let stored = path.map(|path| PartCheckpoint::read(&part, path)).transpose()?.flatten();
    let mut count = if path.is_some() { steps / 2 } else { steps };
    if let Some(stored) = &stored {
        begun = begun.resumed(stored.motion(&spaces)?);
        count = steps - begun.steps();
    }
    for _ in 0..count {
        begun.take(size)?;
    }
    if let (Some(path), None) = (path, &stored) {
        PartCheckpoint::new(&part).motion(&begun.checkpoint())?.write(path)?;
    }
    for (number, state) in begun.states().iter().enumerate() {
        tell(world, &format!("value{number}"), &whole(&part, &state.value)?);
        tell(world, &format!("rate{number}"), &whole(&part, &state.rate)?);
    }
    Ok(())
}

/// Value, gradient and Hessian of a history.
fn history(world: &World, name: &str) -> Outcome {
    let (upper, cells) = histories::SIZE;
    let part = world.rectangle([0.0; 2], upper, cells, CellShape::Quadrilateral, 1)?;
    let held = histories::held_on(name, &part)?;
    let mut solver = PetscSolver::for_part(&part, &[&held], Method::Direct)?;
    let found = if name == "creep" {
        let (history, m) = histories::creeping(&held);
        history.on(&part).solver(&mut solver).hessian(&m, &[0.3, -0.7])?
    } else {
        let (history, m) = histories::swinging_motion(&held, Mass::Consistent)?;
        history.on(&part).solver(&mut solver).hessian(&m, &[0.3, -0.7])?
    };
    tell(world, "value", &[found.value]);
    tell(world, "gradient", &found.gradient);
    tell(world, "along", &found.along);
    Ok(())
}

/// Eigenvalues, and a mode. With `shared` each process has the whole mesh.
fn eigenmodes(world: &World, name: &str) -> Outcome {
    let (upper, cells) = eigenmodes::SIZE;
    let (shift, count) = Eigenmodes::ASKED;
    if name == "shared" {
        let mesh = rectangle([0.0; 2], upper, cells, CellShape::Quadrilateral, 1)?;
        let modes = Eigenmodes::new("vibrates", &mesh)?;
        let mut solver = PetscSolver::new(world, &modes.held, Method::Symmetric)?;
        let found = modes.problem().on(world).solver(&mut solver).above(shift, count)?;
        tell(world, "values", &eigenmodes::values(&found));
        return Ok(());
    }
    let rectangle = || world.rectangle([0.0; 2], upper, cells, CellShape::Quadrilateral, 1);
    let part = match name {
        "closed" => rectangle()?.with_surfaces(&["left", "right"])?,
        "vibrates trees" => world.scatter(eigenmodes::trees)?,
        _ => rectangle()?,
    };
    let modes = Eigenmodes::new(name, &part)?;
    let method = if name == "uncounted" { Method::Direct } else { Method::Symmetric };
    let mut solver = PetscSolver::for_part(&part, &[&modes.held], method)?;
    let found = modes.problem().on(&part).solver(&mut solver).above(shift, count)?;
    tell(world, "values", &eigenmodes::values(&found));
    tell(world, "amounts", &whole(&part, &eigenmodes::amounts(&found)?)?);
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
    press(&part, &problem, method)
}

fn press(part: &MeshPart<'_, 3>, problem: &ContactProblem<3>, method: Method) -> Outcome {
    let world = part.world();
    let mut solver = PetscSolver::for_part(part, &[&problem.constraints], method)?;
    let solved = problem.direct()?.on(part).solver(&mut solver).solve()?;
    let (u, law) = (solved.field(), &problem.law);
    tell(world, "megabytes", &[largest(world, peak())?]);
    tell_steps(world, &solved.history);
    tell(world, "J", &[part.functional(&problem.assembler, &law.criterion(u))?]);
    tell(world, "force", &[part.functional(&problem.assembler, &law.contact_force(u))?]);
    tell(world, "u", &whole(part, u)?);
    let adjoint = problem.adjoint(u)?.on(part).solver(&mut solver).solve()?;
    tell(world, "adjoint", &whole(part, adjoint.field())?);
    Ok(())
}

/// Continuity at a hanging node of a mesh that is given by its cells, and after prescribed values.
fn continuity(world: &World, name: &str) -> Outcome {
    if name == "loose" {
        let (upper, lower) = ([0.0, 1.0], [0.0, 0.0]);
        let others = [[1.0, 0.0], [1.0, 1.0], [1.5, 0.0], [1.5, 0.5], [1.0, 0.5], [1.5, 1.0]];
        let nodes = [&[lower][..], &others, &[upper]].concat();
        let cells = vec![0, 1, 2, 7, 1, 3, 4, 5, 5, 4, 6, 2];
        let mesh = Mesh::from_nonconforming_blocks(1, nodes, vec![(CellShape::Quadrilateral, cells)])?;
        let part = world.divide(&mesh)?;
        let space = Space::scalar(&part, 1)?;
        return Ok(Constraints::new(&space).join_hanging_nodes()?);
    }
    let part = world.scatter(|| trees(3))?;
    let mut held = Constraints::new(&Space::scalar(&part, 1)?);
    held.fix("boundary", |_| 0.0)?;
    Ok(held.join_hanging_nodes()?)
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
        "tied" => case.held.periodic("front", "back", &RigidMap::translation([0.0, 1.0, 0.0]))?,
        "mean" => case.held.mean_value("all", 0, 0.0)?,
        "split" => {
            let far = case.space.nearest_node(&[1.0; 3]).unwrap_or_default();
            let near = case.space.nearest_node(&[0.0; 3]).unwrap_or_default();
            case.held = Constraints::new(&case.space);
            case.held.sum("ends", &[(3 * far + 1, 1.0), (3 * near + 1, -1.0)], 0.0)?;
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
