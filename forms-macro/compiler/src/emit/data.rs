//! The data struct, and next to it the structs that make it: `Required`, the members without a default, and `Rest`, those that
//! the first included data do not have.

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};

use super::derived;
use crate::parse::inclusion::FirstIncluded;
use crate::parse::syntax::*;
use crate::reuse::import::imported_path;
use crate::sorted::SortedSet;

/// Writes the structs; members that have a mistake are there, too.
pub fn emit_data(data: &Data, module: &Module) -> TokenStream {
    let Data { attributes, visibility, name, .. } = data;
    if let Some(path) = imported_path(attributes) {
        return quote! { #[allow(unused_imports)] #visibility use #path as #name; };
    }
    // A name declared twice has been reported.
    let mut taken: SortedSet<String> = SortedSet::new();
    let unread = module.mistaken.iter().filter_map(|mistaken| match mistaken {
        Mistaken::Member(member) => Some(member),
        _ => None,
    });
    let members: Vec<&Member> =
        data.members.iter().chain(unread).filter(|member| taken.insert(member.name.to_string())).collect();
    // The name may be declared, which has been reported.
    let emits = |emitted: &str| {
        let functions = module.functions.iter().map(|function| &function.name);
        let mut names = functions.chain(module.regions.iter().map(|region| &region.name)).chain([name]);
        data.emits(emitted) && names.all(|name| name != emitted)
    };
    let required = emits(Data::REQUIRED).then(|| emit_required(data, &members));
    let rest =
        data.first.as_ref().filter(|_| emits(Data::REST)).map(|first| emit_rest(data, first, &members));
    let members = members.into_iter().map(emit_member);
    let derived = derived(attributes);
    quote! {
        #(#attributes)*
        #derived
        #visibility struct #name<const D: ::core::primitive::usize> {
            #(#members),*
        }
        #required
        #rest
    }
}

/// Members without a default as the struct `Required`, and the data that are made of it.
fn emit_required(data: &Data, members: &[&Member]) -> TokenStream {
    let Data { visibility, name, .. } = data;
    let required = format_ident!("{}", Data::REQUIRED);
    // A name of the function's own, which no member can hide.
    let own = Ident::new("required", Span::mixed_site());
    let text = format!(
        "What `{name}` needs, whatever its other members are: `{name} {{ other: value, ..{required} {{ .. }}.into() }}`."
    );
    let needed = members.iter().filter(|member| member.default.is_none()).map(|member| emit_member(member));
    let values = members.iter().map(|member| value(member, &own));
    quote! {
        #[doc = #text]
        #[derive(::core::clone::Clone, ::core::fmt::Debug)]
        #visibility struct #required<const D: ::core::primitive::usize> {
            #(#needed),*
        }
        impl<const D: ::core::primitive::usize> ::core::convert::From<#required<D>> for #name<D> {
            fn from(#own: #required<D>) -> Self {
                #name { #(#values),* }
            }
        }
    }
}

/// Members that neither have a default nor are among the first included data as the struct `Rest`, and the data that are made of both.
fn emit_rest(data: &Data, first: &FirstIncluded, members: &[&Member]) -> TokenStream {
    let Data { visibility, name, .. } = data;
    let rest = format_ident!("{}", Data::REST);
    let (own, included) =
        (Ident::new("rest", Span::mixed_site()), Ident::new("included", Span::mixed_site()));
    let path = &first.path;
    let shown = path.to_string().replace(' ', "");
    let text = format!("What `{name}` needs in addition to `{shown}`: `{rest} {{ .. }}.with(data)`.");
    let is_included = |member: &Member| first.members.iter().any(|name| member.name == name);
    let needed = members.iter().filter(|member| member.default.is_none() && !is_included(member));
    let needed = needed.map(|member| emit_member(member));
    let values = members.iter().map(|member| {
        let name = &member.name;
        match is_included(member) {
            true => quote! { #name: #included.#name },
            false => value(member, &own),
        }
    });
    quote! {
        #[doc = #text]
        #[derive(::core::clone::Clone, ::core::fmt::Debug)]
        #visibility struct #rest<const D: ::core::primitive::usize> {
            #(#needed),*
        }
        impl<const D: ::core::primitive::usize> #rest<D> {
            /// The data with the members of `included` and of these; all others have their defaults.
            #visibility fn with(self, #included: impl ::core::convert::Into<#path<D>>) -> #name<D> {
                let (#own, #included): (Self, #path<D>) = (self, ::core::convert::Into::into(#included));
                #name { #(#values),* }
            }
        }
    }
}

/// A member's value in a literal: its default, or as `given` has it.
fn value(member: &Member, given: &Ident) -> TokenStream {
    let Member { name, kind, rank, default, .. } = member;
    let Some(default) = default else { return quote! { #name: #given.#name } };
    let value = rank.extents().iter().rev().fold(quote! { #default }, |entry, extent| {
        let extent = emit_extent(*extent);
        quote! { [#entry; #extent] }
    });
    match kind {
        MemberKind::Given | MemberKind::Carried => quote! { #name: contract::Given::constant(#value) },
        _ => quote! { #name: #value },
    }
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
