//! `#[extends(path::Data)]` before the data struct: the members of another module's data among the module's own.
//!
//! The base's text arrives as that of any import does. Its members join those of the struct with `#[inherited(depth)]`, which
//! says how many bases away they are declared, and `#[extends(path)]` becomes `#[extended(path)]`. Where the base did not
//! arrive the attribute stays: then any name may be one of the base's, and is no further mistake.

use quote::{ToTokens, quote};
use syn::{Attribute, Fields, Ident, Item, ItemStruct, LitInt, Meta, Path, Visibility};

use super::inclusion::is_includes;
use super::payload::Payload;
use super::uses::{Asked, Import};
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::syntax::{Data, Member};

/// Is it `#[extends(..)]`?
pub fn is_extends(attribute: &Attribute) -> bool {
    attribute.path().is_ident("extends")
}

/// The import that a data struct's `#[extends(path)]` asks for.
pub fn read(item: &ItemStruct, imports: &mut Vec<Import>, diagnostics: &mut Diagnostics) {
    if !matches!(item.fields, Fields::Named(_)) {
        return;
    }
    let mut attributes = item.attrs.iter().filter(|attribute| is_extends(attribute));
    let Some(attribute) = attributes.next() else { return };
    if let Some(second) = attributes.next() {
        diagnostics.error_with_help(
            SourceSpan::of(second),
            format!("`{}` extends two data structs", item.ident),
            "it may extend one, which may extend another",
        );
    }
    let path = match &attribute.meta {
        Meta::List(list) => list.parse_args_with(Path::parse_mod_style).ok(),
        _ => None,
    };
    match path.as_ref().and_then(DataPath::of) {
        Some(path) => imports.push(path.import(item, Asked::Base)),
        None => diagnostics.error_with_help(
            SourceSpan::of(attribute),
            "`#[extends(..)]` takes the path of another forms module's data",
            "write `#[extends(super::module::Data)]`",
        ),
    }
}

/// The path of another module's data struct: more than its name, which is none of Rust's words for modules.
pub struct DataPath<'a> {
    path: &'a Path,
    name: &'a Ident,
}

impl<'a> DataPath<'a> {
    /// `None` if it cannot be one.
    pub fn of(path: &'a Path) -> Option<Self> {
        let name = &path.segments.last().filter(|_| path.segments.len() > 1)?.ident;
        let keyword = ["self", "super", "crate"].iter().any(|keyword| name == keyword);
        (!keyword).then_some(DataPath { path, name })
    }

    /// The import that a data struct asks for by it.
    pub fn import(self, item: &ItemStruct, asked: Asked) -> Import {
        Import {
            path: self.path.to_token_stream(),
            name: self.name.clone(),
            local: item.ident.clone(),
            visibility: Visibility::Inherited,
            asked,
        }
    }
}

/// Puts the base's members before those of the struct that extends it.
pub fn add(items: &mut [Item], import: &Import, payload: &Payload, diagnostics: &mut Diagnostics) {
    let Some(base) = data(import, payload, diagnostics) else { return };
    let extending = items.iter_mut().find_map(|item| match item {
        Item::Struct(item) if item.attrs.iter().any(is_extends) => Some(item),
        _ => None,
    });
    let Some(ItemStruct { attrs, fields: Fields::Named(fields), .. }) = extending else { return };
    let inherited = base.fields.iter().cloned().map(|mut field| {
        let depth = depth(&field.attrs) + 1;
        field.attrs = of_member(field.attrs);
        let depth = LitInt::new(&depth.to_string(), import.name.span());
        field.attrs.push(syn::parse_quote! { #[inherited(#depth)] });
        field
    });
    fields.named = inherited.chain(std::mem::take(&mut fields.named)).collect();
    // Where the base's own base is not known, this one's is not either.
    if !base.attrs.iter().any(|attribute| is_extends(attribute) || is_includes(attribute)) {
        attrs.retain(|attribute| !is_extends(attribute));
    }
    let path = &import.path;
    attrs.push(syn::parse_quote! { #[extended(#path)] });
}

/// The data struct that an import names; what else it names is reported.
pub fn data<'a>(
    import: &Import,
    payload: &'a Payload,
    diagnostics: &mut Diagnostics,
) -> Option<&'a ItemStruct> {
    let done = match import.asked {
        Asked::Members => "included",
        _ => "extended",
    };
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
            format!("`{name}` is a region of the forms module `{module}`, and only data can be {done}")
        }
        None if payload.functions().any(|item| item.sig.ident == *name) => {
            format!("`{name}` is a function of the forms module `{module}`, and only data can be {done}")
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

/// Number of bases up to a member's declaration, from its `#[inherited(depth)]`.
pub fn depth(attributes: &[Attribute]) -> usize {
    let found = attributes.iter().find(|attribute| attribute.path().is_ident("inherited"));
    let depth = found.and_then(|attribute| attribute.parse_args::<LitInt>().ok());
    depth.and_then(|depth| depth.base10_parse().ok()).unwrap_or(0)
}

/// A member's attributes without those that say from where it came.
pub fn of_member(attributes: Vec<Attribute>) -> Vec<Attribute> {
    let told =
        |attribute: &Attribute| ["inherited", "included"].iter().any(|word| attribute.path().is_ident(word));
    attributes.into_iter().filter(|attribute| !told(attribute)).collect()
}

/// Base of a data struct.
pub struct Base {
    /// Path to the base from inside the module.
    pub path: Option<proc_macro2::TokenStream>,
    /// Members are missing, which has been reported.
    pub incomplete: bool,
}

impl Base {
    /// Does the member have the name of the base's data?
    pub fn hides(&self, member: &Member) -> bool {
        self.path.is_some() && member.depth == 0 && member.name == Data::BASE
    }
}

/// A data struct's attributes, and what they say of its base.
pub fn base(attributes: Vec<Attribute>) -> (Vec<Attribute>, Base) {
    let mut base = Base { path: None, incomplete: false };
    let mut others = Vec::new();
    for attribute in attributes {
        match &attribute.meta {
            _ if is_extends(&attribute) || is_includes(&attribute) => base.incomplete = true,
            Meta::List(list) if attribute.path().is_ident("extended") => {
                base.path = syn::parse2::<Path>(list.tokens.clone()).ok().map(|path| quote! { #path });
            }
            _ => others.push(attribute),
        }
    }
    (others, base)
}

/// A region's attributes; it has no data that could extend others.
pub fn of_region(name: &Ident, attributes: Vec<Attribute>, diagnostics: &mut Diagnostics) -> Vec<Attribute> {
    let of_data = |attribute: &Attribute| is_extends(attribute) || is_includes(attribute);
    let (of_data, others): (Vec<_>, Vec<_>) = attributes.into_iter().partition(of_data);
    if let Some(attribute) = of_data.first() {
        let word = if is_extends(attribute) { "extend" } else { "include" };
        diagnostics.error_with_help(
            SourceSpan::of(attribute),
            format!("the region `{name}` has no data to {word}"),
            format!("`#[{word}s(..)]` stands before a struct with members: `pub struct Data {{ }}`"),
        );
    }
    others
}
