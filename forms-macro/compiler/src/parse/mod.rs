//! Stage 1: Rust tokens (`syn::ItemMod`) → [`syntax::Module`]. Knows Rust's grammar and no mathematics.

pub mod attributes;
pub mod controls;
pub mod declared_type;
mod expression;
mod external;
pub mod inclusion;
mod member;
pub mod nesting;
pub mod raw;
pub mod syntax;
pub mod whole_number;

use syn::{Fields, FnArg, Generics, Item, ItemFn, ItemMod, ItemStruct, Pat, PatIdent, ReturnType, Type};

use crate::diagnostics::{Diagnostics, SourceSpan};
use declared_type::Unread;
use inclusion::{OfData, of_data, of_region};
use syntax::*;

/// Reads a module; what cannot be read is reported and left out.
pub fn parse(item: ItemMod, diagnostics: &mut Diagnostics) -> Module {
    let mut module = Module {
        name: item.ident,
        data: None,
        regions: Vec::new(),
        functions: Vec::new(),
        externals: Vec::new(),
        mistaken: Vec::new(),
    };
    if let Some(unsafety) = item.unsafety {
        diagnostics.error(SourceSpan::of(&unsafety), "a forms module is not `unsafe`");
    }
    let Some((_, items)) = item.content else {
        diagnostics.error_with_help(
            SourceSpan::of(&module.name),
            "`#[forms]` needs the module's body",
            format!("write `mod {} {{ .. }}` with the forms inside the braces", module.name),
        );
        return module;
    };
    for item in items {
        match item {
            Item::Struct(item) => read_struct(item, &mut module, diagnostics),
            Item::Fn(item) => {
                let placeholder = placeholder(&item);
                match read_function(item, diagnostics) {
                    Some(function) => module.functions.push(function),
                    None => module.mistaken.push(placeholder),
                }
            }
            Item::ForeignMod(item) => external::read(item, &mut module, diagnostics),
            // Read by `reuse::uses`.
            Item::Use(item) => item.attrs.iter().for_each(|one| attributes::check_inside(one, diagnostics)),
            other => diagnostics.error_with_help(
                SourceSpan::of(&other),
                "unsupported item in a forms module",
                "a forms module holds one data struct, regions (`#[cells]`, `#[facets]`, `#[interior_facets]`), and functions",
            ),
        }
    }
    module
}

fn read_struct(item: ItemStruct, module: &mut Module, diagnostics: &mut Diagnostics) {
    let (marked, others): (Vec<_>, Vec<_>) = item.attrs.into_iter().partition(attributes::is_marker);
    let markers: Vec<(Entity, RegionRule)> =
        marked.iter().filter_map(|attribute| attributes::marker(attribute, diagnostics)).collect();
    let attributes = attributes::of_declaration(others, diagnostics);
    // After a mistake the region exists all the same.
    let (entity, rule) = markers.first().copied().unwrap_or((Entity::Cells, RegionRule::OfBackend));
    if !is_plain(&item.generics) {
        diagnostics.error_with_help(
            SourceSpan::of(&item.generics),
            format!("`{}` cannot be generic", item.ident),
            "the dimension is generic by itself; ranks are `Scalar`, `Vector` and `Tensor`",
        );
    }
    match item.fields {
        Fields::Unit => {
            let attributes = of_region(&item.ident, attributes, diagnostics);
            if markers.len() != 1 {
                let (message, help) = match markers.is_empty() {
                    true => (
                        format!("the region `{}` does not say what it consists of", item.ident),
                        "write `#[cells]`, `#[facets]`, `#[interior_facets]`, `#[pairs]` or `#[interface]` before the struct",
                    ),
                    false => (
                        format!("the region `{}` has {} markers", item.ident, markers.len()),
                        "a region consists of one kind: keep one of `#[cells]`, `#[facets]`, `#[interior_facets]`, `#[pairs]`, `#[interface]`",
                    ),
                };
                diagnostics.error_with_help(SourceSpan::of(&item.ident), message, help);
                module.mistaken.push(Mistaken::Region(item.ident.clone()));
            }
            let (visibility, name) = (item.vis, item.ident);
            module.regions.push(Region { attributes, visibility, name, entity, rule });
        }
        Fields::Named(fields) if module.data.is_none() => {
            if let Some(marker) = marked.first() {
                diagnostics.error_with_help(
                    SourceSpan::of(marker),
                    format!("`{}` has members, and a region has none", item.ident),
                    "leave the marker out, or write a region as `pub struct Omega;`",
                );
            }
            let OfData { kept: attributes, first, incomplete } = of_data(attributes);
            let mut members = Vec::new();
            for field in &fields.named {
                match (member::read(field, diagnostics), &field.ident) {
                    (Some(member), _) => members.push(member),
                    (None, Some(name)) => {
                        module.mistaken.push(Mistaken::Member(member::likely(name, field)));
                    }
                    (None, None) => {}
                }
            }
            let (visibility, name) = (item.vis, item.ident);
            module.data = Some(Data { attributes, visibility, name, first, incomplete, members });
        }
        Fields::Named(_) => diagnostics.error_with_help(
            SourceSpan::of(&item.ident),
            "a forms module has one data struct",
            "move these members into the first one",
        ),
        Fields::Unnamed(_) => diagnostics.error_with_help(
            SourceSpan::of(&item.ident),
            "a data struct needs named members",
            "write `pub struct Data { lambda: Param, .. }`",
        ),
    }
}

/// The known part of a function, should its signature have a mistake.
fn placeholder(item: &ItemFn) -> Mistaken {
    let known = item.sig.inputs.iter().filter(|input| match input {
        FnArg::Typed(input) => {
            !matches!(declared_type::word(&input.ty), Some((outer, _)) if outer == "Unknown" || outer == "Test")
        }
        FnArg::Receiver(_) => false,
    });
    let output = match &item.sig.output {
        // What is wrong in it has been reported.
        ReturnType::Type(_, ty) => read_output(ty, &mut Diagnostics::default()).unwrap_or(Output::Form),
        ReturnType::Default => Output::Form,
    };
    Mistaken::Function {
        visibility: item.vis.clone(),
        name: item.sig.ident.clone(),
        arguments: known.count(),
        output,
    }
}

/// Neither parameters nor conditions on them.
fn is_plain(generics: &Generics) -> bool {
    generics.params.is_empty() && generics.where_clause.is_none()
}

/// Reads a function. `None` after a report.
pub fn read_function(item: ItemFn, diagnostics: &mut Diagnostics) -> Option<Function> {
    let before = &item.sig;
    let plain = is_plain(&before.generics)
        && before.constness.is_none()
        && before.asyncness.is_none()
        && before.abi.is_none()
        && before.variadic.is_none()
        && item.modifiers.defaultness.is_none()
        && matches!(before.safety, syn::Safety::Default);
    if !plain {
        diagnostics.error_with_help(
            SourceSpan::of(&item.sig),
            format!(
                "unsupported signature of `{}`: a function of a weak form has no generics or qualifiers",
                before.ident
            ),
            "its arguments are `Scalar`, `Vector` or `Tensor`, in every dimension",
        );
        return None;
    }
    attributes::check_inside(&item.sig, diagnostics);
    attributes::check_inside(&item.block, diagnostics);
    let mut arguments = Vec::new();
    let mut complete = true;
    for input in &item.sig.inputs {
        match read_argument(input, diagnostics) {
            Some(argument) => arguments.push(argument),
            None => complete = false,
        }
    }
    let (output, span) = match &item.sig.output {
        ReturnType::Type(_, ty) => (read_output(ty, diagnostics), SourceSpan::of(ty)),
        ReturnType::Default => (Err(Unread::Unknown), SourceSpan::of(&item.sig.ident)),
    };
    let output = match output {
        Ok(output) => output,
        Err(Unread::Reported) => return None,
        Err(Unread::Unknown) => {
            diagnostics.error_with_help(
                span,
                format!("`{}` does not say what it gives", item.sig.ident),
                "the return type is one of `Scalar`, `Vector`, `Tensor`, `Form`, `Energy`, `Functional`",
            );
            return None;
        }
    };
    let body = expression::read_block(&item.block, diagnostics);
    complete.then_some(Function {
        attributes: attributes::of_declaration(item.attrs, diagnostics),
        visibility: item.vis,
        name: item.sig.ident,
        arguments,
        output,
        body,
        foreign: None,
    })
}

/// A name alone: not `mut`, `ref`, or one for a part of a pattern.
fn is_name(pattern: &PatIdent) -> bool {
    pattern.mutability.is_none() && pattern.by_ref.is_none() && pattern.subpat.is_none()
}

fn read_argument(input: &FnArg, diagnostics: &mut Diagnostics) -> Option<Argument> {
    let FnArg::Typed(input) = input else {
        diagnostics.error(SourceSpan::of(input), "unsupported argument: a form has no `self`");
        return None;
    };
    let pattern = match &*input.pat {
        Pat::Ident(pattern) if is_name(pattern) => pattern,
        other => {
            diagnostics.error(SourceSpan::of(other), "unsupported argument pattern: an argument is a name");
            return None;
        }
    };
    let role = match declared_type::word(&input.ty) {
        Some((word, Some(inner))) => match word.to_string().as_str() {
            "Unknown" => Some((ArgumentRole::Unknown, inner)),
            "Test" => Some((ArgumentRole::Test, inner)),
            "State" => Some((ArgumentRole::State, inner)),
            _ => None,
        },
        _ => None,
    };
    let (role, ty) = role.unwrap_or((ArgumentRole::Plain, &input.ty));
    let rank = match declared_type::rank(ty, diagnostics) {
        Ok(rank) => rank,
        Err(Unread::Reported) => return None,
        Err(Unread::Unknown) => {
            diagnostics.error_with_help(
                SourceSpan::of(&input.ty),
                format!("the argument `{}` has a type that is not known here", pattern.ident),
                "write `Scalar`, `Vector`, `Tensor`, or one of them in `Unknown<..>`, `Test<..>`, `State<..>`",
            );
            return None;
        }
    };
    Some(Argument { name: pattern.ident.clone(), role, rank })
}

fn read_output(ty: &Type, diagnostics: &mut Diagnostics) -> Result<Output, Unread> {
    match declared_type::word(ty) {
        Some((word, None)) if word == "Form" => Ok(Output::Form),
        Some((word, None)) if word == "Energy" => Ok(Output::Energy),
        Some((word, None)) if word == "Functional" => Ok(Output::Functional),
        _ => declared_type::rank(ty, diagnostics).map(Output::Value),
    }
}
