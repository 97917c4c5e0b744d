//! A second, independent meaning of a checked form: its value at a point by walking the tree of tensors.
//!
//! Input: [`CheckedFunction`](crate::check::CheckedFunction) and the data of a [`Point`]; output: numbers.
//! Nothing here imports a later stage. Derivatives are taken by dual numbers, so that no rule of
//! differentiation is shared with `differentiate`.

mod budget;
mod environment;
mod evaluator;
mod functions;
mod jets;
mod matrices;
mod moving_points;
mod number;
mod point;

pub use budget::Budget;
pub use evaluator::{Condition, Evaluator};
pub use functions::error_function;
pub use point::{Jet, MEAN, ORDERS, Point};

mod tests;
