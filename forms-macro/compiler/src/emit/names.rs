//! Names and lints of what is emitted.

use proc_macro2::{Ident, Span, TokenStream};
use quote::quote;
use syn::ext::IdentExt;

use crate::parse::syntax::*;

/// Lints that emitted modules are free of.
pub fn allow() -> TokenStream {
    quote! {
        #[allow(missing_docs, dead_code, unused_variables, non_snake_case, non_camel_case_types, uncommon_codepoints, mixed_script_confusables)]
        #[allow(clippy::all)]
    }
}

/// `GammaC` → `gamma_c`: as members are called, and facets in a mesh unless another name is given.
pub fn snake_case(name: &Ident) -> String {
    let mut text = String::new();
    for character in name.unraw().to_string().chars() {
        if character.is_uppercase() && !text.is_empty() && !text.ends_with('_') {
            text.push('_');
        }
        text.extend(character.to_lowercase());
    }
    text
}

/// The arguments that a constructor takes: known fields.
pub fn stored_arguments(function: &Function) -> impl Iterator<Item = &Argument> {
    function
        .arguments
        .iter()
        .filter(|argument| matches!(argument.role, ArgumentRole::State | ArgumentRole::Plain))
}

/// The constructor's name for a known field: the argument's, unless Rust reads that as a pattern (`None`, or a region,
/// which has been reported).
pub fn stored_argument(module: &Module, name: &Ident) -> Ident {
    let mut patterns = module.regions.iter().map(|region| region.name.to_string());
    let variant = ["Some", "None", "Ok", "Err"].iter().any(|variant| name == variant);
    match variant || patterns.any(|region| name == &region) {
        true => own(&format!("{name}_")),
        false => name.clone(),
    }
}

/// A name of the constructor's own, which an argument of the form cannot hide.
pub fn own(name: &str) -> Ident {
    Ident::new(name, Span::mixed_site())
}

/// Whether a function has an unknown to be differentiated by.
pub fn has_tangent(function: &Function) -> bool {
    matches!(function.output, Output::Form | Output::Energy)
}
