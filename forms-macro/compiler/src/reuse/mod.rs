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
pub mod names;
mod needs;
pub mod payload;
pub mod uses;

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::ItemMod;
use syn::parse::{Parse, ParseStream};

use self::names::Import;
use crate::one_form::OneForm;
use crate::options::Options;

/// The state between two calls: the item that is compiled, and the texts that have arrived.
pub struct State {
    pub options: Options,
    pub subject: Subject,
    pub received: Vec<Literal>,
}

/// The item that is compiled.
pub enum Subject {
    /// The module of `#[forms]`.
    Module(Box<ItemMod>),
    /// The content of `form!`, as it was written and as it was read.
    Form { written: TokenStream, form: Box<OneForm> },
}

impl State {
    /// The state of a `form!`, whose options are in its content.
    ///
    /// # Errors
    /// Tokens that are no form.
    pub fn of_form(written: TokenStream, received: Vec<Literal>) -> syn::Result<Self> {
        let form: OneForm = syn::parse2(written.clone())?;
        let options = syn::parse2(form.options.clone())?;
        Ok(State { options, subject: Subject::Form { written, form: Box::new(form) }, received })
    }
}

impl Subject {
    /// The module; for a `form!` the equivalent module.
    pub fn item(&self) -> &ItemMod {
        match self {
            Subject::Module(item) => item,
            Subject::Form { form, .. } => &form.item,
        }
    }

    fn tokens(&self) -> TokenStream {
        match self {
            Subject::Module(item) => quote! { module { #item } },
            Subject::Form { written, .. } => quote! { form { #written } },
        }
    }
}

impl Parse for State {
    /// `"text" (options) module { item } ["earlier text" ..]`, or `form { .. }`: a carrier's text, then the state that it was given.
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let text: Literal = input.parse()?;
        let options;
        syn::parenthesized!(options in input);
        let options: TokenStream = options.parse()?;
        let word: syn::Ident = input.parse()?;
        let source;
        syn::braced!(source in input);
        let source: TokenStream = source.parse()?;
        let earlier;
        syn::bracketed!(earlier in input);
        let mut received = Vec::new();
        while !earlier.is_empty() {
            received.push(earlier.parse()?);
        }
        received.push(text);
        if word == "form" {
            return State::of_form(source, received);
        }
        let subject = Subject::Module(Box::new(syn::parse2(source)?));
        Ok(State { options: syn::parse2(options)?, subject, received })
    }
}

/// The call of an import's carrier, which will call `resume` with its text and `state`.
pub fn call(import: &Import, state: &State) -> TokenStream {
    let State { options, subject, received } = state;
    let (path, subject, backend) = (&import.path, subject.tokens(), &options.backend);
    let options = match state.subject {
        Subject::Module(_) => options.to_token_stream(),
        Subject::Form { .. } => TokenStream::new(),
    };
    quote_spanned! { import.name.span() =>
        #path ! { [#backend::contract::resume_forms] (#options) #subject [#(#received)*] }
    }
}
