//! Common parts of the whole-system tests: the reader of the reference files, small distorted bodies, the
//! contact forms evaluated by plain loops, the check of adjoint forms.

pub mod adjoint_form;
pub mod bodies;
pub mod contact_by_loops;
pub mod dense;
pub mod reference_file;

/// The pages of translations, whose blocks in our notation are compiled here (`cargo test --doc`).
#[doc = include_str!("../../docs/coming_from.md")]
#[doc = include_str!("../coming_from/forms.md")]
pub mod coming_from {}
