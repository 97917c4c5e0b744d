//! The contract between compiled weak forms and any finite element backend.
//!
//! `#[forms]` (from `forms-macro`, re-exported here) turns weak forms into kernels: small straight-line
//! functions that know physics and no mesh. A backend owns meshes, elements, quadrature, loops and
//! scatter, and knows no physics. What the two share is only in [`contract`]; the
//! toy backend next to this package shows that nothing more is needed.
//!
//! Reading order: [`lane`] (the number type), [`kernel`] (what is called at a point), [`mod@form`] (what a form says of itself),
//! [`function`] (forms as values), [`degree`] (of an integrand), [`dimension`] (one bound for all forms), [`source`] (where data come from). Functions written in Rust compute with
//! [`real`] and [`dual`] numbers, are called through [`external`], and may use [`spectral`] ones; a [`table`]
//! is a law given by points, and [`history`] what a material remembers. [`pairing`] says which surfaces of a region of contact pairs meet.

pub mod adaptation;
pub mod contract;
pub mod degree;
pub mod described;
pub mod dimension;
pub mod dual;
mod error_function;
pub mod external;
pub mod form;
pub mod function;
pub mod history;
pub mod integrals;
pub mod kernel;
pub mod kernel_constants;
pub mod lane;
pub mod pairing;
pub mod real;
pub mod source;
pub mod spectral;
pub mod table;

pub use forms_macro::{form, forms};
