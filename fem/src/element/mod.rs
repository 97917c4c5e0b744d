//! Reference cells and the Lagrange elements on them.

pub mod lagrange;
pub mod shape;

pub use lagrange::{ElementError, Lagrange, MAXIMUM_NODES, Tables};
pub use shape::CellShape;
