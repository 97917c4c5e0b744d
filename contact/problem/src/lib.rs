//! Contact problems, after Bretin, Chapelat, Douanla-Lontsi, Homolle and Renard (2023): the operators that contact laws are
//! written in, what a law is, the drivers that solve it with its adjoint states, Nitsche's method with and without friction, and
//! the paper's experiment. Users depend on `forms-contact`, which has all of this and further laws; it is a crate of its own
//! because the paper's experiment needs no more.
//!
//! | module | what | equations |
//! | --- | --- | --- |
//! | [`nitsche`] | the paper's forms | (14), (21), (22), (41) |
//! | [`operators`] | stresses, gap, γ, Nitsche's terms, to be imported into forms | (15) |
//! | [`contact_problem`] | a law on a space, and its drivers: direct → adjoint | |
//! | [`law`] | what the drivers ask of a law; [`contact_law!`] makes one of your own module | |
//! | [`mod@parameter_ranges`] | which parameters of a law have to be positive, or not negative | |
//! | [`paper_law`] | the paper's law with its three adjoint states | |
//! | [`frictional_nitsche`] | Nitsche's method with Tresca's and Coulomb's friction | |
//! | [`theta_path`] | the way to a solution through other values of θ | |
//! | [`shape_gradient`] | the derivative by the shape, as the volume form of the discrete problem | |
//! | [`threshold`] | when γ₀ is too small | |
//! | [`hollow_cylinder`] | the paper's experiment | |
//!
//! Nothing here knows an element or loops over cells.

pub mod contact_problem;
pub mod frictional_nitsche;
mod from_stick;
pub mod hollow_cylinder;
pub mod law;
pub mod nitsche;
pub mod operators;
pub mod paper_law;
pub mod parameter_ranges;
pub mod shape_gradient;
pub mod theta_path;
pub mod threshold;

pub use contact_problem::ContactProblem;
pub use from_stick::FromStick;
pub use nitsche as forms;
pub use paper_law::Adjoint;

/// Paths for [`contact_law!`].
#[doc(hidden)]
pub use forms_fem::prelude as fem;
