//! Placeholder while the compiler is built.
use proc_macro::TokenStream;

/// Compiles a module of weak forms.
#[proc_macro_attribute]
pub fn forms(_attribute: TokenStream, item: TokenStream) -> TokenStream {
    item
}
