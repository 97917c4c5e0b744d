//! Adaptivity: solve, estimate the error, mark, refine, and again, until the estimate is within a tolerance.
//!
//! [`Adaptation`] is the cycle, also on bodies that are cut from the mesh; [`InterfaceBand`] has small cells around their interface. Estimators are forms of the user's. A residual estimator is a linear form with a test function that is constant on cells,
//! whose values are the squares of the indicators ([`ErrorEstimate::residual`]). The error of a goal J comes from an adjoint
//! state ([`ErrorEstimate::dual_weighted`]; Becker and Rannacher 2001), for any form `direct` and criterion:
//!
//! ```
//! use forms_fem::adaptivity::ErrorEstimate;
//! use forms_fem::prelude::*;
//!
//! #[forms]
//! mod heat {
//!     #[cells]
//!     pub struct Omega;
//!     pub fn direct(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
//!         integral(Omega, dot(grad(u), grad(v)) - v)
//!     }
//!     pub fn total(u: State<Scalar>) -> Functional {
//!         integral(Omega, u)
//!     }
//!     pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
//!         derivative(direct(u, p), u, q) + derivative(total(u), u, q)
//!     }
//!     /// R(u; q z), the residual weighted with z, part by part of a partition of unity.
//!     pub fn localised(u: State<Scalar>, z: State<Scalar>, q: Test<Scalar>) -> Form {
//!         direct(u, q * z)
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Triangle, 1)?;
//! let (space, higher) = (Space::scalar(&mesh, 1)?, Space::scalar(&mesh, 2)?);
//! let held = |space| -> Result<Constraints<2>, Box<dyn std::error::Error>> {
//!     let mut constraints = Constraints::new(space);
//!     constraints.fix("boundary", |_| 0.0)?;
//!     Ok(constraints)
//! };
//! let model = heat::Model::default();
//! let solved = Problem::new(&model.direct(), &space).constrained(&held(&space)?).solve()?;
//! let u = solved.field();
//! let p = Problem::new(&model.adjoint(u), &higher).homogeneous(&held(&higher)?).solve()?.into_field();
//!
//! let estimate = ErrorEstimate::dual_weighted(&Assembler::new(&mesh), &p, &space, |z| model.localised(u, z))?;
//! // The mean over the unit square is 0.0351442537 (series).
//! let error = 0.0351442537 - solved.functional(&model.total(u))?;
//! assert!((estimate.value() / error - 1.0).abs() < 0.02);
//! # Ok(())
//! # }
//! ```

mod adaptation;
mod estimate;
mod interface_band;

pub use adaptation::{Adaptation, AdaptationError, Adapted, AdaptiveSolution, AdaptiveStep};
pub use estimate::{ErrorEstimate, EstimateError};
pub use interface_band::{InterfaceBand, InterfaceBandError};
