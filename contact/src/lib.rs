//! Frictionless contact by Nitsche's method, after Bretin, Chapelat, Douanla-Lontsi, Homolle and Renard
//! (2023): the direct problem, its adjoint states and criteria as declared forms, and the drivers that
//! solve them.
//!
//! [`operators`] are there to be imported into forms; [`nitsche`] holds the paper's equations. A [`ContactProblem`] solves direct → adjoint on any mesh, for any
//! [`law`]; [`paper_law`] is the paper's with its three adjoint states;
//! [`shape_gradient`] differentiates the criterion by the shape, as the volume form of the discrete problem; [`boundary_form`] is the paper's form on the boundary; [`hollow_cylinder`] is the paper's experiment; [`hertz`] holds contacts with closed forms; [`shape_problem`] hands contact to a descent of shapes, with the criteria of [`load_and_pressure`], too; [`threshold`] says when γ₀ is too small.
//! Nothing here knows an element or loops over cells.

pub mod boundary_form;
pub mod contact_problem;
pub mod hertz;
pub mod hollow_cylinder;
pub mod law;
pub mod load_and_pressure;
pub mod nitsche;
pub mod operators;
pub mod paper_law;
pub mod shape_gradient;
pub mod shape_problem;
pub mod threshold;

pub use contact_problem::ContactProblem;
pub use nitsche::nitsche as forms;
pub use paper_law::Adjoint;

/// Paths for [`contact_law!`].
#[doc(hidden)]
pub use forms_fem::prelude as fem;
