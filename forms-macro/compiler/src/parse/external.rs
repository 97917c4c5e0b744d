//! `extern "Rust" { fn flux(g: Vector, k: Scalar) -> Vector; }`: functions written in Rust, outside the module.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote_spanned};
use syn::spanned::Spanned;
use syn::{FnArg, ForeignItem, ForeignItemFn, ItemForeignMod, Path, ReturnType};

use super::declared_type::{self, Unread};
use super::syntax::{ArgumentRole, External, Mistaken, Module};
use super::{attributes, read_argument};
use crate::diagnostics::{Diagnostics, SourceSpan};

/// Reads the functions of an `extern` block; what cannot be read is reported, and its name is known.
pub fn read(block: ItemForeignMod, module: &mut Module, diagnostics: &mut Diagnostics) {
    block.attrs.iter().for_each(|one| attributes::check_inside(one, diagnostics));
    if block.abi.name.as_ref().is_none_or(|name| name.value() != "Rust") {
        diagnostics.error_with_help(
            SourceSpan::of(&block.abi),
            "a form calls functions that are written in Rust",
            "write `extern \"Rust\" { .. }`; a Rust function may call others",
        );
    }
    for item in block.items {
        match item {
            ForeignItem::Fn(item) => {
                let name = item.sig.ident.clone();
                match read_function(item, diagnostics) {
                    Some(function) => module.externals.push(function),
                    None => module.mistaken.push(Mistaken::External(name)),
                }
            }
            other => diagnostics.error_with_help(
                SourceSpan::of(&other),
                "unsupported item in an `extern` block",
                "it holds functions: `fn flux(g: Vector, k: Scalar) -> Vector;`",
            ),
        }
    }
}

fn read_function(item: ForeignItemFn, diagnostics: &mut Diagnostics) -> Option<External> {
    let (places, others): (Vec<_>, Vec<_>) =
        item.attrs.iter().partition(|attribute| attribute.path().is_ident("at"));
    others.into_iter().for_each(|one| attributes::check_inside(one, diagnostics));
    if let Some(second) = places.get(1) {
        let message = format!("`{}` is found in one place", item.sig.ident);
        diagnostics.error_with_help(SourceSpan::of(second), message, "leave one `#[at(..)]`");
    }
    attributes::check_inside(&item.sig, diagnostics);
    let signature = &item.sig;
    let plain = super::is_plain(&signature.generics)
        && item.modifiers.defaultness.is_none()
        && signature.constness.is_none()
        && signature.asyncness.is_none()
        && signature.variadic.is_none();
    if !plain {
        diagnostics.error_with_help(
            SourceSpan::of(signature),
            format!("unsupported signature of `{}`: here it has no generics or qualifiers", signature.ident),
            "the function itself is generic over `R: Real` (and the dimension); here stand its shapes",
        );
        return None;
    }
    let path = read_path(&item, diagnostics)?;
    let arguments: Vec<_> = signature.inputs.iter().map(|input| read_shape(input, diagnostics)).collect();
    let arguments = arguments.into_iter().collect::<Option<Vec<_>>>();
    let (output, span) = match &signature.output {
        ReturnType::Type(_, ty) => (declared_type::rank(ty, diagnostics), SourceSpan::of(ty)),
        ReturnType::Default => (Err(Unread::Unknown), SourceSpan::of(&signature.ident)),
    };
    if let Err(Unread::Unknown) = output {
        diagnostics.error_with_help(
            span,
            format!("`{}` does not say what it gives", signature.ident),
            "the return type of a function written in Rust is `Scalar`, `Vector` or `Tensor`",
        );
    }
    let output_span = signature.output.span();
    Some(External {
        name: signature.ident.clone(),
        path,
        arguments: arguments?,
        output: output.ok()?,
        output_span,
    })
}

fn read_shape(input: &FnArg, diagnostics: &mut Diagnostics) -> Option<super::Argument> {
    let argument = read_argument(input, diagnostics)?;
    if argument.role != ArgumentRole::Plain {
        diagnostics.error_with_help(
            SourceSpan::of(input),
            "a function written in Rust takes values, not roles",
            format!("write `{}: Scalar`, `Vector` or `Tensor`", argument.name),
        );
        return None;
    }
    Some(argument)
}

/// `super::name`, or what `#[at(path)]` says: as seen from the module, or from its place.
fn read_path(item: &ForeignItemFn, diagnostics: &mut Diagnostics) -> Option<TokenStream> {
    let name = &item.sig.ident;
    let Some(attribute) = item.attrs.iter().find(|attribute| attribute.path().is_ident("at")) else {
        return Some(quote_spanned! { name.span() => super::#name });
    };
    let Ok(path) = attribute.parse_args::<Path>() else {
        diagnostics.error_with_help(
            SourceSpan::of(attribute),
            "`#[at(..)]` takes the path of the function",
            format!("write `#[at(crate::laws::{name})]`"),
        );
        return None;
    };
    let first = path.segments.first().map(|segment| segment.ident.to_string()).unwrap_or_default();
    let rooted = path.leading_colon.is_some() || matches!(first.as_str(), "crate" | "super" | "self");
    Some(if rooted {
        path.to_token_stream()
    } else {
        quote_spanned! { name.span() => super::#path }
    })
}
