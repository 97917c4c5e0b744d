//! The text that a module's carrier holds: the module as Rust, without what an importing module cannot need. Written by
//! [`write`], read by [`Payload::read`].
//!
//! ```text
//! #[identity("elasticity", "a1b2c3d4")]
//! mod elasticity {
//!     struct Data { lambda: Param, mu: Param }
//!     #[origin("`stress` in contact/src/operators/materials.rs:47")]
//!     pub fn stress(w: Vector) -> Tensor { .. }
//!     #[origin(..)]
//!     fn strain__a9b8c7d6(w: Vector) -> Tensor { .. }      imported by this module from another
//!     pub use strain__a9b8c7d6 as strain;                  and offered by it under this name
//! }
//! ```

use std::hash::{DefaultHasher, Hash, Hasher};

use proc_macro2::{Delimiter, Group, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::{Attribute, Item, ItemFn, ItemMod, Visibility};

use crate::parse::attributes::is_marker;
use crate::parse::inclusion::{is_extends, is_includes};
use crate::parse::raw;
use crate::sorted::{SortedMap, SortedSet};

use super::names::Imported;

/// A module's text, and the number that tells it from others of its name.
pub struct Text {
    pub identity: String,
    pub text: String,
}

/// Writes the text of a module with what it imported. `broken`: it has mistakes, which have been reported.
pub fn write(item: &ItemMod, imported: &[Imported], broken: bool) -> Text {
    let name = item.ident.to_string();
    let mut content = TokenStream::new();
    let known: SortedMap<String, String> =
        imported.iter().map(|one| (one.local.to_string(), one.canonical.clone())).collect();
    for item in item.content.iter().flat_map(|(_, items)| items) {
        match item {
            Item::Struct(item) => {
                let mut item = item.clone();
                item.attrs.retain(|attribute| {
                    is_marker(attribute)
                        || attribute.path().is_ident("doc")
                        || is_extends(attribute)
                        || is_includes(attribute)
                });
                if !matches!(item.vis, Visibility::Public(_)) {
                    item.vis = Visibility::Inherited;
                }
                for field in &mut item.fields {
                    // What a member is called in formulas, what is said of it there, and its value for who includes it.
                    field.attrs.retain(|attribute| {
                        ["doc", "default"].iter().any(|kept| attribute.path().is_ident(kept))
                    });
                    field.vis = Visibility::Inherited;
                }
                content.extend(item.into_token_stream());
            }
            Item::Fn(item) => content.extend(function(item, &origin(item), &known)),
            Item::ForeignMod(item) => content.extend(item.into_token_stream()),
            _ => {}
        }
    }
    let mut written = SortedSet::new();
    for one in imported {
        for (canonical, carried) in &one.functions {
            if written.insert(canonical.clone()) {
                content.extend(carried.to_token_stream());
            }
        }
        if !matches!(one.visibility, Visibility::Inherited) {
            let canonical = raw::name(&one.canonical, Span::call_site());
            let local = &one.local;
            content.extend(quote! { pub use #canonical as #local; });
        }
    }
    let mut hasher = DefaultHasher::new();
    // The span tells apart equal modules that a `macro_rules!` wrote twice.
    (&name, content.to_string(), format!("{:?}", item.ident.span())).hash(&mut hasher);
    let identity = format!("{:016x}", hasher.finish());
    let module = &item.ident;
    let broken = broken.then(|| quote! { #[broken] });
    let text = quote! { #[identity(#name, #identity)] #broken mod #module { #content } }.to_string();
    Text { identity, text }
}

/// A function with its documentation, its place, and its calls of imported functions by their canonical names.
fn function(item: &ItemFn, origin: &str, known: &SortedMap<String, String>) -> TokenStream {
    let docs = item.attrs.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let public = !matches!(item.vis, Visibility::Inherited);
    // `#[doc(alias = "σ")]` is the function's sign in formulas, which those of an importing module show, too.
    let docs = docs.filter(|doc| public || matches!(doc.meta, syn::Meta::List(_)));
    let visibility = public.then(|| quote! { pub });
    let signature = &item.sig;
    let body = rename_calls(item.block.to_token_stream(), known);
    quote! { #(#docs)* #[origin(#origin)] #visibility #signature #body }
}

/// "`stress` in contact/src/operators/materials.rs:47": spans do not travel, so the place is given in words.
fn origin(item: &ItemFn) -> String {
    let name = &item.sig.ident;
    match file_and_line(name.span()) {
        Some((file, line)) => format!("`{name}` in {file}:{line}"),
        None => format!("`{name}`"),
    }
}

/// `None` outside of rustc, where spans have no file.
fn file_and_line(span: Span) -> Option<(String, usize)> {
    proc_macro::is_available().then(|| {
        let span = span.unwrap();
        (span.file(), span.line())
    })
}

/// Renames what is called: in the language, a name before parentheses is a call and nothing else.
pub fn rename_calls(tokens: TokenStream, names: &SortedMap<String, String>) -> TokenStream {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let is_call = |index: usize| matches!(tokens.get(index + 1), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
    let change = |(index, token): (usize, &TokenTree)| match token {
        TokenTree::Ident(name) if is_call(index) => match names.get(&name.to_string()) {
            Some(other) => TokenTree::Ident(raw::name(other, name.span())),
            None => token.clone(),
        },
        TokenTree::Group(group) => {
            let mut changed = Group::new(group.delimiter(), rename_calls(group.stream(), names));
            changed.set_span(group.span());
            TokenTree::Group(changed)
        }
        _ => token.clone(),
    };
    tokens.iter().enumerate().map(change).collect()
}

/// A text, read.
pub struct Payload {
    pub identity: String,
    pub broken: bool,
    pub item: ItemMod,
}

impl Payload {
    /// Reads what [`write`] wrote; all its tokens get the span of the import. `None`: it is not such a text.
    pub fn read(text: &str, span: Span) -> Option<Self> {
        let tokens = at(text.parse().ok()?, span);
        let item: ItemMod = syn::parse2(tokens).ok()?;
        let identity = item.attrs.iter().find(|attribute| attribute.path().is_ident("identity"))?;
        let syn::Meta::List(identity) = &identity.meta else { return None };
        let identity = string(identity.tokens.clone().into_iter().nth(2)?)?;
        let broken = item.attrs.iter().any(|attribute| attribute.path().is_ident("broken"));
        Some(Payload { identity, broken, item })
    }

    pub fn functions(&self) -> impl Iterator<Item = &ItemFn> {
        self.items().filter_map(|item| match item {
            Item::Fn(item) => Some(item),
            _ => None,
        })
    }

    pub fn items(&self) -> impl Iterator<Item = &Item> {
        self.item.content.iter().flat_map(|(_, items)| items)
    }
}

/// The text of a function's `#[origin(..)]`.
pub fn origin_of(attributes: &[Attribute]) -> Option<String> {
    let found = attributes.iter().find(|attribute| attribute.path().is_ident("origin"))?;
    let syn::Meta::List(list) = &found.meta else { return None };
    string(list.tokens.clone().into_iter().next()?)
}

/// The value of a string literal.
pub fn string(token: TokenTree) -> Option<String> {
    syn::parse2::<syn::LitStr>(token.into()).ok().map(|text| text.value())
}

/// The same tokens, all at one place.
fn at(tokens: TokenStream, span: Span) -> TokenStream {
    let change = |token: TokenTree| match token {
        TokenTree::Group(group) => {
            let mut changed = Group::new(group.delimiter(), at(group.stream(), span));
            changed.set_span(span);
            TokenTree::Group(changed)
        }
        mut other => {
            other.set_span(span);
            other
        }
    };
    tokens.into_iter().map(change).collect()
}
