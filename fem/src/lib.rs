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
pub mod norms;
pub mod output;
pub mod quadrature;
pub mod solve;
pub mod space;

pub use forms_core::contract;
pub use forms_core::forms;

/// What a program that states and solves forms needs.
pub mod prelude {
    pub use std::sync::Arc;

    pub use crate::assemble::{Assembler, AssemblyError, Parts};
    pub use crate::constraints::Constraints;
    pub use crate::contract::{Entity, Expression, Form, Functional, Given};
    pub use crate::element::CellShape;
    pub use crate::field::Field;
    pub use crate::forms;
    pub use crate::mesh::{Facet, Mesh, annulus, cuboid, rectangle};
    pub use crate::norms;
    pub use crate::quadrature::{Quadrature, QuadratureRule};
    pub use crate::solve::{
        CondensedSolver, FormProblem, LinearSolver, NewtonError, NewtonOptions, NewtonStep, TangentSolver,
        TangentSolverOptions,
    };
    pub use crate::space::Space;
}
