//! The contract between compiled forms and this backend: that of `forms-core`, with forms as values of this backend.

pub use forms_core::contract::*;
use forms_core::function;

use crate::assemble::Lanes;

/// A residual R(u; v), linear in its test functions, and its tangent ∂R/∂u by the compiler. Cheap to clone.
pub type Form<const D: usize> = function::Form<D, Lanes>;
/// An energy W(u): a number, and the form of its first variation, which it can be used as.
pub type Energy<const D: usize> = function::Energy<D, Lanes>;
/// A number: the integral of a density without test function.
pub type Functional<const D: usize> = function::Functional<D, Lanes>;
/// A derived field: a function of a forms module, evaluated where the user asks.
pub type Expression<const D: usize> = function::Expression<D, Lanes>;
/// Compiled function of any kind: the common part of forms, energies, functionals and expressions.
pub type Function<const D: usize> = function::Function<D, Lanes>;
