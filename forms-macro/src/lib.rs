//! `#[forms]`: compiles a module of weak forms, written as Rust functions, to assembly kernels.
//!
//! The stages, each a module: `parse` → `check` → `differentiate` → `optimise` → `emit`;
//! `compile` drives them. No stage knows a mesh or an element.

mod check;
mod compile;
mod diagnostics;
mod differentiate;
mod emit;
mod optimise;
mod parse;
mod tensor;

use proc_macro::TokenStream;

/// Compiles a module of weak forms. See the crate `forms-fem` for the language.
#[proc_macro_attribute]
pub fn forms(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let options = match syn::parse::<compile::Options>(attribute) {
        Ok(options) => options,
        Err(error) => return error.into_compile_error().into(),
    };
    match syn::parse::<syn::ItemMod>(item) {
        Ok(item) => compile::compile(&options, item).into(),
        Err(error) => error.into_compile_error().into(),
    }
}
