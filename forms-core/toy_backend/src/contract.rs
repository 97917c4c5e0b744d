//! The contract, with the values of this backend: what emitted code names.

pub use forms_core::contract::*;
use forms_core::function;

use crate::kernels::Dense;

/// A form.
pub type Form<const D: usize> = function::Form<D, Dense>;
/// An energy.
pub type Energy<const D: usize> = function::Energy<D, Dense>;
/// A functional.
pub type Functional<const D: usize> = function::Functional<D, Dense>;
/// An expression.
pub type Expression<const D: usize> = function::Expression<D, Dense>;
