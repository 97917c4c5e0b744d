//! The driver: runs the five stages, each from its input type to its output type.
//!
//! ```text
//! syn::ItemMod ─parse→ Module ─check→ Checked ─differentiate→ Derived ─optimise→ Optimised ─emit→ Rust
//! ```
//!
//! Next to the stages: `calls` are the ways in, `reuse` brings what the module imports before the stages, `dump` and `show` print what
//! they made, `proof` and `reference` check them on random forms.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::{Ident, ItemMod};

use crate::check::check;
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::differentiate::differentiate;
use crate::dump::{self, Dump};
use crate::emit::named_regions::regions_named;
use crate::emit::{editor, emit};
use crate::optimise::{Failure, optimise};
use crate::options::{Options, Products};
use crate::parse::parse;
use crate::reuse::import::Arrived;
use crate::reuse::names::Import;
use crate::reuse::{carrier, import, payload};
use crate::rustc_arguments;
use crate::show::formulas;

/// A module whose imports have arrived.
pub struct Unit<'a> {
    pub options: &'a Options,
    pub item: ItemMod,
    pub diagnostics: Diagnostics,
    pub dump: &'a mut Dump,
}

/// The output for a module.
pub struct Compiled {
    /// Errors, and the module's inside.
    pub code: TokenStream,
    /// The tokens that make it importable.
    pub carrier: TokenStream,
    /// The regions that the constructor of the first function asks for; `None` if it has a mistake.
    pub used: Option<Vec<Ident>>,
}

impl Unit<'_> {
    /// The imports with the texts that came for them.
    pub fn arrived(&mut self, imports: Vec<Import>, received: &[Literal]) -> Vec<Arrived> {
        let texts: Vec<String> =
            received.iter().filter_map(|text| payload::string(text.clone().into())).collect();
        import::read(imports, &texts, &mut self.diagnostics)
    }

    /// Mistakes become compiler errors, after which the module's names exist.
    pub fn compile(self, arrived: Vec<Arrived>) -> Compiled {
        let Unit { options, item, mut diagnostics, dump } = self;
        let mut module = parse(item.clone(), &mut diagnostics);
        let imported = import::add_functions(arrived, &item, &mut module, &mut diagnostics);
        let mut optimised = Vec::new();
        for &dimension in &options.dimensions {
            for checked in check(&module, dimension, &mut diagnostics).functions {
                let name = &module.functions[checked.function].name;
                dump.checked(&module, &checked);
                let before = diagnostics.reports();
                let derived = differentiate(checked, &module.regions, &mut diagnostics);
                if diagnostics.reports() > before {
                    continue;
                }
                if options.products != Products::ByMatrices && derived.has_facet_means() {
                    diagnostics.error_with_help(
                        SourceSpan::of(name),
                        format!("`{name}` has `means`, and their tangent has no products without a matrix"),
                        "leave `matrix_free` out of this module's `#[forms(..)]`, or put the form into another one",
                    );
                    continue;
                }
                dump.differentiated(&module, &derived);
                match optimise(derived, &module) {
                    Ok(one) => {
                        dump.optimised(&module, &one);
                        optimised.push(one);
                    }
                    Err(Failure::NotLinear(argument)) => {
                        diagnostics.error(
                            SourceSpan::of(name),
                            format!("`{name}` could not be brought into a form linear in `{argument}`"),
                        );
                    }
                    Err(Failure::TooLarge { .. }) => diagnostics.error_with_help(
                        SourceSpan::of(name),
                        format!("`{name}` unfolds to more than 1.5 million scalar operations"),
                        "split it into several forms, or compute tensors of high rank in fewer steps",
                    ),
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
        let complete = |index: usize| {
            optimised.iter().filter(|one| one.function == index).count() == options.dimensions.len()
        };
        let used = module.functions.first().filter(|_| complete(0)).map(|function| {
            let used = regions_named(&module, function).into_iter();
            used.map(|region| module.regions[region].name.clone()).collect()
        });
        let errors = diagnostics.into_tokens();
        let Options { dimensions, backend, products, points, .. } = options;
        let code = emit(&module, dimensions, optimised, &formulas, backend, (*products, *points));
        let names: Vec<String> = module.functions.iter().map(|function| function.name.to_string()).collect();
        dump.emitted(&names, &options.dimensions, &code);
        let tracker = dump::tracker();
        // First: rust-analyzer looks for the name that is being typed at the same offset with and without it, and all else
        // changes with the first mistake.
        let names = rustc_arguments::in_editor().then(|| editor::bodies(&item, &module, &options.backend));
        Compiled { code: quote! { #names #errors #tracker #code }, carrier, used }
    }
}
