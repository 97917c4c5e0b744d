//! `FORMS_DUMP=name cargo build`: the stages of a form as text, on standard error. One file per stage; each takes what the
//! stage gives and adds to the text. The printers read, and no stage knows them.

pub mod checked;
pub mod code;
mod costs;
pub mod counts;
pub mod differentiated;
pub mod optimised;
mod tensors;
mod ways;

use proc_macro2::TokenStream;
use quote::quote;

/// The name of the variable. Emitted code reads it, too, so that cargo builds again when it changes.
pub const VARIABLE: &str = "FORMS_DUMP";

/// The request, and the text so far.
#[derive(Debug, Default)]
pub struct Dump {
    wanted: Vec<String>,
    pub text: String,
}

impl Dump {
    /// `name`, `name:2`, `all`, `all:3`, or several with commas between.
    pub fn new(request: &str) -> Self {
        let wanted = request.split(',').map(str::trim).filter(|word| !word.is_empty());
        Dump { wanted: wanted.map(str::to_string).collect(), text: String::new() }
    }

    /// As the environment asks.
    pub fn from_environment() -> Self {
        Dump::new(&std::env::var(VARIABLE).unwrap_or_default())
    }

    /// Is this function asked for, in this dimension?
    pub fn wants(&self, name: &str, dimension: usize) -> bool {
        self.wanted.iter().any(|word| match word.split_once(':') {
            Some((wanted, number)) => is(wanted, name) && number.trim() == dimension.to_string(),
            None => is(word, name),
        })
    }

    /// Begins the text of a stage.
    pub fn heading(&mut self, stage: &str, name: &str, dimension: usize) {
        self.text += &format!("\n=== {name} in {dimension}D: {stage} ===\n");
    }
}

fn is(wanted: &str, name: &str) -> bool {
    wanted == "all" || wanted == name
}

/// Tokens that make cargo build again when the variable changes.
pub fn tracker() -> TokenStream {
    quote! { const _: ::core::option::Option<&::core::primitive::str> = ::core::option_env!(#VARIABLE); }
}
