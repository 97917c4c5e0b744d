//! A generic finite element backend for compiled weak forms.
//!
//! The way of a computation: [`mesh`] → [`element`] → [`quadrature`] → [`space`] → [`assemble`] →
//! [`solve`] → [`output`]. Nothing here knows any physics; forms bring it through
//! [`contract`].

extern crate self as forms_fem;

pub mod assemble;
pub mod constraints;
pub mod element;
pub mod field;
pub mod linear_algebra;
pub mod locate;
pub mod mesh;
pub mod output;
pub mod quadrature;
pub mod solve;
pub mod space;

pub use forms_core::contract;
pub use forms_core::forms;
