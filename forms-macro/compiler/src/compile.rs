//! The driver: runs the five stages, each from its input type to its output type.
//!
//! ```text
//! syn::ItemMod ─parse→ Module ─check→ Checked ─differentiate→ Derived ─optimise→ Optimised ─emit→ Rust
//! ```

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::{Ident, ItemMod, LitInt, Path, Token};

use crate::check::check;
use crate::diagnostics::{Diagnostics, Place};
use crate::differentiate::differentiate;
use crate::emit::emit;
use crate::optimise::optimise;
use crate::parse::parse;
use crate::reuse::uses::{self, Import};
use crate::reuse::{self, State, Subject, carrier, import, payload};
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

/// Begins to compile: the imports first.
pub fn start(state: State) -> TokenStream {
    let options = match syn::parse2::<Options>(state.attribute.clone()) {
        Ok(options) => options,
        Err(error) => return error.into_compile_error(),
    };
    let Subject::Module(item) = &state.subject;
    let (attributes, visibility, name) = (&item.attrs, &item.vis, &item.ident);
    let content = proceed(&options, &state);
    quote! {
        #(#attributes)*
        #[allow(missing_docs, dead_code, unused_variables, non_snake_case, non_camel_case_types, uncommon_codepoints, mixed_script_confusables)]
        #[allow(clippy::all)]
        #visibility mod #name {
            #content
        }
    }
}

/// Goes on when another import has arrived. The options have been read before.
pub fn resume(state: State) -> TokenStream {
    match syn::parse2::<Options>(state.attribute.clone()) {
        Ok(options) => proceed(&options, &state),
        Err(error) => error.into_compile_error(),
    }
}

/// Asks for the next import, or compiles.
fn proceed(options: &Options, state: &State) -> TokenStream {
    let Subject::Module(item) = &state.subject;
    let mut diagnostics = Diagnostics::default();
    let items = item.content.iter().flat_map(|(_, items)| items);
    let imports = uses::read(items, &mut diagnostics);
    match imports.get(state.received.len()) {
        Some(next) => reuse::call(next, &options.backend, state),
        None => compile(options, (**item).clone(), imports, &state.received, diagnostics),
    }
}

/// Compiles a module whose imports have arrived. Mistakes become compiler errors, after which the module's names exist.
fn compile(
    options: &Options,
    mut item: ItemMod,
    imports: Vec<Import>,
    received: &[Literal],
    mut diagnostics: Diagnostics,
) -> TokenStream {
    let texts: Vec<String> =
        received.iter().filter_map(|text| payload::string(text.clone().into())).collect();
    let mut arrived = import::read(imports, &texts, &mut diagnostics);
    import::add_declarations(&mut item, &mut arrived);
    let mut module = parse(item.clone(), &mut diagnostics);
    let imported = import::add_functions(arrived, &item, &mut module, &mut diagnostics);
    let mut optimised = Vec::new();
    for &dimension in &options.dimensions {
        for checked in check(&module, dimension, &mut diagnostics).functions {
            let name = &module.functions[checked.function].name;
            let before = diagnostics.reports();
            let derived = differentiate(checked, &module.regions, &mut diagnostics);
            if diagnostics.reports() > before {
                continue;
            }
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
    let text = payload::write(&item, &imported, !diagnostics.is_empty());
    let carrier = carrier::write(&item, &imported, &text);
    let errors = diagnostics.into_tokens();
    let code = emit(&module, &options.dimensions, optimised, &formulas, &options.backend);
    quote! { #errors #code #carrier }
}
