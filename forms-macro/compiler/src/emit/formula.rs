//! A function's formulas: in the documentation, and for the program.

use proc_macro2::TokenStream;
use quote::quote;

use crate::parse::syntax::{Function, Module};
use crate::show::Shown;

/// The documentation: MathML for rustdoc, text for editors, which draw no MathML.
pub fn page(shown: &Shown, module: &Module, function: &Function) -> TokenStream {
    let page = shown.page(module, function);
    let text = format!("\n\n```text\n{}\n```", shown.unicode());
    quote! {
        #[cfg_attr(doc, doc = #page)]
        #[cfg_attr(not(doc), doc = #text)]
    }
}

/// A `contract::Formula`.
pub fn formula(shown: Option<&Shown>) -> TokenStream {
    let (unicode, latex) = shown.map(|shown| (shown.unicode(), shown.latex())).unwrap_or_default();
    quote! { contract::Formula { unicode: #unicode, latex: #latex } }
}
