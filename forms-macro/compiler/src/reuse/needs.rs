//! Needs of imported functions: members of the data struct and regions, matched by name.
//!
//! An imported function reads the importing module's `lambda`. The member must be there, with the same rank; whether it is
//! constant (`Param`) or varies (`Given`) is the importing module's choice.

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Fields, ForeignItem, Item, ItemFn, ItemMod, Type};

use super::names::Import;
use super::payload::Payload;
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::attributes::is_marker;
use crate::parse::declared_type::{self, word};
use crate::parse::inclusion::is_incomplete;
use crate::parse::syntax::Rank;
use crate::sorted::{SortedMap, SortedSet};

/// Are the members and regions that the functions name declared here? Those that are not are reported at once.
pub fn check(
    import: &Import,
    payload: &Payload,
    functions: &SortedMap<String, ItemFn>,
    item: &ItemMod,
    diagnostics: &mut Diagnostics,
) -> bool {
    let mut names = SortedSet::new();
    for item in functions.values() {
        let typed = item.sig.inputs.iter().filter_map(|input| match input {
            syn::FnArg::Typed(input) => Some(input.pat.to_token_stream().to_string()),
            syn::FnArg::Receiver(_) => None,
        });
        free_names(item.block.to_token_stream(), typed.collect(), &mut names);
    }
    let (theirs, ours) = (Declarations::of(&payload.item), Declarations::of(item));
    let span = SourceSpan::of(&import.name);
    let (mut missing, mut complete) = (Vec::new(), true);
    for (name, ty) in theirs.members.iter().filter(|(name, _)| names.contains(name)) {
        match ours.members.iter().find(|(other, _)| other == name) {
            Some((_, own)) if rank(own) == rank(ty) && (own == "Table") == (ty == "Table") => {}
            Some((_, own)) => {
                let message = format!("`{}` reads `{name}` as `{ty}`, and here it is `{own}`", import.name);
                let help = format!("the ranks must agree: declare `{name}: {ty}`");
                diagnostics.error_with_help(span, message, help);
                complete = false;
            }
            None if ours.incomplete => complete = false,
            None => missing.push((name, ty)),
        }
    }
    for external in externals(&payload.item).filter(|name| names.contains(name)) {
        let message =
            format!("`{}` calls `{external}`, which is written in Rust and cannot be imported", import.name);
        let help = "import functions that do not call it, or take what it gives as an argument";
        diagnostics.error_with_help(span, message, help);
        complete = false;
    }
    if !missing.is_empty() {
        let list: Vec<String> = missing.iter().map(|(name, _)| format!("`{name}`")).collect();
        let lines: Vec<String> = missing.iter().map(|(name, ty)| format!("pub {name}: {ty}")).collect();
        let message =
            format!("`{}` reads {}, which the data of this module do not have", import.name, list.join(", "));
        let help = match &ours.data {
            Some(data) => {
                let added = format!("add `{}` to `{data}`", lines.join(", "));
                let path = import.path.to_string().replace(' ', "");
                match (path.rsplit_once("::"), &theirs.data) {
                    (Some((module, _)), Some(theirs)) => {
                        format!("{added}, or write `#[includes({module}::{theirs})]` before it")
                    }
                    _ => added,
                }
            }
            None => format!("declare `pub struct Data {{ {} }}`", lines.join(", ")),
        };
        diagnostics.error_with_help(span, message, help);
        complete = false;
    }
    for (name, marker) in theirs.regions.iter().filter(|(name, _)| names.contains(name)) {
        let message = match ours.regions.iter().find(|(other, _)| other == name) {
            Some((_, own)) if own == marker => continue,
            Some((_, own)) => format!(
                "`{}` integrates over `{name}` as `#[{marker}]`, and here it is `#[{own}]`",
                import.name
            ),
            None => format!("`{}` integrates over `{name}`, which this module does not declare", import.name),
        };
        diagnostics.error_with_help(span, message, format!("declare `#[{marker}] pub struct {name};`"));
        complete = false;
    }
    complete
}

/// The functions of a module's `extern` blocks.
fn externals(item: &ItemMod) -> impl Iterator<Item = String> {
    let blocks = item.content.iter().flat_map(|(_, items)| items).filter_map(|item| match item {
        Item::ForeignMod(block) => Some(&block.items),
        _ => None,
    });
    blocks.flatten().filter_map(|item| match item {
        ForeignItem::Fn(item) => Some(item.sig.ident.to_string()),
        _ => None,
    })
}

/// The declarations of a module besides its functions: names with the texts of their types and markers.
#[derive(Default)]
struct Declarations {
    data: Option<String>,
    /// Members of included data are not known, which has been reported.
    incomplete: bool,
    members: Vec<(String, String)>,
    regions: Vec<(String, String)>,
}

impl Declarations {
    fn of(item: &ItemMod) -> Self {
        let mut found = Declarations::default();
        for item in item.content.iter().flat_map(|(_, items)| items) {
            let Item::Struct(item) = item else { continue };
            match &item.fields {
                Fields::Named(fields) => {
                    found.data = Some(item.ident.to_string());
                    found.incomplete = is_incomplete(&item.attrs);
                    found.members.extend(fields.named.iter().filter_map(|field| {
                        let ty = field.ty.to_token_stream().to_string().replace(' ', "");
                        Some((field.ident.as_ref()?.to_string(), ty.replace(',', ", ")))
                    }));
                }
                _ => {
                    let marker = (item.attrs.iter().find(|attribute| is_marker(attribute)))
                        .map(|attribute| attribute.meta.to_token_stream().to_string().replace(' ', ""));
                    found.regions.extend(marker.map(|marker| (item.ident.to_string(), marker)));
                }
            }
        }
        found
    }
}

/// The rank in `Given<Vector>`; `Param` alone is a scalar. `None`: a mistake, which is reported in its place.
fn rank(ty: &str) -> Option<Rank> {
    let ty: Type = syn::parse_str(ty).ok()?;
    match word(&ty)? {
        (_, None) => Some(Rank::SCALAR),
        (_, Some(inner)) => declared_type::rank(inner, &mut Diagnostics::default()).ok(),
    }
}

/// The names that a body uses and does not bind; a `let` binds from its semicolon to the end of its block.
fn free_names(tokens: TokenStream, mut local: SortedSet<String>, found: &mut SortedSet<String>) {
    let mut bound: Option<String> = None;
    let mut after_let = false;
    for token in tokens {
        match token {
            TokenTree::Ident(name) if name == "let" => after_let = true,
            TokenTree::Ident(name) if after_let => {
                bound = Some(name.to_string());
                after_let = false;
            }
            TokenTree::Ident(name) => {
                let name = name.to_string();
                if !local.contains(&name) {
                    found.insert(name);
                }
            }
            TokenTree::Punct(punct) if punct.as_char() == ';' => local.extend(bound.take()),
            TokenTree::Group(group) => free_names(group.stream(), local.clone(), found),
            _ => {}
        }
    }
}
