//! The language of weak forms, operator by operator. This module has only documentation; every example is run.
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
//! | page | what it has |
//! | --- | --- |
//! | [`products`] | `* / dot ddot inner outer cross perp` |
//! | [`tensors`] | shapes, parts and functions of tensors, components, slices, arrays |
//! | [`functions`] | scalar functions, powers, `let`, `if` |
//! | [`kinks`] | `heaviside sign abs pos_part neg_part min max norm`, and their conventions |
//! | [`calculus`] | `grad div eps curl hess mean means` |
//! | [`geometry`] | position, normal, sizes, curvature |
//! | [`facets`] | interior facets: `this other jump avg` |
//! | [`derivatives`] | `derivative`, `diff`, energies |
//! | [`laws`] | functions written in Rust, tables, history |
//! | [`reuse`] | `use` among modules and crates, `form!` |
//! | [`operators`] | each name as an item of its own, for search |

pub mod calculus;
pub mod derivatives;
pub mod facets;
pub mod functions;
pub mod geometry;
pub mod kinks;
pub mod laws;
pub mod operators;
pub mod products;
pub mod reuse;
pub mod tensors;
