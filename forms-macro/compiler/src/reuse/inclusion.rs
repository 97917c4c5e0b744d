//! `#[includes(path::Data, other::Data)]` before the data struct: members that other modules' data declare, as its own.
//!
//! Their texts arrive as those of imports do. What the struct declares itself is not taken in again, so that a material that varies
//! declares `lambda: Given<Scalar>` where the included data have a `Param`. A path that has arrived leaves the attribute; what stays
//! there did not arrive, and then any name may be one of its members.

use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::{Attribute, Field, Fields, Ident, Item, ItemStruct, Path, Token, Visibility};

use super::names::{Asked, Import};
use super::payload::Payload;
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::inclusion::{
    FirstIncluded, included_from, is_extends, is_first, is_includes, is_incomplete, of_member,
};

/// The imports that a data struct's `#[includes(path, ..)]` asks for.
pub fn read(item: &ItemStruct, imports: &mut Vec<Import>, diagnostics: &mut Diagnostics) {
    if !matches!(item.fields, Fields::Named(_)) {
        return;
    }
    for attribute in &item.attrs {
        if is_extends(attribute) {
            report_extends(attribute, diagnostics);
        }
        if !is_includes(attribute) {
            continue;
        }
        let paths = paths(attribute).unwrap_or_default();
        let found: Vec<Option<DataPath>> = paths.iter().map(DataPath::of).collect();
        if found.is_empty() || found.iter().any(Option::is_none) {
            diagnostics.error_with_help(
                SourceSpan::of(attribute),
                "`#[includes(..)]` takes paths of other forms modules' data",
                "write `#[includes(super::module::Data, super::other::Data)]`",
            );
        }
        imports.extend(found.into_iter().flatten().map(|path| path.import(item)));
    }
}

fn report_extends(attribute: &Attribute, diagnostics: &mut Diagnostics) {
    let path = paths(attribute).and_then(|paths| paths.into_iter().next());
    let path = path.map_or("super::module::Data".into(), |path| path.to_token_stream().to_string());
    diagnostics.error_with_help(
        SourceSpan::of(attribute),
        "a data struct includes another one, and has no `#[extends(..)]`",
        format!(
            "write `#[includes({})]`: its members become the struct's own, and `data_from(value)` takes them from a value of it",
            path.replace(' ', "")
        ),
    );
}

fn paths(attribute: &Attribute) -> Option<Vec<Path>> {
    let paths = attribute.parse_args_with(Punctuated::<Path, Token![,]>::parse_terminated).ok()?;
    Some(paths.into_iter().collect())
}

/// The path of another module's data struct: more than its name, which is none of Rust's words for modules.
struct DataPath<'a> {
    path: &'a Path,
    name: &'a Ident,
}

impl<'a> DataPath<'a> {
    /// `None` if it cannot be one.
    fn of(path: &'a Path) -> Option<Self> {
        let plain = path.segments.iter().all(|segment| segment.arguments.is_none());
        let name = &path.segments.last().filter(|_| plain && path.segments.len() > 1)?.ident;
        let keyword = ["self", "super", "crate"].iter().any(|keyword| name == keyword);
        (!keyword).then_some(DataPath { path, name })
    }

    /// The import that a data struct asks for by it.
    fn import(self, item: &ItemStruct) -> Import {
        Import {
            path: self.path.to_token_stream(),
            name: self.name.clone(),
            local: item.ident.clone(),
            visibility: Visibility::Inherited,
            asked: Asked::Members,
        }
    }
}

/// Puts the members of the included data among those of the struct: after others that came, before its own.
pub fn add(items: &mut [Item], import: &Import, payload: &Payload, diagnostics: &mut Diagnostics) {
    let Some(included) = data(import, payload, diagnostics) else { return };
    let including = items.iter_mut().find_map(|item| match item {
        Item::Struct(item) if item.attrs.iter().any(is_includes) => Some(item),
        _ => None,
    });
    let Some(ItemStruct { attrs, fields: Fields::Named(fields), ident, .. }) = including else { return };
    let mut own: Vec<Field> = std::mem::take(&mut fields.named).into_iter().collect();
    let mut here: Vec<Field> = own.extract_if(.., |field| included_from(&field.attrs).is_some()).collect();
    let mut taken = Vec::new();
    for member in &included.fields {
        if own.iter().any(|declared| declared.ident == member.ident) {
            continue;
        }
        taken.extend(&member.ident);
        match here.iter().find(|known| known.ident == member.ident) {
            Some(known) if likeness(known) == likeness(member) => {}
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
                member.attrs = of_member(member.attrs);
                let path = &import.path;
                member.attrs.push(syn::parse_quote! { #[included(#path)] });
                here.push(member);
            }
        }
    }
    // A struct that is not public may have no name here.
    if here.len() == taken.len() && !attrs.iter().any(is_first) && is_public(included) {
        attrs.push(FirstIncluded::attribute(&import.path, &taken));
    }
    fields.named = here.into_iter().chain(own).collect();
    // Where data that they include are not known, members are missing here, too.
    if !is_incomplete(&included.attrs) {
        strike_out(attrs, import);
    }
}

/// The data struct that an import names; what else it names is reported.
fn data<'a>(import: &Import, payload: &'a Payload, diagnostics: &mut Diagnostics) -> Option<&'a ItemStruct> {
    let (name, module) = (&import.name, &payload.item.ident);
    let structs = || {
        payload.items().filter_map(|item| match item {
            Item::Struct(item) => Some(item),
            _ => None,
        })
    };
    let named = structs().find(|item| item.ident == *name);
    if let Some(item) = named.filter(|item| matches!(item.fields, Fields::Named(_))) {
        return Some(item);
    }
    let message = match named {
        Some(_) => {
            format!("`{name}` is a region of the forms module `{module}`, and only data can be included")
        }
        None if payload.functions().any(|item| item.sig.ident == *name) => {
            format!("`{name}` is a function of the forms module `{module}`, and only data can be included")
        }
        None => format!("the forms module `{module}` has no data struct `{name}`"),
    };
    let help = match structs().find(|item| matches!(item.fields, Fields::Named(_))) {
        Some(item) => format!("its data struct is `{}`", item.ident),
        None => format!("`{module}` declares no data"),
    };
    diagnostics.error_with_help(SourceSpan::of(name), message, help);
    None
}

fn is_public(item: &ItemStruct) -> bool {
    matches!(item.vis, Visibility::Public(_))
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
