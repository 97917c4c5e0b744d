//! Compiles a module of weak forms, written as Rust functions, to assembly kernels.
//!
//! The stages, each a module: `parse` → `check` → `differentiate` → `optimise` → `emit`;
//! `compile` drives them. No stage knows a mesh or an element.

extern crate proc_macro;

mod check;
mod compile;
mod diagnostics;
mod differentiate;
mod dump;
mod emit;
mod one_form;
mod optimise;
mod parse;
#[cfg(test)]
mod proof;
#[cfg(test)]
mod reference;
mod reuse;
mod rustc_arguments;
mod show;
mod sorted;
mod tensor;

use proc_macro2::TokenStream;

/// Expands `#[forms(attribute)] item` to kernels, or to compiler errors on the tokens of the mistakes.
/// A module with imports becomes a call that leads to [`resume_forms`].
pub fn forms(attribute: TokenStream, item: TokenStream) -> TokenStream {
    if let Err(error) = parse::nesting::check(item.clone()) {
        return error.into_compile_error();
    }
    match syn::parse2::<syn::ItemMod>(parse::raw::plain(item)) {
        Ok(item) => {
            let subject = reuse::Subject::Module(Box::new(item));
            compile::start(reuse::State { attribute, subject, received: vec![] })
        }
        Err(error) => error.into_compile_error(),
    }
}

/// Expands `form!(input)` to an expression whose value is the form, or a closure that takes its known fields.
pub fn form(input: TokenStream) -> TokenStream {
    if let Err(error) = parse::nesting::check(input.clone()) {
        return error.into_compile_error();
    }
    let subject = reuse::Subject::Form(parse::raw::plain(input));
    compile::start_form(reuse::State { attribute: TokenStream::new(), subject, received: vec![] })
}

/// The output of `FORMS_DUMP=request` for a module without imports.
pub fn dump(attribute: TokenStream, item: TokenStream, request: &str) -> syn::Result<String> {
    compile::dump(&syn::parse2(attribute)?, syn::parse2(item)?, request)
}

/// The formulas of a module without imports: the name and the MathML of each function that becomes a form, a functional or
/// an expression, as on its page in rustdoc.
pub fn mathml(attribute: TokenStream, item: TokenStream) -> syn::Result<Vec<(String, String)>> {
    let shown = compile::typeset(&syn::parse2(attribute)?, syn::parse2(parse::raw::plain(item))?)?;
    Ok(shown.into_iter().map(|(name, shown)| (name, shown.mathml())).collect())
}

/// Resumes a module when the text of one of its imports has arrived: the call for the next, or kernels.
pub fn resume_forms(input: TokenStream) -> TokenStream {
    match syn::parse2::<reuse::State>(input) {
        Ok(state) => compile::resume(state),
        Err(error) => error.into_compile_error(),
    }
}
