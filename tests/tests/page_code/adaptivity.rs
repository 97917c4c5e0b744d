//! `docs/adaptivity.md` and `docs/eigenproblems.md`.

use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate};
use forms_fem::contract::Form;
use forms_fem::prelude::*;
use forms_fem::solve::Eigenproblem;

#[forms]
pub mod reaction {
    #[cells]
    pub struct Omega;
    pub fn direct(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + u * v - v)
    }
    pub fn goal(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }
    pub fn squared(u: State<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, sqr(u) * q)
    }
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(direct(u, p), u, q) + derivative(goal(u), u, q)
    }
    pub fn localised(u: State<Scalar>, z: State<Scalar>, q: Test<Scalar>) -> Form {
        direct(u, q * z)
    }
}

type Solver = dyn Fn(&Mesh<2>, Option<&Field<2>>) -> Result<(Field<2>, ErrorEstimate, f64), Failure>;

pub fn cycle(coarse: Mesh<2>, solve: &Solver) -> Result<Field<2>, Failure> {
    let adapted = Adaptation::to_tolerance(1e-4).run(coarse, |mesh, before| {
        let (u, estimate, goal) = solve(mesh, before)?;
        Ok::<_, Failure>(AdaptiveSolution::new(u, estimate).with_goal(goal))
    }, |step| println!("{step}")).map_err(|error| error.to_string())?;
    Ok(adapted.solution.field)
}

pub fn estimates(
    (assembler, space): (&Assembler<2>, &Arc<Space<2>>),
    model: &reaction::Model,
    (u, p): (Field<2>, Field<2>),
) -> Result<[ErrorEstimate; 2], Failure> {
    let of_goal = {
        let estimate = ErrorEstimate::dual_weighted(&assembler, &p, &space, |z| model.localised(&u, z))?;
        estimate
    };
    let estimate = ErrorEstimate::residual(&assembler, &model.squared(&u))?;
    Ok([of_goal, estimate])
}

/// The forms of a page.
pub struct Forms {
    stiffness: Form<2>,
    mass: Form<2>,
    geometric: Form<2>,
}

impl Forms {
    fn stiffness(&self) -> Form<2> {
        self.stiffness.clone()
    }

    fn mass(&self) -> Form<2> {
        self.mass.clone()
    }

    fn geometric(&self, _: &Field<2>) -> Form<2> {
        self.geometric.clone()
    }
}

pub fn modes(
    model: &Forms,
    space: Arc<Space<2>>,
    (loaded, held): (Field<2>, Constraints<2>),
) -> Result<usize, Failure> {
    let modes = Eigenproblem::vibration(&model.stiffness(), &model.mass(), &space).constrained(&held).smallest(6)?;
    for mode in &modes {
        println!("ω² {} ± {}, residual {}", mode.value, mode.error_bound, mode.residual);
    }
    let loads = Eigenproblem::buckling(&model.stiffness(), &model.geometric(&loaded), &space).constrained(&held).smallest(2)?;
    Ok(modes.len() + loads.len())
}
