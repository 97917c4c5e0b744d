//! Poisson's equation on the unit square, with inputs that may differ from process to process in a wrong program.

use std::error::Error;

use forms_fem::prelude::*;

use crate::method::Method;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// The forms.
#[forms]
pub mod forms {
    /// The load.
    pub struct Data {
        /// f \[unknown/length²\].
        pub load: Param,
    }
    /// The square.
    #[cells]
    pub struct Omega;

    /// ∫ ∇u·∇v − f v
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - load * v)
    }
    /// ∫ u
    pub fn total(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }
}

/// Input of a process.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// Cells along a side.
    pub cells: usize,
    /// Degree of the elements.
    pub degree: usize,
    /// f.
    pub load: f64,
    /// u on the boundary.
    pub boundary: f64,
    /// Region where u is prescribed.
    pub region: &'static str,
}

impl Default for Given {
    fn default() -> Self {
        Given { cells: 8, degree: 2, load: 1.0, boundary: 0.0, region: "boundary" }
    }
}

/// The problem.
pub struct Poisson {
    load: f64,
    /// −Δu = f.
    pub form: Form<2>,
    /// The space of u.
    pub space: Arc<Space<2>>,
    /// u on the boundary.
    pub constraints: Constraints<2>,
}

impl Poisson {
    /// The problem with these inputs on quadrilaterals.
    ///
    /// # Errors
    /// No cells, or a region that does not exist.
    pub fn new(given: Given) -> Result<Self, Box<dyn Error>> {
        let cells = [given.cells; 2];
        Self::on(rectangle([0.0; 2], [1.0; 2], cells, CellShape::Quadrilateral, 1)?, given)
    }

    /// The problem with these inputs on a mesh.
    ///
    /// # Errors
    /// A region that does not exist.
    pub fn on(mesh: Mesh<2>, given: Given) -> Result<Self, Box<dyn Error>> {
        let space = Space::scalar(&mesh, given.degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix(given.region, |_| given.boundary)?;
        let form = forms::Model::new(forms::data().load(given.load)).balance();
        Ok(Poisson { load: given.load, form, space, constraints })
    }

    /// The solution on all processes.
    ///
    /// # Errors
    /// Of PETSc and of the problem.
    pub fn solve(&self, world: &World) -> Result<Solved<2>, Box<dyn Error>> {
        let mut solver = PetscSolver::new(world, &self.constraints, Method::Direct)?;
        Ok(self.problem().on(world).solver(&mut solver).solve()?)
    }

    /// The problem, on one process so far.
    pub fn problem(&self) -> Problem<'_, 2> {
        Problem::new(&self.form, &self.space).constrained(&self.constraints)
    }

    /// ∫ u of a solution.
    ///
    /// # Errors
    /// Those of [`Solved::functional`].
    pub fn total(&self, solved: &Solved<2>) -> Result<f64, AssemblyError> {
        solved.functional(&forms::Model::new(forms::data().load(self.load)).total(solved.field()))
    }
}
