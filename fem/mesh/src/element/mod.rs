//! Reference cells and the Lagrange elements on them.

pub mod lagrange;
mod lattice;
mod per_shape;
pub mod shape;

pub use lagrange::{ElementError, Lagrange, MAXIMUM_DEGREE, MAXIMUM_GEOMETRY_NODES, MAXIMUM_NODES, Tables};
#[doc(hidden)]
pub use lattice::{inside_quadrilateral, inside_triangle, lattice};
pub use per_shape::PerShape;
pub use shape::CellShape;
pub(crate) use shape::plurals;
