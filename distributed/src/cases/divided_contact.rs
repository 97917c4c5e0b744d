//! Contact between bodies on parts of a mesh: blocks in space at small sliding, a block that is drawn along a slab, a ring that closes on
//! itself, friction with a memory. Nodes of blocks and slab may hang.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use forms_contact::ContactProblem;
use forms_contact::laws::friction_with_memory::penalty_with_memory as springs;
use forms_contact::laws::{sliding_bodies, two_bodies};
use forms_fem::contract::PairQuadrature;
use forms_fem::history::WithoutPartner;
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;

use super::drawn_block::{DrawnBlock, SURFACES};
use super::parts::{refined, whole};
use super::report::{tell, tell_steps};
use crate::Method;
use crate::part::{MeshPart, PartCheckpoint};
use crate::petsc_solver::PetscSolver;
use crate::world::World;

type Outcome = Result<(), Box<dyn Error>>;

/// A field on a part, with values where other processes have them.
type Completed<'c> = &'c dyn Fn(Field<3>) -> Result<Field<3>, Box<dyn Error>>;

/// Load factors of the blocks.
pub const FACTORS: [f64; 2] = [0.6, 1.0];

/// A block on a slab, whose meshes do not match; with more cells along all edges for larger factors.
///
/// # Errors
/// Too many cells, or none.
pub fn blocks_mesh(times: usize) -> Result<Mesh<3>, Box<dyn Error>> {
    let many = |divisions: [usize; 3]| divisions.map(|count| times * count);
    let slab = cuboid([0.0; 3], [2.0, 2.0, 1.0], many([4, 3, 2]), CellShape::Hexahedron, 1)?;
    let block = cuboid([0.3, 0.4, 1.0], [1.5, 1.6, 2.0], many([3, 2, 2]), CellShape::Hexahedron, 1)?;
    Ok(Mesh::of_bodies(&[("slab", &slab), ("block", &block)])?)
}

/// The blocks with cells that are divided where they touch, some of them twice: nodes hang inside of both and on the surfaces, whose facets do not
/// match.
///
/// # Errors
/// None.
pub fn blocks_trees() -> Result<Mesh<3>, Box<dyn Error>> {
    Ok(refined(blocks_mesh(1)?, &[1.0, 1.1, 1.0], &[0.7, 0.4])?)
}

/// A stiffness of each cell. Copies of cells are in no region.
fn stiffness_of_cells(mesh: &Mesh<3>) -> Result<Field<3>, Box<dyn Error>> {
    let mut stiffness = vec![1.0; mesh.cell_count()];
    mesh.cell_region("block")?.iter().for_each(|cell| stiffness[*cell as usize] = 2.5);
    Ok(Field::from_cell_values(&Space::discontinuous_scalar(mesh, 0)?, &stiffness)?)
}

/// The contact of the blocks at a load factor, with friction and a material of each cell, from the state before.
///
/// # Errors
/// Data that do not fit.
pub fn blocks(
    space: &Arc<Space<3>>,
    factor: f64,
    before: &Field<3>,
    completed: Completed<'_>,
) -> Result<ContactProblem<3, two_bodies::Model<3>>, Box<dyn Error>> {
    let mesh = space.mesh();
    let mu = completed(stiffness_of_cells(mesh)?)?;
    let data = two_bodies::data()
        .lambda(mu.clone())
        .mu(mu)
        .gamma0(40.0)
        .theta(-1.0)
        .friction(0.4)
        .displacement_before(before)
        .force_direction([1.0, 0.0, 0.0])
        .criterion_force(|x: &[f64; 3]| [0.3 + x[0], x[1], 0.5]);
    let touch = Pairing::between("slab top", "block bottom");
    let regions = two_bodies::Regions::default().touch(touch).gamma_n("block right");
    let mut held = Constraints::new(space);
    if mesh.facet_parts().next().is_some() {
        held.join_hanging_nodes()?;
    }
    held.fix("slab bottom", |_| [0.0; 3])?;
    held.fix("block top", move |x| [0.05 * factor, 0.02 * factor * x[0], -0.06])?;
    let assembler = Assembler::new(mesh).with_threads(Threads::new(1));
    let law = two_bodies::Model { data, regions };
    Ok(ContactProblem::new(space, law, held).assembler(assembler))
}

/// The force along the first axis on the block's side of the surfaces.
pub fn force_on_block(law: &two_bodies::Model<3>, u: &Field<3>) -> Functional<3> {
    let regions = law.regions.clone().touch(Pairing::onto("block bottom", "slab top"));
    two_bodies::Model { data: law.data.clone(), regions }.contact_force(u)
}

/// The map from the unit square to a ring with a slit.
pub fn place([s, t]: [f64; 2]) -> [f64; 2] {
    let angle = -SLIT - s * (TAU - 2.0 * SLIT);
    let radius = 1.0 + 0.4 * t.powf(1.0 + 0.4 * s);
    [radius * angle.cos(), radius * angle.sin()]
}

/// Half of the slit's angle.
const SLIT: f64 = 0.04;
/// Cells along the ring, and through it.
pub const RING: [usize; 2] = [24, 3];

/// Whether the middle of a facet is on the ring's inside or at its slit.
pub fn is_skin(x: &[f64; 2]) -> bool {
    x[0].hypot(x[1]) < 1.02 || (x[0] > 0.9 && x[1].abs() < 0.08 && x[0].hypot(x[1]) < 1.38)
}

/// The ring of rubber, or a part of it, with its ends pushed together and past each other. Its inside is "skin" with both ends.
///
/// # Errors
/// A mesh without these regions.
pub fn ring(mesh: &Mesh<2>) -> Result<ContactProblem<2, sliding_bodies::Model<2>>, Box<dyn Error>> {
    let space = Space::vector(mesh, 1)?;
    let mut held = Constraints::new(&space);
    held.fix("back", |_| [0.0; 2])?;
    held.fix("pushed down", |_| [0.0, -0.07])?;
    held.fix("pushed up", |_| [0.02, 0.06])?;
    let data = two_bodies::data()
        .lambda(15.0)
        .mu(10.0)
        .gamma0(250.0)
        .friction(0.2)
        .displacement_before(Given::field(Field::zero(&space)));
    let regions = sliding_bodies::Regions::default().touch(Pairing::within("skin")).gamma_n("top");
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
    let law = sliding_bodies::Model { data, regions };
    Ok(ContactProblem::new(&space, law, held).assembler(assembler.with_threads(Threads::new(1))))
}

/// The drawn block with friction by springs that remember, whose memory is at the own points of the pairs.
pub struct Remembering {
    block: DrawnBlock,
    touch: Pairing,
    data: springs::Data<2>,
}

impl Remembering {
    /// At rest.
    ///
    /// # Errors
    /// Surfaces that do not exist.
    pub fn on(mesh: &Mesh<2>, touch: Pairing) -> Result<Self, Box<dyn Error>> {
        let block = DrawnBlock::on(mesh, touch.clone())?;
        let memory = block.assembler().history_on_sliding_pairs(&touch, 4, [0.0; 2])?;
        let data = springs::data().lambda(15.0).mu(10.0).gamma0(300.0);
        let data = data.stick_stiffness(200.0).elastic_slip(memory).friction(0.3);
        Ok(Remembering { block, touch, data })
    }

    /// Who assembles.
    pub fn assembler(&self) -> &Assembler<2> {
        self.block.assembler()
    }

    /// The state after all steps, each solved as is said, with the law between the bodies; the force is that on the block. It commits the memory.
    ///
    /// # Errors
    /// A step that was not solved.
    pub fn drawn(
        &self,
        mut solve: impl FnMut(
            &ContactProblem<2, springs::Model<2>>,
            &Increment<'_, Field<2>>,
        ) -> Result<Solved<2>, Box<dyn Error>>,
    ) -> Result<(Field<2>, springs::Model<2>), Box<dyn Error>> {
        let (mut last, data) = (None, self.data.clone().force_direction([1.0, 0.0]));
        let (space, assembler) = (self.block.space(), self.block.assembler());
        let path = LoadSteps::uniform(4, 1.0).advance(Field::zero(space), |step| {
            let data = data.clone().displacement_before(step.before);
            let regions = springs::Regions::default().touch(self.touch.clone()).gamma_n("block right");
            let law = springs::Model { data, regions };
            let problem = ContactProblem::new(space, law, self.block.held(step.factor)?);
            let problem = problem.assembler(assembler.clone());
            let u = solve(&problem, step)?.into_field();
            let (after, memory) = (problem.law.slip_after_step(&u), &problem.law.data.elastic_slip);
            assembler.update_sliding_history(&after, memory, &self.touch, &u, WithoutPartner::Restart)?;
            memory.commit();
            last = Some(problem.law);
            Ok::<_, Box<dyn Error>>(u)
        });
        let u = path.map_err(|error| error.to_string())?.state;
        let mut law = last.ok_or("no step was taken")?;
        law.regions = law.regions.touch(Pairing::onto(SURFACES[1], SURFACES[0]));
        Ok((u, law))
    }
}

/// One of these problems on the processes that started this: tells states, forces, steps, what is covered.
///
/// # Errors
/// One of a process.
pub fn run(world: &World, name: &str, times: usize) -> Outcome {
    match name {
        "ring" => run_ring(world),
        "blocks" | "material" | "blocks trees" => run_blocks(world, name, times),
        "springs" => run_memory(world),
        _ => run_drawn(world, name),
    }
}

/// The pairs of the drawn block by a name, as a whole mesh has them.
pub fn drawn_pairs(name: &str) -> Pairing {
    let [slab, block] = SURFACES;
    match name {
        "segments" | "means on segments" => Pairing::between(slab, block).at(PairQuadrature::Pieces),
        "one sided" => Pairing::onto(block, slab),
        _ => Pairing::between(slab, block),
    }
}

/// A case's name, and the mesh of the drawn block that it asks for.
///
/// # Errors
/// None.
pub fn of_name(name: &str) -> Result<(&str, Mesh<2>), Box<dyn Error>> {
    Ok(match name.strip_suffix(" trees") {
        Some(name) => (name, DrawnBlock::trees(4)?),
        None => (name, DrawnBlock::mesh(4)?),
    })
}

fn tell_pairs<const D: usize>(world: &World, part: &MeshPart<'_, D>, solved: &Solved<D>) {
    let paired = solved.pairs.iter().map(|pairs| pairs.report.paired_measure);
    tell(world, "paired", &paired.collect::<Vec<_>>());
    tell(world, "points", &solved.pairs.iter().map(|pairs| pairs.report.points as f64).collect::<Vec<_>>());
    tell(world, "cells", &[part.body_cells().len() as f64, part.ghost_cells() as f64]);
}

fn run_drawn(world: &World, name: &str) -> Outcome {
    let mut part = world.divide(&DrawnBlock::mesh(4)?)?;
    if name != "unnamed" {
        part = part.with_surfaces(&SURFACES[..1])?.with_surfaces(&SURFACES[1..])?;
    }
    let block = DrawnBlock::on(&part, drawn_pairs(name))?;
    let mut solver = PetscSolver::for_part(&part, &[&block.held(1.0)?], Method::Direct)?;
    let (mut steps, mut before, mut last) = (vec![], None, None);
    block.draw(|problem, step| {
        let solved = problem.direct()?.on(&part).solver(&mut solver).increment(step).solve()?;
        steps.push(solved.iterations() as f64);
        before = Some(step.before.clone());
        last = Some(solved.clone());
        Ok(solved)
    })?;
    let (last, before) = last.zip(before).ok_or("no step was taken")?;
    tell(world, "steps", &steps);
    tell_pairs(world, &part, &last);
    let u = last.into_field();
    let problem = block.step(1.0, &before)?;
    tell(world, "u", &whole(&part, &u)?);
    tell(world, "J", &[part.functional(block.assembler(), &problem.law.criterion(&u))?]);
    let force = block.of_block(&before)?.contact_force(&u);
    tell(world, "force", &[part.functional(block.assembler(), &force)?]);
    if name != "segments" {
        let adjoint = problem.adjoint(&u)?.on(&part).solver(&mut solver).solve()?;
        tell(world, "adjoint", &whole(&part, adjoint.field())?);
    }
    Ok(())
}

fn run_blocks(world: &World, name: &str, times: usize) -> Outcome {
    // Where nodes hang, the number is the degree.
    let (times, degree) = if name == "blocks trees" { (1, times) } else { (times, 1) };
    let mesh = || if name == "blocks trees" { blocks_trees() } else { blocks_mesh(times) };
    let part = world.scatter(|| mesh().map_err(|error| error.to_string()))?;
    let part = part.with_surfaces(&SURFACES)?;
    let space = Space::vector(&part, degree)?;
    // A checkpoint with a file of the parts next to it: one that is there has the state.
    let path = std::env::args().nth(5);
    if let Some(stored) = path.as_ref().map(|path| PartCheckpoint::read(&part, path)).transpose()?.flatten() {
        let of_cells = stored.field("stiffness", &Space::discontinuous_scalar(&part, 0)?)?;
        let largest = of_cells.values().iter().copied().fold(0.0, f64::max);
        tell(world, "stiffness", &[world.gather(largest.to_bits())?.into_iter().map(f64::from_bits).sum()]);
        tell(world, "u", &whole(&part, &stored.field("u", &space)?)?);
        return Ok(());
    }
    let completed = |field: Field<3>| match name {
        "material" => Ok(field),
        _ => Ok(part.completed(&field)?),
    };
    let (mut u, mut steps) = (Field::zero(&space), vec![]);
    for factor in FACTORS {
        let problem = blocks(&space, factor, &u, &completed)?;
        let mut solver = PetscSolver::for_part(&part, &[&problem.constraints], Method::Direct)?;
        let solved = problem.direct()?.on(&part).solver(&mut solver).solve()?;
        steps.push(solved.iterations() as f64);
        if factor == 1.0 {
            tell_steps(world, &solved.history);
            tell_pairs(world, &part, &solved);
            let force = force_on_block(&problem.law, solved.field());
            tell(world, "force", &[part.functional(&problem.assembler, &force)?]);
            tell(world, "reaction", &part.reaction(&solved, 0, "slab bottom")?);
            let adjoint = problem.adjoint(solved.field())?.on(&part).solver(&mut solver).solve()?;
            tell(world, "adjoint", &whole(&part, adjoint.field())?);
        }
        u = solved.into_field();
    }
    tell(world, "all_steps", &steps);
    tell(world, "u", &whole(&part, &u)?);
    if let Some(path) = path {
        let stiffness = stiffness_of_cells(&part)?;
        PartCheckpoint::new(&part).field("u", &u)?.field("stiffness", &stiffness)?.write(&path)?;
        let path = Path::new(&path).with_extension("vtu");
        VtuFile::new(&part)
            .point_data("u", &u)?
            .point_data("stiffness", &stiffness)?
            .on(&part)
            .write(path)?;
    }
    Ok(())
}

fn run_ring(world: &World) -> Outcome {
    let mut part = world.structured(RING, CellShape::Quadrilateral, 1, place)?;
    part.name_facets("skin", "boundary", is_skin)?;
    part.name_facets("back", "top", |x| x[0] < -1.2)?;
    part.name_facets("pushed down", "top", |x| x[0] > 0.9 && x[1] > 0.0)?;
    part.name_facets("pushed up", "top", |x| x[0] > 0.9 && x[1] < 0.0)?;
    let part = part.with_surfaces(&["skin"])?;
    let problem = ring(&part)?;
    let mut solver = PetscSolver::for_part(&part, &[&problem.constraints], Method::Direct)?;
    let solved = problem.direct()?.on(&part).solver(&mut solver).solve()?;
    tell_steps(world, &solved.history);
    tell_pairs(world, &part, &solved);
    tell(world, "u", &whole(&part, solved.field())?);
    Ok(())
}

fn run_memory(world: &World) -> Outcome {
    let part = world.divide(&DrawnBlock::mesh(4)?)?.with_surfaces(&SURFACES)?;
    let block = Remembering::on(&part, drawn_pairs(""))?;
    let mut solver = PetscSolver::for_part(&part, &[&block.block.held(1.0)?], Method::Direct)?;
    let (u, law) = block.drawn(|problem, step| {
        Ok(problem.direct()?.on(&part).solver(&mut solver).increment(step).solve()?)
    })?;
    if let Some(path) = std::env::args().nth(5) {
        let (assembler, slip) = (block.assembler(), &block.data.elastic_slip);
        let Some(stored) = PartCheckpoint::read(&part, &path)? else {
            return Ok(PartCheckpoint::new(&part).history("slip", assembler, slip)?.write(path)?);
        };
        // The slip that other processes stored, next to the one that was found here.
        let own = assembler.history_values(slip)?.concat();
        stored.history("slip", assembler, slip)?;
        let read = assembler.history_values(slip)?.concat();
        let size = own.iter().map(|own| own.abs()).sum();
        let difference = own.iter().zip(&read).map(|(own, read)| (own - read).abs()).sum();
        tell(world, "stored", &world.sum(&[size, difference])?);
    }
    tell(world, "u", &whole(&part, &u)?);
    tell(world, "force", &[part.functional(block.assembler(), &law.contact_force(&u))?]);
    Ok(())
}
