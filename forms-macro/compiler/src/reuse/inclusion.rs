//! `#[includes(path::Data, other::Data)]` before the data struct: members that other modules' data declare, as its own.
//!
//! Their texts arrive as those of imports do. What the struct declares itself, or has from its base, is not taken in again, so
//! that a material that varies declares `lambda: Given<Scalar>` where the included data have a `Param`. A path that has
//! arrived leaves the attribute; what stays there did not arrive, and then any name may be one of its members.

use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::{Attribute, Field, Fields, Item, ItemStruct, Path, Token};

use super::extension::{self, DataPath};
use super::payload::Payload;
use super::uses::{Asked, Import};
use crate::diagnostics::{Diagnostics, SourceSpan};

/// Is it `#[includes(..)]`?
pub fn is_includes(attribute: &Attribute) -> bool {
    attribute.path().is_ident("includes")
}

/// The imports that a data struct's `#[includes(path, ..)]` asks for.
pub fn read(item: &ItemStruct, imports: &mut Vec<Import>, diagnostics: &mut Diagnostics) {
    if !matches!(item.fields, Fields::Named(_)) {
        return;
    }
    for attribute in item.attrs.iter().filter(|attribute| is_includes(attribute)) {
        let paths = paths(attribute).unwrap_or_default();
        let found: Vec<Option<DataPath>> = paths.iter().map(DataPath::of).collect();
        if found.is_empty() || found.iter().any(Option::is_none) {
            diagnostics.error_with_help(
                SourceSpan::of(attribute),
                "`#[includes(..)]` takes paths of other forms modules' data",
                "write `#[includes(super::module::Data, super::other::Data)]`",
            );
        }
        let imported = |path: DataPath| path.import(item, Asked::Members);
        imports.extend(found.into_iter().flatten().map(imported));
    }
}

fn paths(attribute: &Attribute) -> Option<Vec<Path>> {
    let paths = attribute.parse_args_with(Punctuated::<Path, Token![,]>::parse_terminated).ok()?;
    Some(paths.into_iter().collect())
}

/// Puts the members of the included data among those of the struct: after others that came, before its own.
pub fn add(items: &mut [Item], import: &Import, payload: &Payload, diagnostics: &mut Diagnostics) {
    let Some(included) = extension::data(import, payload, diagnostics) else { return };
    let including = items.iter_mut().find_map(|item| match item {
        Item::Struct(item) if item.attrs.iter().any(is_includes) => Some(item),
        _ => None,
    });
    let Some(ItemStruct { attrs, fields: Fields::Named(fields), ident, .. }) = including else { return };
    let mut own: Vec<Field> = std::mem::take(&mut fields.named).into_iter().collect();
    let mut here: Vec<Field> = own.extract_if(.., |field| came(field)).collect();
    for member in &included.fields {
        if own.iter().any(|declared| declared.ident == member.ident) {
            continue;
        }
        match here.iter().find(|known| known.ident == member.ident) {
            Some(known) if extension::depth(&known.attrs) > 0 || likeness(known) == likeness(member) => {}
            Some(_) => {
                let name = member.ident.to_token_stream();
                diagnostics.error_with_help(
                    SourceSpan::of(&import.name),
                    format!("`{name}` is declared in two ways by what `{ident}` includes"),
                    format!("declare `{name}` in `{ident}` itself as what it shall be here"),
                );
            }
            None => {
                let mut member = member.clone();
                member.attrs = extension::of_member(member.attrs);
                member.attrs.push(syn::parse_quote! { #[included] });
                here.push(member);
            }
        }
    }
    fields.named = here.into_iter().chain(own).collect();
    // Where a base of theirs is not known, members are missing here, too.
    if !included.attrs.iter().any(|attribute| is_includes(attribute) || extension::is_extends(attribute)) {
        strike_out(attrs, import);
    }
}

/// Did the member come from another module's data?
fn came(field: &Field) -> bool {
    field
        .attrs
        .iter()
        .any(|attribute| ["inherited", "included"].iter().any(|word| attribute.path().is_ident(word)))
}

/// Type and default of a member, which two declarations of it must share.
fn likeness(field: &Field) -> (String, Option<String>) {
    let default = field.attrs.iter().find(|attribute| attribute.path().is_ident("default"));
    (
        field.ty.to_token_stream().to_string(),
        default.map(|default| default.meta.to_token_stream().to_string()),
    )
}

/// Takes the import's path out of the attributes.
fn strike_out(attributes: &mut Vec<Attribute>, import: &Import) {
    let struck = import.path.to_string();
    attributes.retain_mut(|attribute| {
        if !is_includes(attribute) {
            return true;
        }
        let left: Vec<Path> = paths(attribute).unwrap_or_default();
        let left: Vec<Path> =
            left.into_iter().filter(|path| path.to_token_stream().to_string() != struck).collect();
        *attribute = syn::parse_quote! { #[includes(#(#left),*)] };
        !left.is_empty()
    });
}
