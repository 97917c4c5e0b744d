//! A cycle of adaptivity on parts: the first process refines the mesh and scatters it again, and all solve and estimate on their parts.

use std::error::Error;

use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate};
use forms_fem::mesh::{AdaptiveMesh, MeshError, doerfler};
use forms_fem::prelude::*;

use super::adaptive::membrane;
use super::parts::whole;
use super::report::tell;
use crate::method::Method;
use crate::part::MeshPart;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// Unknowns with which the cycle ends.
const UNKNOWNS: usize = 400;
/// Part of the estimate that the marked cells have.
const FRACTION: f64 = 0.5;

/// An error of a solution.
type Failure = Box<dyn Error>;

/// The mesh of the first step. Of quadrilaterals nodes hang in the others.
fn coarse(shape: CellShape) -> Result<Mesh<2>, MeshError> {
    rectangle([0.0; 2], [1.0; 2], [4, 3], shape, 1)
}

fn model() -> membrane::Model<2> {
    let load = |x: &[f64; 2]| 50.0 * (-60.0 * ((x[0] - 0.3).powi(2) + (x[1] - 0.2).powi(2))).exp();
    membrane::Model::new(membrane::data().load(load))
}

/// A space on the mesh, or on a part of it, with its conditions.
fn held(mesh: &Mesh<2>, degree: usize) -> Result<Constraints<2>, Failure> {
    let mut held = Constraints::new(&Space::scalar(mesh, degree)?);
    held.join_hanging_nodes()?;
    held.fix("boundary", |_| 0.0)?;
    Ok(held)
}

/// Results of a cycle.
pub struct Adapted {
    /// Cells of each mesh.
    pub cells: Vec<f64>,
    /// The estimate on each.
    pub estimates: Vec<f64>,
    /// The values at the vertices of the last mesh.
    pub values: Vec<f64>,
    /// Those of the solution before, on the last mesh.
    pub start: Vec<f64>,
}

/// The cycle on one process from a mesh of this shape, with elements of this degree and `at_vertices` of a field.
///
/// # Errors
/// Those of the cycle.
pub fn on_one(
    (shape, degree): (CellShape, usize),
    at_vertices: impl Fn(&Field<2>) -> Vec<f64>,
) -> Result<Adapted, Failure> {
    let (model, mut start) = (model(), vec![]);
    let balance = model.balance();
    let adapted = Adaptation::to_unknowns(UNKNOWNS).marking(FRACTION).run(
        coarse(shape)?,
        |mesh, before| {
            let held = held(mesh, degree)?;
            let before =
                before.map_or(Ok(Field::zero(held.space())), |u| u.onto(held.space()).interpolated())?;
            start = at_vertices(&before);
            let solved = Problem::new(&balance, held.space()).constrained(&held).solve()?;
            let (u, assembler) = (solved.field(), solved.assembler());
            let estimate = ErrorEstimate::residual(assembler, &model.residual(u))?;
            Ok::<_, Failure>(AdaptiveSolution::new(u.clone(), estimate))
        },
        |_| {},
    )?;
    let cells = adapted.steps.iter().map(|step| step.cells as f64).collect();
    let estimates = adapted.steps.iter().map(|step| step.estimate).collect();
    Ok(Adapted { cells, estimates, values: at_vertices(&adapted.solution.field), start })
}

/// The whole mesh and the last solution, which the first process keeps between two cycles.
struct Whole {
    mesh: AdaptiveMesh<2>,
    /// The solution on the mesh before.
    before: Option<Field<2>>,
}

/// The squares of the indicators of all cells, on the first process.
fn squares_of_all(
    part: &MeshPart<'_, 2>,
    u: &Field<2>,
    whole: Option<&Whole>,
) -> Result<Option<Vec<f64>>, Failure> {
    let cells = Space::discontinuous_scalar(part, 0)?;
    let assembler = Assembler::new(part).with_threads(Threads::new(1));
    let squares = part.linear_form(&assembler, &model().residual(u), &cells)?;
    let of_all = whole.map(|whole| Space::discontinuous_scalar(whole.mesh.mesh(), 0)).transpose()?;
    let Some(found) = part.on_first(&Field::from_values(&cells, squares)?, of_all.as_ref())? else {
        return Ok(None);
    };
    let of_cell =
        |cell| found.space().cell_nodes(cell).iter().map(|node| found.values()[*node as usize]).sum();
    Ok(Some((0..found.space().mesh().cell_count()).map(of_cell).collect()))
}

/// Tells the results of the cycle on parts.
///
/// # Errors
/// Those of the cycle.
pub fn run(world: &World, (shape, degree): (CellShape, usize)) -> Result<(), Failure> {
    let mut first = match world.rank() {
        0 => Some(Whole { mesh: AdaptiveMesh::new(coarse(shape)?)?, before: None }),
        _ => None,
    };
    let (mut cells, mut estimates) = (vec![], vec![]);
    loop {
        let mesh = first.as_ref().map(|whole| whole.mesh.mesh().clone());
        let part =
            world.scatter(|| mesh.clone().ok_or("the first process has the mesh"))?.with_interior_facets()?;
        let held = held(&part, degree)?;
        let of_all = mesh.as_ref().map(|mesh| Space::scalar(mesh, degree)).transpose()?;
        let carried = match (&of_all, first.as_ref().and_then(|whole| whole.before.as_ref())) {
            (Some(space), Some(before)) => Some(before.onto(space).interpolated()?),
            (Some(space), None) => Some(Field::zero(space)),
            _ => None,
        };
        let start = part.from_first(held.space(), carried.as_ref())?;
        let form = model().balance();
        let mut solver = PetscSolver::for_part(&part, &[&held], Method::Direct)?;
        let problem = Problem::new(&form, held.space()).constrained(&held).start(&start);
        let solved = problem.threads(Threads::new(1)).on(&part).solver(&mut solver).solve()?;
        let u = solved.field();
        let squares = squares_of_all(&part, u, first.as_ref())?;
        let before = part.on_first(u, of_all.as_ref())?;
        // The others learn from the first one when it ends.
        let own = of_all.map_or(0, |space| space.unknowns() as u64);
        let is_last = world.gather(own)?[0] >= UNKNOWNS as u64;
        if let (Some(whole), Some(squares)) = (&mut first, &squares) {
            cells.push(squares.len() as f64);
            estimates.push(squares.iter().sum::<f64>().sqrt());
            if !is_last {
                let marked = doerfler(squares, FRACTION)?;
                *whole = Whole { mesh: whole.mesh.refined_onto(&marked, &[])?.0, before };
            }
        }
        if is_last {
            tell(world, "cells", &cells);
            tell(world, "estimates", &estimates);
            tell(world, "u", &self::whole(&part, u)?);
            tell(world, "start", &self::whole(&part, &start)?);
            return Ok(());
        }
    }
}
