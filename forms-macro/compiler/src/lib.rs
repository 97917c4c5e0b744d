//! Compiles a module of weak forms, written as Rust functions, to assembly kernels.
//!
//! The stages, each a module: `parse` → `check` → `differentiate` → `optimise` → `emit`;
//! `compile` drives them, and `calls` are the ways in. No stage knows a mesh or an element.

extern crate proc_macro;

mod calls;
mod check;
mod compile;
mod diagnostics;
mod differentiate;
mod dump;
mod emit;
mod one_form;
mod optimise;
mod options;
mod parse;
#[cfg(test)]
mod proof;
#[cfg(test)]
mod reference;
mod reuse;
mod rustc_arguments;
mod show;
mod sorted;
mod tensor;

pub use calls::{dump, form, forms, mathml, resume_forms};
