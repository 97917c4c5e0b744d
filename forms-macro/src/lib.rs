//! The attribute `#[forms]`. The compiler behind it is the package `forms-compiler`, an ordinary library, so that tests and
//! fuzzers can call it.

use proc_macro::TokenStream;

/// Compiles a module of weak forms. See the crate `forms-fem` for the language.
#[proc_macro_attribute]
pub fn forms(attribute: TokenStream, item: TokenStream) -> TokenStream {
    forms_compiler::forms(attribute.into(), item.into()).into()
}

/// Compiles one weak form without a module: `form!(|u: Unknown<Scalar>, v: Test<Scalar>| ..)`. See the language.
#[proc_macro]
pub fn form(input: TokenStream) -> TokenStream {
    forms_compiler::form(input.into()).into()
}

/// Continues a module whose import has arrived; only compiled modules call it.
#[doc(hidden)]
#[proc_macro]
pub fn resume_forms(input: TokenStream) -> TokenStream {
    forms_compiler::resume_forms(input.into()).into()
}
