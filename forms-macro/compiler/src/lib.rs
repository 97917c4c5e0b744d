//! Compiles a module of weak forms, written as Rust functions, to assembly kernels.
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
mod show;
mod tensor;

use proc_macro2::TokenStream;

/// What `#[forms(attribute)] item` becomes: kernels, or compiler errors on the tokens of the mistakes.
pub fn forms(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let options = match syn::parse2::<compile::Options>(attribute) {
        Ok(options) => options,
        Err(error) => return error.into_compile_error(),
    };
    match syn::parse2::<syn::ItemMod>(item) {
        Ok(item) => compile::compile(&options, item),
        Err(error) => error.into_compile_error(),
    }
}
