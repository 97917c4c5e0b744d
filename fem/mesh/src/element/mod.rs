//! Reference cells and the elements on them.

mod any;
mod families;
pub mod lagrange;
mod lattice;
mod layout;
mod per_shape;
mod points;
mod polynomial;
pub mod shape;
mod table;

pub use any::Element;
pub use families::Elements;
pub use lagrange::{ElementError, Lagrange, MAXIMUM_GEOMETRY_NODES, MAXIMUM_NODES, Tables};
pub use lattice::MAXIMUM_DEGREE;
#[doc(hidden)]
pub use lattice::{inside_quadrilateral, inside_triangle, lattice};
pub use per_shape::PerShape;
#[doc(hidden)]
pub use points::RulePoints;
pub use shape::CellShape;
pub(crate) use shape::plurals;
pub use table::Table;
