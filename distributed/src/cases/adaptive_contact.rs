//! A cycle of adaptivity with contact between two bodies: the first process refines both of them and scatters them again; all find the pairs, solve and estimate.

use std::error::Error;

use forms_fem::mesh::{AdaptiveMesh, doerfler};
use forms_fem::prelude::*;

use super::parts::whole;
use super::report::tell;
use crate::method::Method;
use crate::part::MeshPart;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// The forms.
#[forms(dimension = 2)]
pub mod touching {
    use forms_contact::operators::linear_elastic::stress;

    /// Constants.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
        /// Pressure over depth.
        pub stiffness: Param,
    }
    /// Both bodies.
    #[cells]
    pub struct Omega;
    /// Between their cells.
    #[interior_facets]
    pub struct Inner;
    /// Their surfaces.
    #[pairs]
    pub struct Touch;

    fn pressure(u: Vector) -> Scalar {
        stiffness * pos_part(dot(jump(u), toward) - gap)
    }
    /// Elastic bodies with springs where they touch.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) + integral(Touch, pressure(u) * dot(jump(v), toward))
    }
    /// Squares of indicators of cells: jumps of tractions, and pressures.
    pub fn squares(u: State<Vector>, q: Test<Scalar>) -> Form {
        let jumped = jump(stress(u)) * n;
        integral(Inner, avg(h) * dot(jumped, jumped) / 2 * avg(q))
            + integral(Touch, sqr(pressure(u)) / 20 * this(q))
    }
}

/// The surfaces that touch.
const SURFACES: [&str; 2] = ["lower top", "upper bottom"];
/// Meshes of the cycle.
const MESHES: usize = 5;
/// Part of the estimate that the marked cells have.
const FRACTION: f64 = 0.7;

/// An error of a solution.
type Failure = Box<dyn Error>;

/// Both bodies in the first step. Of quadrilaterals nodes hang in the others.
fn coarse(shape: CellShape) -> Result<AdaptiveMesh<2>, Failure> {
    let lower = rectangle([0.0; 2], [2.0, 1.0], [7, 3], shape, 1)?;
    let upper = rectangle([0.45, 1.005], [1.35, 1.6], [3, 2], shape, 1)?;
    Ok(AdaptiveMesh::new(Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)])?)?)
}

fn model() -> touching::Model<2> {
    let regions = touching::Regions::default().touch(Pairing::between(SURFACES[0], SURFACES[1]));
    touching::Model { data: touching::data().lambda(1.5).mu(1.0).stiffness(200.0), regions }
}

/// A space on both bodies, or on a part of them, with its conditions.
fn held(mesh: &Mesh<2>) -> Result<Constraints<2>, Failure> {
    let mut held = Constraints::new(&Space::vector(mesh, 2)?);
    held.join_hanging_nodes()?;
    held.fix("lower bottom", |_| [0.0; 2])?;
    held.fix("upper top", |x| [0.02, -0.05 - 0.01 * x[0]])?;
    Ok(held)
}

/// Values of all cells of a discontinuous space of degree 0.
fn of_cells(field: &Field<2>) -> Vec<f64> {
    let value = |cell| field.at_node(field.space().cell_nodes(cell)[0] as usize)[0];
    (0..field.space().mesh().cell_count()).map(value).collect()
}

/// Results of a cycle.
#[derive(Default)]
pub struct Adapted {
    /// Cells of each mesh.
    pub cells: Vec<f64>,
    /// The estimate on each.
    pub estimates: Vec<f64>,
    /// The values at the vertices of the last mesh.
    pub values: Vec<f64>,
}

impl Adapted {
    /// Adds the squares of a mesh's indicators, and gives the refined one.
    fn refined(&mut self, mesh: &AdaptiveMesh<2>, squares: &[f64]) -> Result<AdaptiveMesh<2>, Failure> {
        self.cells.push(squares.len() as f64);
        self.estimates.push(squares.iter().sum::<f64>().sqrt());
        Ok(mesh.refined_onto(&doerfler(squares, FRACTION)?, &[])?.0)
    }
}

/// The cycle on one process from a mesh of this shape, with `at_vertices` of a field.
///
/// # Errors
/// Those of the cycle.
pub fn on_one(shape: CellShape, at_vertices: impl Fn(&Field<2>) -> Vec<f64>) -> Result<Adapted, Failure> {
    let (mut mesh, mut found, form) = (coarse(shape)?, Adapted::default(), model().balance());
    for _ in 0..MESHES {
        let held = held(mesh.mesh())?;
        let solved = Problem::new(&form, held.space()).constrained(&held).solve()?;
        let cells = Space::discontinuous_scalar(mesh.mesh(), 0)?;
        let squares = solved.assembler().linear_form(&model().squares(solved.field()), &cells)?;
        mesh = found.refined(&mesh, &of_cells(&Field::from_values(&cells, squares)?))?;
        found.values = at_vertices(solved.field());
    }
    Ok(found)
}

/// A part with both surfaces whole and with interior facets, in either order.
fn complete(part: MeshPart<'_, 2>, shape: CellShape) -> Result<MeshPart<'_, 2>, Failure> {
    Ok(match shape {
        CellShape::Triangle => part.with_interior_facets()?.with_surfaces(&SURFACES)?,
        _ => part.with_surfaces(&SURFACES)?.with_interior_facets()?,
    })
}

/// Tells the results of the cycle on parts.
///
/// # Errors
/// Those of the cycle.
pub fn run(world: &World, shape: CellShape) -> Result<(), Failure> {
    let (mut mesh, mut found) = (None, Adapted::default());
    if world.rank() == 0 {
        mesh = Some(coarse(shape)?);
    }
    for _ in 0..MESHES {
        let all = mesh.as_ref().map(|mesh| mesh.mesh().clone());
        let part = world.scatter(|| all.clone().ok_or("the first process has the mesh"))?;
        let part = complete(part, shape)?;
        let (held, form) = (held(&part)?, model().balance());
        let mut solver = PetscSolver::for_part(&part, &[&held], Method::Direct)?;
        let problem = Problem::new(&form, held.space()).constrained(&held).threads(Threads::new(1));
        let solved = problem.on(&part).solver(&mut solver).solve()?;
        let cells = Space::discontinuous_scalar(&part, 0)?;
        let squares = part.linear_form(solved.assembler(), &model().squares(solved.field()), &cells)?;
        let of_all = all.map(|mesh| Space::discontinuous_scalar(&mesh, 0)).transpose()?;
        let squares = part.on_first(&Field::from_values(&cells, squares)?, of_all.as_ref())?;
        if let (Some(own), Some(squares)) = (&mesh, squares) {
            mesh = Some(found.refined(own, &of_cells(&squares))?);
        }
        found.values = whole(&part, solved.field())?;
    }
    tell(world, "cells", &found.cells);
    tell(world, "estimates", &found.estimates);
    tell(world, "u", &found.values);
    Ok(())
}
