//! A forms module as text, taken through the compiler: once up to `check`, once to the end.

use proc_macro2::TokenStream;

use crate::check::{CheckedFunction, check};
use crate::diagnostics::Diagnostics;
use crate::differentiate::differentiate;
use crate::optimise::{Failure, optimise};
use crate::parse::parse;
use crate::parse::syntax::Module;

/// A module to be compiled for one dimension.
pub struct Source {
    pub dimension: usize,
    pub text: String,
}

impl Source {
    pub fn new(dimension: usize, text: &str) -> Self {
        Source { dimension, text: text.into() }
    }

    fn tokens(&self) -> TokenStream {
        self.text.parse().unwrap_or_else(|error| panic!("{error} in\n{}", self.text))
    }

    pub fn module(&self) -> Module {
        let item = syn::parse2(self.tokens()).unwrap_or_else(|error| panic!("{error} in\n{}", self.text));
        parse(item, &mut Diagnostics::default())
    }

    /// The checked functions, or the compiler's messages.
    pub fn checked(&self) -> Result<Vec<CheckedFunction>, String> {
        let item = syn::parse2(self.tokens()).map_err(|error| error.to_string())?;
        let mut diagnostics = Diagnostics::default();
        let module = parse(item, &mut diagnostics);
        let checked = check(&module, self.dimension, &mut diagnostics);
        let errors = diagnostics.into_tokens();
        if errors.is_empty() { Ok(checked.functions) } else { Err(errors.to_string()) }
    }

    /// The most work that planning one of the functions takes ([`crate::optimise::scalar::Graph::work`]), or that is done
    /// before one is refused.
    pub fn work(&self) -> usize {
        let (module, mut diagnostics) = (self.module(), Diagnostics::default());
        let functions = check(&module, self.dimension, &mut diagnostics).functions;
        let work = functions.into_iter().map(|checked| {
            let derived = differentiate(checked, &module.regions, &mut diagnostics);
            match optimise(derived, &module) {
                Ok(planned) => planned.graph.work(),
                Err(Failure::TooLarge { work }) => work,
                Err(Failure::NotLinear(argument)) => panic!("not linear in {argument}"),
            }
        });
        work.max().unwrap_or(0)
    }

    /// The output of the attribute.
    pub fn emitted(&self) -> TokenStream {
        let attribute = format!("dimension = {}, matrix_free", self.dimension);
        crate::forms(attribute.parse().expect("tokens"), self.tokens())
    }
}
