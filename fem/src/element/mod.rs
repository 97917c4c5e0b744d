//! Reference cells and the Lagrange elements on them.

pub mod lagrange;
pub mod shape;

pub use lagrange::{Lagrange, Tables};
pub use shape::CellShape;
