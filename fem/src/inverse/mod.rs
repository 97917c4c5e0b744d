//! Inverse problems: controls, criteria over histories of steps, their gradients by discrete adjoints, and minimisation.
//!
//! ```text
//! Controls        named numbers and fields that the data of a form are made of
//! LoadHistory     steps Rⁿ(uⁿ, uⁿ⁻¹, m; v) = 0 of one form with a criterion J = Σ Jⁿ(uⁿ): J(m) and its gradient
//! MotionHistory   steps in time of one form by a scheme, the same
//! Evolution       what a history has to say of its steps; sweep.rs goes forward and back, with checkpointing
//! ReducedProblem  J(m) with its gradient: Taylor tests, `minimise` with bounds, `moving_asymptotes` under constraints
//! TwiceDifferentiable  with its Hessian along a direction, and Taylor tests of both orders
//! DifferentiableMap  controls to outputs over plain arrays, with products of Jacobian and vector: a criterion (`CriterionMap`), or
//!                 readings of states (`ReadingsMap`); what other languages call
//! ```
//!
//! A history's gradient is that of the discrete problem: backwards over the steps R_uᵀ pⁿ = −Jⁿ_u − (∂Rⁿ⁺¹/∂uⁿ)ᵀ pⁿ⁺¹, and dJ/dm is
//! the sum of (∂Rⁿ/∂m)ᵀ pⁿ. Both derivatives of R come from `derivative` in the user's module:
//!
//! ```
//! use forms_fem::inverse::{Controls, LoadHistory, ReducedProblem};
//! use forms_fem::prelude::*;
//!
//! #[forms(dimension = 2)]
//! mod creep {
//!     pub struct Data {
//!         pub conductivity: Param,
//!         pub source: Param,
//!     }
//!     #[cells]
//!     pub struct Omega;
//!
//!     /// Each step goes on from the one before. The attribute writes `step_sensitivities`, the derivatives of a step's work by the state
//!     /// before and by each control.
//!     #[controls(conductivity)]
//!     pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
//!         integral(Omega, (u - before) * v + conductivity * (1 + sqr(u)) * dot(grad(u), grad(v)) - source * v)
//!     }
//!     /// What is summed over the steps.
//!     pub fn misfit(u: Unknown<Scalar>) -> Energy {
//!         integral(Omega, sqr(u - x[0]) / 2)
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?;
//! let space = Space::scalar(&mesh, 1)?;
//! let mut held = Constraints::new(&space);
//! held.fix("left", |_| 0.0)?;
//! let controls = Controls::new().number("conductivity", 0.3);
//! let model = |conductivity| creep::Model::new(creep::data().conductivity(conductivity).source(1.0));
//! let mut history = LoadHistory::new(&space, 10, controls)
//!     .step(|at| Ok(model(at.number("conductivity")?).step(at.before()?)))
//!     .sensitivities(|at, u, p| Ok(model(at.number("conductivity")?).step_sensitivities(u, at.before()?, p)))
//!     .criterion(|at| Ok(model(at.number("conductivity")?).misfit()))
//!     .constrained(&held);
//! let (value, gradient) = history.value_and_gradient(&[0.3])?;
//! # let (above, below) = (history.value(&[0.3001])?, history.value(&[0.2999])?);
//! # assert!(((above - below) / 2e-4 - gradient[0]).abs() < 1e-6 * gradient[0].abs() && value > 0.0);
//! # Ok(())
//! # }
//! ```

pub mod bounds;
mod checkpoint_store;
mod choices;
mod control_vectors;
pub mod controls;
mod criterion;
pub mod criterion_map;
pub mod differentiable_map;
mod error;
pub mod evolution;
pub mod load_history;
pub mod minimise;
pub mod motion_history;
pub mod moving_asymptotes;
pub mod observations;
mod quasi_newton;
pub mod readings;
pub mod readings_map;
pub mod reduced_problem;
pub mod second_order;
mod sensitivities;
mod step_context;
mod step_equations;
mod step_map;
pub mod step_sizes;
mod steps_unknown;
mod sweep;
mod tangent_state;

pub use bounds::{Bounds, BoundsMismatch};
pub use control_vectors::ControlVectors;
pub use controls::{ControlError, ControlValues, Controls};
pub use criterion_map::CriterionMap;
pub use differentiable_map::{DifferentiableMap, MapError, Part};
pub use error::{HistoryError, HistoryFailure};
pub use evolution::{ControlledEvolution, Evolution};
pub use load_history::{LoadHistory, SecondOrderState, SecondOrderStates};
pub use minimise::{MinimisationError, MinimisationStep, Minimise, Minimum, StopReason};
pub use motion_history::{MotionHistory, SecondOrderMotion, SecondOrderMotions};
pub use moving_asymptotes::{
    ConstrainedError, ConstrainedMinimum, ConstrainedStep, Inequality, MovingAsymptotes,
};
pub use observations::Observations;
pub use readings::Readings;
pub use readings_map::ReadingsMap;
pub use reduced_problem::{ReducedProblem, taylor_test};
pub use second_order::{Hessian, SecondOrder, TwiceDifferentiable, second_order_taylor_test};
pub use step_context::StepContext;
pub use step_sizes::StepSizes;
pub use sweep::{Gradient, SweepFailure, Work, gradient_of, gradient_on_disk, largest_repetition, value_of};
