//! Marks of included data: `#[includes(path, ..)]` before a data struct, and those that [`crate::reuse`] leaves where the texts have
//! arrived, `#[included(path)]` before a member and `#[first_included(..)]` before the struct.

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Attribute, Ident, Meta, Path};

use crate::diagnostics::{Diagnostics, SourceSpan};

/// Is it `#[includes(..)]`?
pub fn is_includes(attribute: &Attribute) -> bool {
    attribute.path().is_ident("includes")
}

/// Is it `#[extends(..)]`, which the language had once?
pub fn is_extends(attribute: &Attribute) -> bool {
    attribute.path().is_ident("extends")
}

/// Did the text of an included struct not arrive, so that members are missing? It has been reported.
pub fn is_incomplete(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| is_includes(attribute) || is_extends(attribute))
}

/// The path of the data from which a member came. `None` for a member that the struct declares itself.
pub fn included_from(attributes: &[Attribute]) -> Option<String> {
    let found = attributes.iter().find(|attribute| attribute.path().is_ident("included"))?;
    match &found.meta {
        Meta::List(list) => Some(list.tokens.to_string().replace(' ', "")),
        _ => Some(String::new()),
    }
}

/// A member's attributes without the one that says from where it came.
pub fn of_member(attributes: Vec<Attribute>) -> Vec<Attribute> {
    attributes.into_iter().filter(|attribute| !attribute.path().is_ident("included")).collect()
}

/// The first struct that a data struct includes, if it is public.
pub struct FirstIncluded {
    /// Its path from inside the module.
    pub path: TokenStream,
    /// The names of its members, without those that the including struct declares itself.
    pub members: Vec<String>,
}

impl FirstIncluded {
    /// `#[first_included((path) name name ..)]`.
    pub fn attribute(path: &TokenStream, members: &[&Ident]) -> Attribute {
        syn::parse_quote! { #[first_included((#path) #(#members)*)] }
    }

    fn of(attribute: &Attribute) -> Option<Self> {
        let Meta::List(list) = &attribute.meta else { return None };
        let mut tokens = list.tokens.clone().into_iter();
        let Some(TokenTree::Group(path)) = tokens.next() else { return None };
        let path = syn::parse2::<Path>(path.stream()).ok()?.into_token_stream();
        Some(FirstIncluded { path, members: tokens.map(|name| name.to_string()).collect() })
    }
}

/// The attributes of a data struct that go along with it.
pub struct OfData {
    pub kept: Vec<Attribute>,
    pub first: Option<FirstIncluded>,
    /// Members are missing, which has been reported.
    pub incomplete: bool,
}

/// Reads the attributes of a data struct.
pub fn of_data(attributes: Vec<Attribute>) -> OfData {
    let incomplete = is_incomplete(&attributes);
    let first = attributes.iter().find(|attribute| is_first(attribute)).and_then(FirstIncluded::of);
    let mark = |attribute: &Attribute| is_includes(attribute) || is_extends(attribute) || is_first(attribute);
    let kept = attributes.into_iter().filter(|attribute| !mark(attribute)).collect();
    OfData { kept, first: first.filter(|_| !incomplete), incomplete }
}

/// Has the first included struct arrived?
pub fn is_first(attribute: &Attribute) -> bool {
    attribute.path().is_ident("first_included")
}

/// A region's attributes; it has no data that could include others.
pub fn of_region(name: &Ident, attributes: Vec<Attribute>, diagnostics: &mut Diagnostics) -> Vec<Attribute> {
    let of_data = |attribute: &Attribute| is_includes(attribute) || is_extends(attribute);
    let (of_data, others): (Vec<_>, Vec<_>) = attributes.into_iter().partition(of_data);
    if let Some(attribute) = of_data.first() {
        diagnostics.error_with_help(
            SourceSpan::of(attribute),
            format!("the region `{name}` has no data to include"),
            "`#[includes(..)]` stands before a struct with members: `pub struct Data { }`",
        );
    }
    others
}
