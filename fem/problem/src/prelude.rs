//! The usual imports of a program that states and solves forms.

pub use std::sync::Arc;

pub use crate::assemble::{Assembler, AssemblyError, Parts, TangentAction};
pub use crate::bounds::Bounds;
pub use crate::constraints::Constraints;
pub use crate::contract::{
    Energy, Entity, Expression, Form, Functional, Given, History, Pairing, Real, Table,
};
pub use crate::cut::Cut;
pub use crate::dimension::{Dim, Dimension};
pub use crate::element::CellShape;
pub use crate::element::Elements;
pub use crate::field::Field;
pub use crate::mesh::{Facet, Mesh, annulus, ball, cuboid, disc, half_disc, hollow_cylinder, rectangle};
pub use crate::norms;
pub use crate::output::Failure;
pub use crate::quadrature::{Quadrature, QuadratureRule};
pub use crate::solve::{
    CondensedSolver, Continuation, Deflation, Eigenproblem, Increment, LineSearch, LinearProblems,
    LinearSolver, LoadSteps, LuSolver, MultigridSolver, MultigridSolverOptions, NewtonError, NewtonOptions,
    NewtonStep, PrescribedValues, Problem, SolveError, Solved, TangentSolver, TangentSolverOptions,
};
pub use crate::space::{Scope, Space};
pub use crate::threads::Threads;
pub use crate::{form, forms};
