//! Discrete problems of compiled weak forms: from a mesh to the solution and its files.
//!
//! The way of a computation: [`mesh`] → [`element`] → [`quadrature`] → [`space`] → [`assemble`] → [`solve`] → [`output`].
//! Users depend on `forms-fem`, which has all of this, and time, inverse problems and the optimisation of shapes above it;
//! it is a crate of its own because the paper's experiment needs no more. It holds its instances in the plane,
//! `forms-fem` those in space.

extern crate self as forms_fem;

pub mod assemble;
pub mod bounds;
#[doc(hidden)]
pub mod coincident;
pub mod constraints;
pub mod contract;
pub mod cut;
pub mod dimension;
pub mod field;
pub mod history;
#[doc(hidden)]
pub mod instantiate;
pub mod lanes;
pub mod language;
pub mod movement;
pub mod norms;
pub mod output;
pub mod pairs;
pub mod prelude;
pub mod solve;
pub mod space;

pub use forms_core::{form, forms};
#[doc(inline)]
pub use forms_linear_algebra as linear_algebra;
#[doc(inline)]
pub use forms_linear_algebra::threads;
#[doc(inline)]
pub use forms_mesh::{element, locate, mesh, quadrature};
