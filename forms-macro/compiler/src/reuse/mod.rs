//! Reuse across modules: `use super::elasticity::stress;` inside a forms module.
//!
//! A macro sees the tokens that it is applied to and no others. So each compiled module leaves a *carrier*, a hidden
//! `macro_rules!` with the module's own text, re-exported under the names of its functions ([`carrier`], [`payload`]). A
//! module with imports expands in place to a call of the first import's path; the carrier found there calls
//! [`resume`] with its text and the rest of the module; that calls the next import, until all texts are there and the module
//! is compiled. rustc resolves the paths, so imports obey Rust's own rules, in any order of modules and across crates. The data
//! that a module's include come the same way ([`inclusion`]).
//!
//! ```text
//! ItemMod ─uses→ [Import] ─resume, once per import→ [Payload] ─import→ functions of the Module
//! ```

pub mod carrier;
#[cfg(test)]
pub mod flatten;
pub mod import;
pub mod inclusion;
mod needs;
pub mod payload;
pub mod uses;

use proc_macro2::{Literal, TokenStream};
use quote::{quote, quote_spanned};
use syn::parse::{Parse, ParseStream};
use uses::Import;

/// The state between two calls: the item that is compiled, and the texts that have arrived.
pub struct State {
    /// The macro's arguments, and the word that says which macro it is.
    pub attribute: TokenStream,
    pub subject: Subject,
    pub received: Vec<Literal>,
}

/// The item that is compiled.
pub enum Subject {
    /// The module of `#[forms]`.
    Module(Box<syn::ItemMod>),
    /// The content of `form!`.
    Form(TokenStream),
}

impl Subject {
    fn tokens(&self) -> TokenStream {
        match self {
            Subject::Module(item) => quote! { module { #item } },
            Subject::Form(tokens) => quote! { form { #tokens } },
        }
    }
}

impl Parse for State {
    /// `"text" (attribute) module { item } ["earlier text" ..]`, or `form { .. }`: a carrier's text, then the state that it was given.
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let text: Literal = input.parse()?;
        let attribute;
        syn::parenthesized!(attribute in input);
        let attribute = attribute.parse()?;
        let word: syn::Ident = input.parse()?;
        let source;
        syn::braced!(source in input);
        let subject = match word == "form" {
            true => Subject::Form(source.parse()?),
            false => Subject::Module(source.parse()?),
        };
        let earlier;
        syn::bracketed!(earlier in input);
        let mut received = Vec::new();
        while !earlier.is_empty() {
            received.push(earlier.parse()?);
        }
        received.push(text);
        Ok(State { attribute, subject, received })
    }
}

/// The call of an import's carrier, which will call `resume` with its text and `state`.
pub fn call(import: &Import, backend: &syn::Path, state: &State) -> TokenStream {
    let State { attribute, subject, received } = state;
    let (path, subject) = (&import.path, subject.tokens());
    quote_spanned! { import.name.span() =>
        #path ! { [#backend::contract::resume_forms] (#attribute) #subject [#(#received)*] }
    }
}
