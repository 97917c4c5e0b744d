//! Problems whose solution has a given mean, because fluxes on all of the boundary leave it open: by an unknown of the whole body, and by a
//! prescribed node.

use std::error::Error;

use forms_fem::element::Elements;
use forms_fem::prelude::*;
use forms_fem::space::Scope;

use super::parts::whole;
use super::report::{tell, tell_steps};
use crate::method::Method;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// The mean of the solution.
pub const MEAN: f64 = 0.25;

/// The forms.
#[forms(dimension = 2)]
pub mod fluxes {
    /// The body.
    #[cells]
    pub struct Omega;
    /// A side with a flux.
    #[facets]
    pub struct Side;

    /// Diffusion that is better where there is much, with a load and a flux that do not balance.
    pub fn flow(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + sqr(u)) * dot(grad(u), grad(v)) - x[0] * v) - integral(Side, x[1] * v)
    }
    /// The same with the mean 1/4, whose multiplier is an unknown of the whole body.
    pub fn with_mean(u: Unknown<Scalar>, m: Unknown<Scalar>, v: Test<Scalar>, w: Test<Scalar>) -> Form {
        flow(u, v) + integral(Omega, m * v + (u - 0.25) * w)
    }
    /// −Δu = x − 1 with a flux of 1 − 2 y, which balance.
    pub fn balanced(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - (x[0] - 1) * v) - integral(Side, (1 - 2 * x[1]) * v)
    }
    /// ∫ u
    pub fn total(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }
}

/// Upper corner and numbers of cells of the body.
pub const SIZE: ([f64; 2], [usize; 2]) = ([2.0, 1.0], [6, 5]);

/// The forms with their side.
pub fn model() -> fluxes::Model {
    fluxes::Model { regions: fluxes::Regions::default().side("right") }
}

/// The unknown with the multiplier of its mean.
pub struct WithMean {
    form: Form<2>,
    spaces: [Arc<Space<2>>; 2],
    free: [Constraints<2>; 2],
}

impl WithMean {
    /// On a mesh of the body, or a part of it.
    ///
    /// # Errors
    /// A mesh without a right side.
    pub fn on(mesh: &Mesh<2>) -> Result<Self, Box<dyn Error>> {
        let of_body = Space::of(mesh, Elements::Lagrange(0), Scope::Body, &[])?;
        let spaces = [Space::scalar(mesh, 2)?, of_body];
        let free = spaces.each_ref().map(Constraints::new);
        Ok(WithMean { form: model().with_mean(), spaces, free })
    }

    /// The problem of both unknowns.
    pub fn problem(&self) -> Problem<'_, 2, 2> {
        let [values, multipliers] = &self.spaces;
        let problem = Problem::new(&self.form, [values, multipliers]).threads(Threads::new(1));
        problem.constrained(&self.free[0]).constrained(&self.free[1])
    }
}

/// Tells solutions on parts: "mean" has the multiplier, "pinned" a prescribed node.
///
/// # Errors
/// Those of the problem.
pub fn run(world: &World, name: &str) -> Result<(), Box<dyn Error>> {
    let (upper, cells) = SIZE;
    let part = world.rectangle([0.0; 2], upper, cells, CellShape::Triangle, 1)?;
    if name == "multiplier" {
        let case = WithMean::on(&part)?;
        let mut solver = PetscSolver::for_part(&part, &[&case.free[0], &case.free[1]], Method::Direct)?;
        let solved = case.problem().on(&part).solver(&mut solver).solve()?;
        let [u, m] = &solved.fields;
        tell_steps(world, &solved.history);
        tell(world, "u", &whole(&part, u)?);
        tell(world, "m", m.values());
        return Ok(());
    }
    let space = Space::scalar(&part, 2)?;
    let mut held = Constraints::new(&space);
    part.fix_nearest(&mut held, &[1.1, 0.4], &[0.0])?;
    let form = model().balanced();
    let mut solver = PetscSolver::for_part(&part, &[&held], Method::conjugate_gradients())?;
    let problem = Problem::new(&form, &space).constrained(&held).threads(Threads::new(1));
    let mut u = problem.on(&part).solver(&mut solver).solve()?.into_field();
    let assembler = Assembler::new(&part).with_threads(Threads::new(1));
    let mean = |u: &Field<2>| part.functional(&assembler, &model().total(u)).map(|total| total / 2.0);
    let shift = MEAN - mean(&u)?;
    let shifted = u.values().iter().map(|value| value + shift).collect();
    u = Field::from_values(&space, shifted)?;
    tell(world, "u", &whole(&part, &u)?);
    tell(world, "mean", &[mean(&u)?]);
    Ok(())
}
