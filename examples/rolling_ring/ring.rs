//! The ring: its material, its start, and what is measured of a state.

use std::error::Error;

use forms_contact::finite_impact::finite_impact;
use forms_fem::prelude::*;
use forms_fem::time::{State, Step, operators};

/// Radii, λ and μ, density, weight per mass, κ.
pub const INSIDE: f64 = 0.5;
pub const OUTSIDE: f64 = 1.0;
pub const LAMBDA: f64 = 4.0;
pub const MU: f64 = 1.0;
pub const DENSITY: f64 = 1.0;
pub const GRAVITY: f64 = 0.02;
pub const FRICTION: f64 = 0.5;
/// The speed along the flat, and the height of the fall.
pub const SPEED: f64 = 0.3;
pub const FALL: f64 = 0.2;
/// γ₀: quadratic cells need some 30 (λ + 2μ), or E₁ has no lower bound and the motion explodes in flight.
pub const GAMMA: f64 = 400.0 * MU;
/// Of the quadrature.
const DEGREE: usize = 4;

/// The scheme of a run.
#[derive(Clone, Copy, PartialEq)]
pub enum Pressure {
    Conserving,
    Hybrid,
}

/// The numbers of a step that are written.
#[derive(Clone, Copy)]
pub struct Record {
    pub time: f64,
    pub energy: f64,
    pub kinetic: f64,
    /// Work of friction so far.
    pub lost: f64,
    /// Momentum along the flat and normal to it.
    pub momentum: [f64; 2],
    /// The flat's mean force in the step.
    pub force: [f64; 2],
    /// The centre's place along the flat, its height, and the angular velocity by the moment of inertia.
    pub along: f64,
    pub height: f64,
    pub spin: f64,
    /// Newton's steps, and those of them that were shortened.
    pub iterations: usize,
    pub shortened: usize,
}

/// The body, its start, and what is measured of it.
pub struct Thrown {
    pub space: Arc<Space<2>>,
    pub assembler: Assembler<2>,
    pub mass: f64,
}

impl Thrown {
    pub fn new(around: usize) -> Result<Self, Box<dyn Error>> {
        let mesh = annulus(INSIDE, OUTSIDE, (around / 12).max(1), around, CellShape::Quadrilateral, 2)?;
        let space = Space::vector(&mesh, 2)?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(DEGREE));
        let one = Field::interpolate(&space, |_| [1.0, 0.0])?;
        let mass = assembler.functional(&model(None, [1.0, 0.0], [0.0; 2]).momentum(&one))?;
        Ok(Thrown { space, assembler, mass })
    }

    pub fn start(&self) -> Result<State<2>, Box<dyn Error>> {
        let velocity = Field::interpolate(&self.space, |_| [SPEED, 0.0])?;
        Ok(State::new(0.0, Field::zero(&self.space), velocity)?)
    }

    pub fn measured(
        &self,
        before: Option<(&State<2>, &Record, Pressure)>,
        after: &State<2>,
    ) -> Result<Record, Box<dyn Error>> {
        let (u, velocity) = (&after.value, &after.rate);
        let axes = [[1.0, 0.0], [0.0, 1.0]];
        let along = |axis: [f64; 2]| model(None, axis, [0.0; 2]);
        let total = |axis: [f64; 2], w: &Field<2>| self.assembler.functional(&along(axis).momentum(w));
        let momentum = [total(axes[0], velocity)?, total(axes[1], velocity)?];
        let way = [total(axes[0], u)? / self.mass, total(axes[1], u)? / self.mass];
        let about = model(None, axes[0], way);
        let spin = self.assembler.functional(&about.spin(u, velocity))?
            / self.assembler.functional(&about.inertia(u))?;
        let mut record = Record {
            time: after.time,
            energy: self.assembler.functional(&along(axes[0]).energy(u, velocity))?,
            kinetic: kinetic(&self.assembler, velocity)?,
            lost: 0.0,
            momentum,
            force: [0.0; 2],
            along: way[0],
            height: OUTSIDE + FALL + way[1],
            spin,
            iterations: 0,
            shortened: 0,
        };
        if let Some((before, earlier, pressure)) = before {
            let start = &before.value;
            for (force, axis) in record.force.iter_mut().zip(axes) {
                *force = match pressure {
                    Pressure::Conserving => {
                        self.assembler.functional(&along(axis).conserving_force(u, start))?
                    }
                    Pressure::Hybrid => self.assembler.functional(&along(axis).hybrid_force(u, start))?,
                };
            }
            record.lost = earlier.lost
                + match pressure {
                    Pressure::Conserving => {
                        self.assembler.functional(&along(axes[0]).conserving_loss(u, start))?
                    }
                    Pressure::Hybrid => self.assembler.functional(&along(axes[0]).hybrid_loss(u, start))?,
                };
        }
        Ok(record)
    }
}

fn kinetic(assembler: &Assembler<2>, velocity: &Field<2>) -> Result<f64, Box<dyn Error>> {
    let zero = Field::zero(velocity.space());
    let energy = model(None, [0.0; 2], [0.0; 2]);
    Ok(assembler.functional(&energy.energy(&zero, velocity))?
        - assembler.functional(&energy.energy(&zero, &zero))?)
}

/// The forms in a step, or of a state alone.
pub fn model(step: Option<&Step<2>>, direction: [f64; 2], centre: [f64; 2]) -> finite_impact::Model<2> {
    let evaluated: operators::vector::Data<2> = step.map(Into::into).unwrap_or_default();
    let body = finite_impact::data_from(evaluated)
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(GAMMA)
        .rho(DENSITY)
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1] + OUTSIDE + FALL);
    let data =
        body.friction(FRICTION).body_force([0.0, -DENSITY * GRAVITY]).direction(direction).centre(centre);
    finite_impact::Model { data, regions: finite_impact::Regions::default().gamma_c("outer") }
}
