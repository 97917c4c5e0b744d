//! A module's text → the hidden macro that carries it, under the name of each function of the module.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};
use syn::{Item, ItemMod};

use super::import::imported_path;
use super::names::Imported;
use super::payload::Text;

/// The carrier and its names. What is exported is at the crate's root whatever module it is written in, so its name holds
/// the module's identity. It is re-exported from where it is written by its plain name: a path to a crate's root would meet
/// rustc's refusal of `macro_export` inside an expansion.
///
/// Regions and the data struct have the name, too, for they can be imported; and private functions, so that their import
/// meets a message of ours.
pub fn write(item: &ItemMod, imported: &[Imported], text: &Text) -> TokenStream {
    let Text { identity, text } = text;
    let carrier = format_ident!("__forms_{}_{}", syn::ext::IdentExt::unraw(&item.ident), identity);
    let text = Literal::string(text);
    let mut names: Vec<Ident> = Vec::new();
    let mut name = |name: &Ident| {
        // The function's own span: an editor goes from the import to the function.
        if !names.contains(name) {
            names.push(name.clone());
        }
    };
    for item in item.content.iter().flat_map(|(_, items)| items) {
        match item {
            Item::Fn(item) => name(&item.sig.ident),
            // The name of an imported declaration comes with its import.
            Item::Struct(item) if imported_path(&item.attrs).is_none() => name(&item.ident),
            _ => {}
        }
    }
    for one in imported {
        if !matches!(one.visibility, syn::Visibility::Inherited) {
            name(&one.local);
        }
    }
    let (resume, state) = (Ident::new("resume", Span::call_site()), Ident::new("state", Span::call_site()));
    quote! {
        #[doc(hidden)]
        #[allow(non_local_definitions, unused_macros)]
        #[macro_export]
        macro_rules! #carrier {
            ([$($#resume:tt)*] $($#state:tt)*) => { $($#resume)* ! { #text $($#state)* } };
        }
        #(
            #[doc(hidden)]
            #[allow(unused_imports)]
            pub use #carrier as #names;
        )*
    }
}
