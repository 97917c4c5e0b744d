//! Compiled problems for other languages: functions of plain arrays with products of Jacobian and vector, for C and Python.
//!
//! A constructor makes a [`DifferentiableMap`](forms_fem::inverse::DifferentiableMap) of [`Parameters`]; a line exports it:
//!
//! ```ignore
//! forms_bindings::export_c!(level, crate::level);                        // level_open, level_value, level_vjp, …
//! forms_bindings::export_python!(beam_on_ground: level, deflection);     // a Python module with two problems
//! ```
//!
//! ```text
//! Parameters     named numbers from outside
//! ProblemThread  the thread in which a problem lives; calls from any thread, one after the other
//! c_interface    functions with C's calling convention, and `export_c!`; C's side is include/forms.h
//! python         the class `Problem`, and `export_python!` (feature `python`)
//! ```

pub mod c_interface;
pub mod parameters;
pub mod problem_thread;
#[cfg(feature = "python")]
pub mod python;

pub use parameters::{ParameterError, Parameters};
pub use problem_thread::{Failure, ProblemThread};
#[cfg(feature = "python")]
#[doc(hidden)]
pub use pyo3;
