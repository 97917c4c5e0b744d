//! The driver: runs the five stages, each from its input type to its output type.
//!
//! ```text
//! syn::ItemMod ─parse→ Module ─check→ Checked ─differentiate→ Derived ─optimise→ Optimised ─emit→ Rust
//! ```
//!
//! Next to the stages: `reuse` brings what the module imports before them, `dump` and `show` print what they made, `proof` and
//! `reference` check them on random forms.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::{Ident, ItemMod, LitInt, Path, Token};

use crate::check::check;
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::differentiate::differentiate;
use crate::dump::{self, Dump};
use crate::emit::named_regions::regions_named;
use crate::emit::{Products, editor, emit};
use crate::one_form::OneForm;
use crate::optimise::{Failure, optimise};
use crate::parse::attributes::outer;
use crate::parse::parse;
use crate::reuse::import::Arrived;
use crate::reuse::uses::{self, Import};
use crate::reuse::{self, State, Subject, carrier, import, payload};
use crate::show::{Shown, formulas};

/// `#[forms(dimension = 3, matrix_free, crate = my_backend)]`
pub struct Options {
    dimensions: Vec<usize>,
    backend: Path,
    products: Products,
}

impl Parse for Options {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let mut options = Options {
            dimensions: vec![2, 3],
            backend: syn::parse_quote!(::forms_fem),
            products: Products::ByMatrices,
        };
        while !input.is_empty() {
            if input.peek(Token![crate]) {
                input.parse::<Token![crate]>()?;
                input.parse::<Token![=]>()?;
                options.backend = rooted(input.call(Path::parse_mod_style)?);
            } else {
                let name: Ident = input.parse()?;
                if name == "matrix_free" {
                    options.products = Products::MatrixFree;
                    if !input.is_empty() {
                        input.parse::<Token![,]>()?;
                    }
                    continue;
                }
                if name != "dimension" {
                    let message = format!(
                        "unknown option `{name}`\nhelp: the options are `dimension = 2`, `dimension = 3`, `matrix_free` and `crate = path`"
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

/// A path that begins with a crate's name says so: a function of the module may have that name, too.
fn rooted(mut path: Path) -> Path {
    let relative = |name: &Ident| name == "crate" || name == "self" || name == "super";
    if !path.segments.first().is_some_and(|first| relative(&first.ident)) {
        path.leading_colon.get_or_insert_default();
    }
    path
}

/// Begins to compile a module: the imports first.
pub fn start(state: State) -> TokenStream {
    let options = match syn::parse2::<Options>(state.attribute.clone()) {
        Ok(options) => options,
        Err(error) => return error.into_compile_error(),
    };
    let Subject::Module(item) = &state.subject else { return TokenStream::new() };
    let (attributes, visibility, name) = (item.attrs.iter().cloned().map(outer), &item.vis, &item.ident);
    let content = proceed(&options, item, &state);
    let allow = allow();
    quote! {
        #(#attributes)*
        #allow
        #visibility mod #name {
            #content
        }
    }
}

/// Lints that emitted modules are free of.
pub fn allow() -> TokenStream {
    quote! {
        #[allow(missing_docs, dead_code, unused_variables, non_snake_case, non_camel_case_types, uncommon_codepoints, mixed_script_confusables)]
        #[allow(clippy::all)]
    }
}

/// Begins to compile the contents of `form!`.
pub fn start_form(state: State) -> TokenStream {
    match &state.subject {
        Subject::Form(tokens) => proceed_form(tokens, &state),
        Subject::Module(_) => TokenStream::new(),
    }
}

/// Goes on when another import has arrived. The options have been read before.
pub fn resume(state: State) -> TokenStream {
    match &state.subject {
        Subject::Form(tokens) => proceed_form(tokens, &state),
        Subject::Module(item) => match syn::parse2::<Options>(state.attribute.clone()) {
            Ok(options) => proceed(&options, item, &state),
            Err(error) => error.into_compile_error(),
        },
    }
}

/// Asks for the next import of a module, or compiles.
fn proceed(options: &Options, item: &ItemMod, state: &State) -> TokenStream {
    let (imports, diagnostics) = read_uses(item);
    if let Some(next) = imports.get(state.received.len()) {
        return reuse::call(next, &options.backend, state);
    }
    let mut dump = Dump::from_environment();
    let mut unit = Unit { options, item: item.clone(), diagnostics, dump: &mut dump };
    let mut arrived = unit.arrived(imports, &state.received);
    import::add_declarations(&mut unit.item, &mut arrived, &mut unit.diagnostics);
    let compiled = unit.compile(arrived);
    eprint!("{}", dump.text);
    let Compiled { code, carrier, .. } = compiled;
    quote! { #code #carrier }
}

/// Asks for the next import of a `form!`, or compiles.
fn proceed_form(tokens: &TokenStream, state: &State) -> TokenStream {
    let form: OneForm = match syn::parse2(tokens.clone()) {
        Ok(form) => form,
        Err(error) => return error.into_compile_error(),
    };
    let options: Options = match syn::parse2(form.options.clone()) {
        Ok(options) => options,
        Err(error) => return error.into_compile_error(),
    };
    let (imports, diagnostics) = read_uses(&form.item);
    if let Some(next) = imports.get(state.received.len()) {
        return reuse::call(next, &options.backend, state);
    }
    let mut dump = Dump::from_environment();
    let mut unit = Unit { options: &options, item: form.item.clone(), diagnostics, dump: &mut dump };
    let arrived = unit.arrived(imports, &state.received);
    let Compiled { code, used, .. } = unit.compile(arrived);
    eprint!("{}", dump.text);
    form.expression(code, used.as_deref(), &options.backend)
}

/// The text that is printed on request, of a module without imports.
pub fn dump(options: &Options, item: ItemMod, request: &str) -> syn::Result<String> {
    let mut dump = Dump::new(request);
    let unit = Unit { options, item, diagnostics: Diagnostics::default(), dump: &mut dump };
    unit.compile(vec![]);
    Ok(dump.text)
}

/// The names of the functions that become forms, functionals and the like, of a module without imports, with their formulas.
pub fn typeset(options: &Options, item: ItemMod) -> syn::Result<Vec<(String, Shown)>> {
    let (imports, mut diagnostics) = read_uses(&item);
    if let Some(import) = imports.first() {
        return Err(syn::Error::new(
            import.name.span(),
            "formulas of a module with imports need the other modules' texts",
        ));
    }
    let module = parse(item, &mut diagnostics);
    if !diagnostics.is_empty() {
        return Err(syn::Error::new(module.name.span(), format!("`{}` has mistakes", module.name)));
    }
    let formulas = formulas(&module, options.dimensions[0]).into_iter();
    let names = module.functions.iter().map(|function| function.name.to_string());
    Ok(names.zip(formulas).filter_map(|(name, shown)| Some((name, shown?))).collect())
}

fn read_uses(item: &ItemMod) -> (Vec<Import>, Diagnostics) {
    let mut diagnostics = Diagnostics::default();
    let items = item.content.iter().flat_map(|(_, items)| items);
    (uses::read(items, &mut diagnostics), diagnostics)
}

/// A module whose imports have arrived.
struct Unit<'a> {
    options: &'a Options,
    item: ItemMod,
    diagnostics: Diagnostics,
    dump: &'a mut Dump,
}

/// The output for a module.
struct Compiled {
    /// Errors, and the module's inside.
    code: TokenStream,
    /// The tokens that make it importable.
    carrier: TokenStream,
    /// The regions that the constructor of the first function asks for; `None` if it has a mistake.
    used: Option<Vec<Ident>>,
}

impl Unit<'_> {
    fn arrived(&mut self, imports: Vec<Import>, received: &[Literal]) -> Vec<Arrived> {
        let texts: Vec<String> =
            received.iter().filter_map(|text| payload::string(text.clone().into())).collect();
        import::read(imports, &texts, &mut self.diagnostics)
    }

    /// Mistakes become compiler errors, after which the module's names exist.
    fn compile(self, arrived: Vec<Arrived>) -> Compiled {
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
                    Err(Failure::TooLarge) => diagnostics.error_with_help(
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
        let Options { dimensions, backend, products } = options;
        let code = emit(&module, dimensions, optimised, &formulas, backend, *products);
        let names: Vec<String> = module.functions.iter().map(|function| function.name.to_string()).collect();
        dump.emitted(&names, &options.dimensions, &code);
        let tracker = dump::tracker();
        // First: rust-analyzer looks for the name that is being typed at the same offset with and without it, and all else
        // changes with the first mistake.
        let names = editor::is_editor().then(|| editor::bodies(&item, &module, &options.backend));
        Compiled { code: quote! { #names #errors #tracker #code }, carrier, used }
    }
}
