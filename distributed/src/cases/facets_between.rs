//! Integrals over interior facets: discontinuous elements for diffusion, a penalty on jumps of gradients, and a functional of a named surface.

use std::error::Error;

use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;

use super::parts::{refined, whole};
use super::report::{tell, tell_steps};
use crate::method::Method;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// The forms.
#[forms(dimension = 3)]
pub mod jumps {
    /// The body.
    #[cells]
    pub struct Omega;
    /// Between its cells.
    #[interior_facets]
    pub struct Inner;
    /// The part of the boundary with u = x.
    #[facets]
    pub struct Held;

    fn flux(w: Scalar) -> Scalar {
        dot(avg(grad(w)), n)
    }
    /// Interior penalty, with the conductivity 1 + u² and u = x₁ at a side.
    pub fn penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + sqr(u)) * dot(grad(u), grad(v)) - (1 + x[1]) * v)
            + integral(Inner, 20 / avg(h) * jump(u) * jump(v) - flux(u) * jump(v) - flux(v) * jump(u))
            + integral(Held, 20 / h * (u - x[0]) * v)
    }
    /// Continuous diffusion with a penalty on jumps of gradients.
    pub fn smooth(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - (1 + x[1]) * v)
            + integral(Inner, sqr(avg(h)) / 10 * dot(jump(grad(u)), n) * dot(jump(grad(v)), n))
            + integral(Held, 20 / h * (u - x[0]) * v)
    }
    /// ∫ ⟦u⟧² + ∇u·∇u on both sides, over interior facets.
    pub fn roughness(u: State<Scalar>) -> Functional {
        integral(Inner, sqr(jump(u)) + avg(dot(grad(u), grad(u))))
    }
    /// Squares of indicators of cells.
    pub fn squares(u: State<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, sqr(h) * sqr(1 + x[1]) * q)
            + integral(Inner, avg(h) * sqr(dot(jump(grad(u)), n)) / 2 * avg(q))
    }
}

/// A problem on the unit cube, or a part of it.
pub struct Jumps {
    form: Form<3>,
    /// Discontinuous, or continuous.
    pub space: Arc<Space<3>>,
    /// None, but at hanging nodes.
    pub free: Constraints<3>,
}

/// The forms; `inner` are all interior facets, or some.
pub fn model(inner: &'static str) -> jumps::Model {
    jumps::Model { regions: jumps::Regions::default().inner(inner).held("left") }
}

impl Jumps {
    /// "penalty" or "smooth"; "smooth trees" on a mesh with hanging nodes.
    ///
    /// # Errors
    /// A mesh without a left side.
    pub fn on(mesh: &Mesh<3>, name: &str) -> Result<Self, Box<dyn Error>> {
        let (space, form) = match name {
            "penalty" | "penalty trees" => {
                (Space::discontinuous_scalar(mesh, 1)?, model("interior").penalty())
            }
            _ => (Space::scalar(mesh, 2)?, model("interior").smooth()),
        };
        let mut free = Constraints::new(&space);
        if name == "smooth trees" {
            free.join_hanging_nodes()?;
        }
        Ok(Jumps { form, space, free })
    }

    /// The problem.
    pub fn problem(&self) -> Problem<'_, 3> {
        Problem::new(&self.form, &self.space).constrained(&self.free).threads(Threads::new(1))
    }
}

/// A plane between cells.
pub fn is_in_middle(x: &[f64; 3]) -> bool {
    (x[0] - 0.5).abs() < 1e-9
}

/// The mesh of all processes.
///
/// # Errors
/// None with these numbers.
pub fn mesh(shape: CellShape) -> Result<Mesh<3>, MeshError> {
    cuboid([0.0; 3], [1.0; 3], [4, 3, 3], shape, 1)
}

/// The mesh of hexahedra with some of them divided at the middle plane.
///
/// # Errors
/// None with these numbers.
pub fn trees() -> Result<Mesh<3>, MeshError> {
    refined(mesh(CellShape::Hexahedron)?, &[0.4, 0.3, 0.5], &[0.3])
}

/// Tells a solution on parts: "penalty", or "smooth" on a mesh that is divided along a curve or by a graph, or either on one with hanging nodes.
///
/// # Errors
/// Those of the problem.
pub fn run(world: &World, name: &str) -> Result<(), Box<dyn Error>> {
    let mut part = match name {
        "penalty" => world.cuboid([0.0; 3], [1.0; 3], [4, 3, 3], CellShape::Hexahedron, 1)?,
        "smooth" => world.divide(&mesh(CellShape::Tetrahedron)?)?,
        _ => world.divide(&trees()?)?,
    };
    part = part.with_interior_facets()?;
    part.name_interior_facets("middle", "interior", is_in_middle)?;
    let case = Jumps::on(&part, name)?;
    let mut solver = PetscSolver::for_part(&part, &[&case.free], Method::Direct)?;
    let solved = case.problem().on(&part).solver(&mut solver).solve()?;
    let u = solved.field();
    tell_steps(world, &solved.history);
    if name.starts_with("smooth") {
        tell(world, "u", &whole(&part, u)?);
    }
    let assembler = solved.assembler();
    let roughness =
        ["interior", "middle"].map(|inner| part.functional(assembler, &model(inner).roughness(u)));
    let [all, middle] = roughness;
    tell(world, "roughness", &[all?, middle?]);
    tell(world, "norm", &[part.dot(u, u)?]);
    let cells = Space::discontinuous_scalar(&part, 0)?;
    let squares = part.linear_form(assembler, &model("interior").squares(u), &cells)?;
    let squares = Field::from_values(&cells, squares)?;
    let weight = Field::interpolate(&cells, |x| 1.0 + x[0] + (3.0 * x[1]).sin() + x[2])?;
    tell(world, "indicators", &[part.dot(&squares, &squares)?, part.dot(&squares, &weight)?]);
    tell(
        world,
        "copies",
        &world.gather(part.ghost_cells() as u64)?.iter().map(|n| *n as f64).collect::<Vec<_>>(),
    );
    Ok(())
}
