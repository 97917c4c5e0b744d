//! The data struct; where members have defaults, the struct `Required` of the others, and how the one is made of the other.

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};

use super::derived;
use crate::parse::syntax::*;
use crate::reuse::import::imported_path;
use crate::sorted::SortedSet;

/// Writes the struct; members that have a mistake are there, too.
pub fn emit_data(data: &Data, module: &Module) -> TokenStream {
    let Data { attributes, visibility, name, .. } = data;
    if let Some(path) = imported_path(attributes) {
        return quote! { #[allow(unused_imports)] #visibility use #path as #name; };
    }
    // A name declared twice has been reported, and so has the one that the base's member has.
    let mut taken: SortedSet<String> = data.base.iter().map(|_| Data::BASE.to_string()).collect();
    let unread = module.mistaken.iter().filter_map(|mistaken| match mistaken {
        Mistaken::Member(member) if member.depth == 0 => Some(member),
        _ => None,
    });
    let members: Vec<&Member> =
        data.own().chain(unread).filter(|member| taken.insert(member.name.to_string())).collect();
    let base = data.base.as_ref().map(|path| {
        let base = format_ident!("{}", Data::BASE);
        quote! {
            /// The data that these extend.
            pub #base: #path<D>,
        }
    });
    // The name may be declared, which has been reported.
    let functions = module.functions.iter().map(|function| &function.name);
    let mut names = functions.chain(module.regions.iter().map(|region| &region.name)).chain([name]);
    let emits_required = data.has_defaults() && names.all(|name| name != Data::REQUIRED);
    let required = emits_required.then(|| emit_required(data, &base, &members));
    let members = members.into_iter().map(emit_member);
    let derived = derived(attributes);
    quote! {
        #(#attributes)*
        #derived
        #visibility struct #name<const D: ::core::primitive::usize> {
            #base
            #(#members),*
        }
        #required
    }
}

/// Members without a default as the struct `Required`, and the data that are made of it.
fn emit_required(data: &Data, base: &Option<TokenStream>, members: &[&Member]) -> TokenStream {
    let Data { visibility, name, .. } = data;
    let required = format_ident!("{}", Data::REQUIRED);
    // A name of the function's own, which no member can hide.
    let own = Ident::new("required", Span::mixed_site());
    let text = format!(
        "What `{name}` needs, whatever its other members are: `{name} {{ other: value, ..{required} {{ .. }}.into() }}`."
    );
    let needed = members.iter().filter(|member| member.default.is_none()).map(|member| emit_member(member));
    let base_value = base.as_ref().map(|_| {
        let base = format_ident!("{}", Data::BASE);
        quote! { #base: #own.#base, }
    });
    let values = members.iter().map(|member| {
        let Member { name, kind, rank, default, .. } = member;
        match default {
            None => quote! { #name: #own.#name },
            Some(default) => {
                let value = rank.extents().iter().rev().fold(quote! { #default }, |entry, extent| {
                    let extent = emit_extent(*extent);
                    quote! { [#entry; #extent] }
                });
                match kind {
                    MemberKind::Given | MemberKind::Carried => {
                        quote! { #name: contract::Given::constant(#value) }
                    }
                    _ => quote! { #name: #value },
                }
            }
        }
    });
    quote! {
        #[doc = #text]
        #[derive(::core::clone::Clone, ::core::fmt::Debug)]
        #visibility struct #required<const D: ::core::primitive::usize> {
            #base
            #(#needed),*
        }
        impl<const D: ::core::primitive::usize> ::core::convert::From<#required<D>> for #name<D> {
            fn from(#own: #required<D>) -> Self {
                #name { #base_value #(#values),* }
            }
        }
    }
}

/// The member, as it is reached from the data struct: `base.base.lambda`.
pub fn way(member: &Member) -> TokenStream {
    let base = format_ident!("{}", Data::BASE);
    let bases = std::iter::repeat_n(base, member.depth);
    let name = &member.name;
    quote! { #(#bases.)* #name }
}

fn emit_member(member: &Member) -> TokenStream {
    let Member { attributes, name, kind, rank, default, .. } = member;
    let value = value_type(*rank);
    let ty = match kind {
        MemberKind::Param => value,
        MemberKind::Given | MemberKind::Carried => quote! { contract::Given<#value, D> },
        MemberKind::History => quote! { contract::History<#value, D> },
        MemberKind::Table => quote! { contract::Table },
    };
    let default = default.map(|value| {
        let text = format!("By default {value}.");
        quote! {
            ///
            #[doc = #text]
        }
    });
    quote! { #(#attributes)* #default pub #name: #ty }
}

/// `[[f64; D]; 2]` for a matrix of two rows.
fn value_type(rank: Rank) -> TokenStream {
    rank.extents().iter().rev().fold(quote! { ::core::primitive::f64 }, |entry, extent| {
        let extent = emit_extent(*extent);
        quote! { [#entry; #extent] }
    })
}

fn emit_extent(extent: Extent) -> TokenStream {
    match extent {
        Extent::Dimension => quote! { D },
        Extent::Fixed(number) => quote! { #number },
    }
}
