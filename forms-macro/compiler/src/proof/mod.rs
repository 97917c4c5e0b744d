//! Proof by example that the emitted code computes what the form says: the kernels as they are emitted, run
//! by an interpreter, against the reference evaluator, at random data.

mod assembly;
mod comparison;
mod data;
mod effort;
mod emitted;
mod emitted_code;
mod generator;
mod growth;
mod interpreter;
mod random_forms;
mod real_forms;
pub mod source;
