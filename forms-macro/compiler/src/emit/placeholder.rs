//! Placeholders for functions with a mistake, so that the rest of the crate gets no further errors.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use crate::parse::syntax::*;

/// The constructor of a function that has a mistake: the numbers of regions and known fields are right, and the type of its
/// value, so that its calls are right.
pub fn placeholder(
    module: &Module,
    visibility: &syn::Visibility,
    name: &Ident,
    value: &Ident,
    [regions, fields]: [usize; 2],
) -> TokenStream {
    let data = module.data.as_ref().map(|data| {
        let ty = &data.name;
        quote! { _: &#ty<D>, }
    });
    let regions = (0..regions).map(|_| quote! { _: impl ::core::marker::Sized });
    let fields = (0..fields).map(|_| quote! { _: impl ::core::convert::Into<contract::Source<D>> });
    let others = regions.chain(fields);
    quote! {
        #visibility fn #name<const D: ::core::primitive::usize>(#data #(#others),*) -> contract::#value<D> {
            loop {}
        }
    }
}
