//! Steps in time: forms of motion, schemes, and the loop over them.
//!
//! A form of motion is written with the operators of [`operators`], which give displacement, velocity and acceleration (or value
//! and rates) where a [`Scheme`] evaluates them; a [`TimeLoop`] takes the steps.
//!
//! ```
//! use forms_fem::prelude::*;
//! use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};
//!
//! #[forms(dimension = 2)]
//! mod bar {
//!     use forms_fem::time::operators::vector::{acceleration, displacement};
//!
//!     #[includes(forms_fem::time::operators::vector::Data)]
//!     pub struct Data {
//!         pub rho: Param,
//!         pub mu: Param,
//!     }
//!     #[cells]
//!     pub struct Omega;
//!
//!     pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
//!         integral(Omega, rho * dot(acceleration(u), v) + 2 * mu * inner(eps(displacement(u)), eps(v)))
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0; 2], [1.0, 0.1], [20, 1], CellShape::Quadrilateral, 1)?;
//! let space = Space::vector(&mesh, 1)?;
//! let mut held = Constraints::new(&space);
//! held.fix("left", |_| [0.0; 2])?;
//! let pulled = Field::interpolate(&space, |x| [0.01 * x[0], 0.0])?;
//!
//! let form = |step: &Step<2>| {
//!     bar::Model::new(bar::data_from(step).rho(1.0).mu(0.5)).motion()
//! };
//! let start = State::new(0.0, pulled, Field::zero(&space))?;
//! let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start).constrained(&held);
//! for _ in 0..40 {
//!     motion.take(0.025)?;
//! }
//! println!("{:?}", motion.state().value.evaluate(&[1.0, 0.05])?);
//! # Ok(())
//! # }
//! ```

pub mod adaptive_steps;
pub mod backward_differences;
pub mod central_differences;
pub mod checkpoint;
pub(crate) mod conditions;
mod error;
pub mod events;
pub mod generalised_alpha;
mod linear_step;
pub mod mass;
pub mod one_step_theta;
pub mod operators;
pub mod redistributed_mass;
pub mod scheme;
pub mod step;
pub mod step_cost;
pub mod time_loop;

pub use adaptive_steps::AdaptiveSteps;
pub use backward_differences::BackwardDifferences;
pub use central_differences::CentralDifferences;
pub use checkpoint::{Checkpoint, CheckpointError};
pub use error::{StepError, StepFailure};
pub use events::{Event, EventFunction, Events, NumberError};
pub use generalised_alpha::GeneralisedAlpha;
pub use mass::Mass;
pub use one_step_theta::OneStepTheta;
pub use redistributed_mass::{RedistributionError, redistributed_mass};
pub use scheme::{Combination, Formulas, Scheme, SchemeError, SolvedFor};
pub use step::{State, Step, Taken};
pub use step_cost::StepCost;
pub use time_loop::TimeLoop;
