//! The language of weak forms, operator by operator. Nothing but documentation stands here; every example is run.
//!
//! A module under [`macro@crate::forms`] holds weak forms. It is Rust as far as syntax goes, so rustfmt formats it and an editor
//! highlights it; the compiler behind the attribute gives its functions their meaning.
//!
//! ```text
//! #[forms]
//! pub mod name {
//!     pub struct Data { .. }                 parameters and known data
//!     #[cells]  pub struct Omega;            regions of integration
//!     fn sigma(u: Vector) -> Tensor { .. }   functions that forms call, and derived fields
//!     pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form { .. }
//! }
//! ```
//!
//! - [`calculus`]: derivatives in space
//! - [`geometry`]: position, normal, sizes, curvature
//! - [`kinks`]: functions with kinks and their conventions
//! - [`derivatives`]: Gateaux and partial derivatives, energies

pub mod calculus;
pub mod derivatives;
pub mod geometry;
pub mod kinks;
