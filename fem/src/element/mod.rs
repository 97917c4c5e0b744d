//! Reference cells and the Lagrange elements on them.

mod in_lanes;
pub mod lagrange;
mod lattice;
pub mod shape;

pub(crate) use in_lanes::{LaneBasis, LaneElement};
pub use lagrange::{ElementError, Lagrange, MAXIMUM_DEGREE, MAXIMUM_GEOMETRY_NODES, MAXIMUM_NODES, Tables};
pub(crate) use lattice::{inside_quadrilateral, inside_triangle};
pub use shape::CellShape;
pub(crate) use shape::plurals;
