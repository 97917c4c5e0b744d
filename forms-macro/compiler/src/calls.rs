//! The five calls of the library: the two macros, what resumes them when an import has arrived, and two printers.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemMod;

use crate::compile::{Compiled, Unit};
use crate::diagnostics::Diagnostics;
use crate::dump::Dump;
use crate::emit::names::allow;
use crate::options::Options;
use crate::parse::attributes::outer;
use crate::parse::{controls, nesting, parse, raw};
use crate::reuse::names::Import;
use crate::reuse::{self, State, Subject, import, uses};
use crate::show::formulas as formulas_of;

/// Expands `#[forms(attribute)] item` to kernels, or to compiler errors on the tokens of the mistakes.
/// A module with imports becomes a call that leads to [`resume_forms`].
pub fn forms(attribute: TokenStream, item: TokenStream) -> TokenStream {
    begun(attribute, item).unwrap_or_else(syn::Error::into_compile_error)
}

fn begun(attribute: TokenStream, item: TokenStream) -> syn::Result<TokenStream> {
    nesting::check(item.clone())?;
    let mut item: ItemMod = syn::parse2(raw::plain(item))?;
    let errors = controls::expand(&mut item);
    let options: Options = syn::parse2(attribute)?;
    let (attributes, visibility, name) =
        (item.attrs.iter().cloned().map(outer), item.vis.clone(), item.ident.clone());
    let attributes: Vec<_> = attributes.collect();
    let content = proceed(&State { options, subject: Subject::Module(Box::new(item)), received: vec![] });
    let allow = allow();
    Ok(quote! {
        #(#attributes)*
        #allow
        #visibility mod #name {
            #errors
            #content
        }
    })
}

/// Expands `form!(input)` to an expression whose value is the form, or a closure that takes its known fields.
pub fn form(input: TokenStream) -> TokenStream {
    let state = nesting::check(input.clone()).and_then(|()| State::of_form(raw::plain(input), vec![]));
    match state {
        Ok(state) => proceed(&state),
        Err(error) => error.into_compile_error(),
    }
}

/// Resumes a module or a form when the text of one of its imports has arrived: the call for the next, or kernels.
pub fn resume_forms(input: TokenStream) -> TokenStream {
    match syn::parse2::<State>(input) {
        Ok(state) => proceed(&state),
        Err(error) => error.into_compile_error(),
    }
}

/// The output of `FORMS_DUMP=request` for a module without imports.
///
/// # Errors
/// Attributes or an item that are no forms module.
pub fn dump(attribute: TokenStream, item: TokenStream, request: &str) -> syn::Result<String> {
    let options: Options = syn::parse2(attribute)?;
    let mut item: ItemMod = syn::parse2(item)?;
    controls::expand(&mut item);
    let mut dump = Dump::new(request);
    let unit = Unit { options: &options, item, diagnostics: Diagnostics::default(), dump: &mut dump };
    unit.compile(vec![]);
    Ok(dump.text)
}

/// The formulas of a module without imports: the name and the MathML of each function that becomes a form, a functional or
/// an expression, as on its page in rustdoc.
///
/// # Errors
/// Attributes or an item that are no forms module, a module with imports, or one with mistakes.
pub fn mathml(attribute: TokenStream, item: TokenStream) -> syn::Result<Vec<(String, String)>> {
    let options: Options = syn::parse2(attribute)?;
    let mut item: ItemMod = syn::parse2(raw::plain(item))?;
    controls::expand(&mut item);
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
    let shown = formulas_of(&module, options.dimensions[0]).into_iter();
    let names = module.functions.iter().map(|function| function.name.to_string());
    Ok(names.zip(shown).filter_map(|(name, shown)| Some((name, shown?.mathml()))).collect())
}

/// Asks for the next import, or compiles.
fn proceed(state: &State) -> TokenStream {
    let State { options, subject, received } = state;
    let item = subject.item();
    let (imports, diagnostics) = read_uses(item);
    if let Some(next) = imports.get(received.len()) {
        return reuse::call(next, state);
    }
    let mut dump = Dump::from_environment();
    let mut unit = Unit { options, item: item.clone(), diagnostics, dump: &mut dump };
    let mut arrived = unit.arrived(imports, received);
    if let Subject::Module(_) = subject {
        import::add_declarations(&mut unit.item, &mut arrived, &mut unit.diagnostics);
    }
    let Compiled { code, carrier, used } = unit.compile(arrived);
    eprint!("{}", dump.text);
    match subject {
        Subject::Module(_) => quote! { #code #carrier },
        Subject::Form { form, .. } => form.expression(code, used.as_deref(), &options.backend),
    }
}

fn read_uses(item: &ItemMod) -> (Vec<Import>, Diagnostics) {
    let mut diagnostics = Diagnostics::default();
    let items = item.content.iter().flat_map(|(_, items)| items);
    (uses::read(items, &mut diagnostics), diagnostics)
}
