//! Meshes, the elements on them, quadrature and point location; files.
//!
//! [`mesh`] holds meshes with named regions, from generators, from files, by refinement; [`element`] the reference cells and the
//! Lagrange elements on them, [`quadrature`] their rules; [`locate`] finds the cell of a point, [`files`] writes a file whole or not at all. `forms-fem` re-exports these modules.

pub mod disjoint_sets;
pub mod element;
mod facet;
pub mod files;
mod instantiate;
pub mod locate;
pub mod mesh;
pub mod quadrature;

#[doc(hidden)]
pub use instantiate::Compiled;
