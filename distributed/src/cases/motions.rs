//! Motions that several processes follow together: a bar that strikes an obstacle, an explicit wave in it, and water that is squeezed out of a
//! porous body.

use std::error::Error;

use forms_contact::impact::impact;
use forms_fem::prelude::*;
use forms_fem::time::{CentralDifferences, GeneralisedAlpha, Mass, OneStepTheta, State, Step, TimeLoop};

/// A porous body (Biot): displacements u, and the pressure p of the water in it.
#[forms(dimension = 2)]
pub mod porous {
    use forms_fem::time::operators::vector::{displacement, velocity};
    use forms_fem::time::operators::vector_and_scalar::value;

    #[includes(forms_fem::time::operators::vector_and_scalar::Data)]
    pub struct Data {
        /// μ \[stress\].
        pub mu: Param,
        /// Permeability over viscosity \[length⁴/(force · time)\].
        pub permeability: Param,
    }
    /// The body.
    #[cells]
    pub struct Omega;
    /// The loaded side.
    #[facets]
    pub struct Top;

    /// Balance of forces under a pressure of one from above, and of the water.
    pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(displacement(u)), eps(v)) - value(p) * div(v))
            + integral(Omega, div(velocity(u)) * q + permeability * dot(grad(value(p)), grad(q)))
            + integral(Top, dot(n, v))
    }
}

/// Which motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A bar that flies against an obstacle, by the trapezoidal rule: Newton's method in each step.
    Impact,
    /// The same bar by central differences with the consistent mass matrix: affine in the accelerations.
    Explicit,
    /// The same with lumped masses, on elements of degree 1.
    Lumped,
    /// Water that is squeezed out: two unknowns, affine.
    Porous,
}

impl Motion {
    /// All, with their names.
    pub const ALL: [(&'static str, Motion); 4] = [
        ("impact", Motion::Impact),
        ("explicit", Motion::Explicit),
        ("lumped", Motion::Lumped),
        ("porous", Motion::Porous),
    ];

    /// The one of a name.
    ///
    /// # Errors
    /// A name that no motion has.
    pub fn named(name: &str) -> Result<Self, Box<dyn Error>> {
        let known = Self::ALL.iter().find(|(own, _)| *own == name);
        known.map(|(_, motion)| *motion).ok_or_else(|| format!("no motion is called {name}").into())
    }

    /// Upper corner and numbers of cells of the body.
    pub const SIZE: ([f64; 2], [usize; 2]) = ([3.0, 1.0], [12, 4]);

    /// Spaces of the unknowns on 12 × 4 cells, and their conditions.
    ///
    /// # Errors
    /// Regions that do not exist.
    pub fn conditions(self) -> Result<Vec<Constraints<2>>, Box<dyn Error>> {
        let (upper, cells) = Self::SIZE;
        self.conditions_on(&rectangle([0.0; 2], upper, cells, CellShape::Quadrilateral, 1)?)
    }

    /// The same on this mesh, or a part of it.
    ///
    /// # Errors
    /// Regions that do not exist.
    pub fn conditions_on(self, mesh: &Mesh<2>) -> Result<Vec<Constraints<2>>, Box<dyn Error>> {
        let degree = if self == Motion::Lumped { 1 } else { 2 };
        let mut held = Constraints::new(&Space::vector(mesh, degree)?);
        if self != Motion::Porous {
            return Ok(vec![held]);
        }
        held.fix("bottom", |_| [0.0; 2])?;
        held.fix_component("left", 0, |_| 0.0)?;
        held.fix_component("right", 0, |_| 0.0)?;
        let mut drained = Constraints::new(&Space::scalar(mesh, 1)?);
        drained.fix("top", |_| 0.0)?;
        Ok(vec![held, drained])
    }

    /// The motion from its start, before the first step, and the size of a step.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn begin<'a>(self, conditions: &[Constraints<2>]) -> Result<(TimeLoop<'a, 2>, f64), Box<dyn Error>> {
        let space = conditions[0].space();
        let moving = || -> Result<State<2>, Box<dyn Error>> {
            let velocity = Field::interpolate(space, |_| [-1.0, 0.0])?;
            Ok(State { rate: velocity, ..State::at_rest(0.0, Field::zero(space)) })
        };
        let contact = |step: &Step<2>| {
            let data = impact::data_from(step).lambda(0.0).mu(0.5).gamma0(40.0);
            let data = data.obstacle_normal([-1.0, 0.0]).gap(0.01).theta(0.0).rho(1.0);
            impact::Model { data, regions: impact::Regions::default().gamma_c("left") }.motion()
        };
        let (motion, size) = match self {
            Motion::Impact => (TimeLoop::new(contact, GeneralisedAlpha::trapezoidal(), moving()?), 0.02),
            Motion::Explicit => (TimeLoop::new(contact, CentralDifferences, moving()?), 0.005),
            Motion::Lumped => {
                let motion = TimeLoop::new(contact, CentralDifferences, moving()?).mass(Mass::Lumped);
                (motion.constant_coefficients(), 0.005)
            }
            Motion::Porous => {
                let form = |steps: &[Step<2>; 2]| {
                    porous::Model::new(porous::data_from(steps).mu(1.0).permeability(0.1)).balance()
                };
                let start = [space, conditions[1].space()];
                let start = start.map(|space| State::at_rest(0.0, Field::zero(space)));
                (TimeLoop::coupled(form, OneStepTheta::implicit_euler(), start), 0.05)
            }
        };
        let assembler = Assembler::new(space.mesh()).with_threads(Threads::new(1));
        let motion = motion.assembler(&assembler);
        Ok((conditions.iter().fold(motion, TimeLoop::constrained), size))
    }
}
