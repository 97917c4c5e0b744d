//! The driver: runs the five stages, each from its input type to its output type.
//!
//! ```text
//! syn::ItemMod ─parse→ Module ─check→ Checked ─differentiate→ Derived ─optimise→ Optimised ─emit→ Rust
//! ```

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::{Ident, ItemMod, LitInt, Path, Token};

use crate::check::check;
use crate::diagnostics::{Diagnostics, Place};
use crate::differentiate::differentiate;
use crate::emit::emit;
use crate::optimise::optimise;
use crate::parse::parse;
use crate::show::formulas;

/// `#[forms(dimension = 3, crate = my_backend)]`
pub struct Options {
    dimensions: Vec<usize>,
    backend: Path,
}

impl Parse for Options {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let mut options = Options { dimensions: vec![2, 3], backend: syn::parse_quote!(::forms_fem) };
        while !input.is_empty() {
            if input.peek(Token![crate]) {
                input.parse::<Token![crate]>()?;
                input.parse::<Token![=]>()?;
                options.backend = input.call(Path::parse_mod_style)?;
            } else {
                let name: Ident = input.parse()?;
                if name != "dimension" {
                    let message = format!(
                        "unknown option `{name}`\nhelp: the options are `dimension = 2`, `dimension = 3` and `crate = path`"
                    );
                    return Err(syn::Error::new(name.span(), message));
                }
                input.parse::<Token![=]>()?;
                let value: LitInt = input.parse()?;
                match value.base10_parse::<usize>() {
                    Ok(dimension @ (2 | 3)) => options.dimensions = vec![dimension],
                    _ => return Err(syn::Error::new(value.span(), "the dimension is 2 or 3")),
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(options)
    }
}

/// Compiles a module of weak forms. Mistakes become compiler errors, after which the module's names exist.
pub fn compile(options: &Options, item: ItemMod) -> TokenStream {
    let mut diagnostics = Diagnostics::default();
    let module = parse(item, &mut diagnostics);
    let mut optimised = Vec::new();
    for &dimension in &options.dimensions {
        for checked in check(&module, dimension, &mut diagnostics).functions {
            let name = &module.functions[checked.function].name;
            let derived = differentiate(checked, &mut diagnostics);
            match optimise(derived, &module) {
                Ok(one) => optimised.push(one),
                Err(argument) => {
                    diagnostics.error(
                        Place::of(name),
                        format!("`{name}` could not be brought into a form linear in `{argument}`"),
                    );
                }
            }
        }
        diagnostics.next_dimension();
    }
    // A formula is the same in each dimension.
    let formulas = match diagnostics.is_empty() {
        true => formulas(&module, options.dimensions[0]),
        false => Vec::new(),
    };
    let errors = diagnostics.into_tokens();
    let code = emit(&module, &options.dimensions, optimised, &formulas, &options.backend);
    quote! { #errors #code }
}
