//! The data struct, and next to it the setters that make it: from nothing, `data()`, and from a value of the first included
//! data, `data_from(value)`.

use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote};

use super::derived;
use crate::parse::inclusion::FirstIncluded;
use crate::parse::syntax::*;
use crate::reuse::import::imported_path;
use crate::sorted::SortedSet;

/// Writes the structs, including members that have a mistake.
pub fn emit_data(data: &Data, module: &Module) -> TokenStream {
    let Data { attributes, visibility, name, .. } = data;
    if let Some(path) = imported_path(attributes) {
        let begins = [Some(Data::BEGIN), data.first.as_ref().map(|_| Data::BEGIN_FROM)];
        let begins = begins.iter().flatten().map(|begin| beside(path, begin));
        return quote! {
            #[allow(unused_imports)]
            #visibility use #path as #name;
            #(#[allow(unused_imports)] #visibility use #begins;)*
        };
    }
    // A name declared twice has been reported.
    let mut taken: SortedSet<String> = SortedSet::new();
    let unread = module.mistaken.iter().filter_map(|mistaken| match mistaken {
        Mistaken::Member(member) => Some(member),
        _ => None,
    });
    let has_mistakes = unread.clone().next().is_some();
    let members: Vec<&Member> =
        data.members.iter().chain(unread).filter(|member| taken.insert(member.name.to_string())).collect();
    // The name may be declared, which has been reported.
    let emits = |emitted: &str| {
        let functions = module.functions.iter().map(|function| &function.name);
        let mut names = functions.chain(module.regions.iter().map(|region| &region.name)).chain([name]);
        data.emits(emitted) && names.all(|name| name != emitted)
    };
    let from_nothing = Way {
        start: Data::BEGIN,
        prefix: "Needs_",
        text: format!(
            "Begins `{name}`: its members without a default follow by their names, in the order of declaration."
        ),
        included: None,
    };
    let from_included = data.first.as_ref().map(|first| {
        let shown = first.path.to_string().replace(' ', "");
        Way {
            start: Data::BEGIN_FROM,
            prefix: "Rest_needs_",
            text: format!(
                "`{name}` with the members of a `{shown}`: others without a default follow by their names."
            ),
            included: Some(first),
        }
    });
    let ways: Vec<TokenStream> = [Some(from_nothing), from_included]
        .iter()
        .flatten()
        .filter(|way| emits(way.start))
        .map(|way| match has_mistakes {
            true => way.placeholder(data),
            false => way.emit(data, &members),
        })
        .collect();
    let setters = emit_setters(name, &members);
    let members = members.into_iter().map(emit_member);
    let derived = derived(attributes);
    quote! {
        #(#attributes)*
        #derived
        #visibility struct #name<const D: ::core::primitive::usize> {
            #(#members),*
        }
        #setters
        #(#ways)*
    }
}

/// The path of what is next to an item.
fn beside(path: &TokenStream, name: &str) -> TokenStream {
    let mut tokens: Vec<TokenTree> = path.clone().into_iter().collect();
    tokens.pop();
    let name = format_ident!("{name}");
    quote! { #(#tokens)* #name }
}

/// A way to data: a function that begins them, and a setter for each member that they need, in the order of declaration. Each
/// setter is a method of a type of its own, so that a member that is forgotten is a type error with its name.
struct Way<'m> {
    /// The function.
    start: &'static str,
    /// Before the name of a member, the name of the type whose method sets it.
    prefix: &'static str,
    text: String,
    /// The struct whose value it begins with, and the names of its members.
    included: Option<&'m FirstIncluded>,
}

impl Way<'_> {
    fn includes(&self, member: &Member) -> bool {
        self.included.is_some_and(|first| first.members.iter().any(|name| member.name == name))
    }

    /// Its function where a member has a mistake: the data's own setters follow in any order.
    fn placeholder(&self, Data { visibility, name, .. }: &Data) -> TokenStream {
        let function = format_ident!("{}", self.start);
        let argument = self.included.map(|_| quote! { _: impl ::core::marker::Sized });
        quote! {
            #visibility fn #function<const D: ::core::primitive::usize>(#argument) -> #name<D> {
                loop {}
            }
        }
    }

    fn emit(&self, data: &Data, members: &[&Member]) -> TokenStream {
        let Data { visibility, name, .. } = data;
        let (function, text) = (format_ident!("{}", self.start), &self.text);
        // Names of the functions' own, which no member can hide.
        let own = |name: &str| Ident::new(name, Span::mixed_site());
        let (value, included) = (own("value"), own("included"));
        let is_needed = |member: &Member| member.default.is_none() && !self.includes(member);
        let needed: Vec<&Member> = members.iter().copied().filter(|member| is_needed(member)).collect();
        let types: Vec<Ident> =
            needed.iter().map(|member| format_ident!("{}{}", self.prefix, member.name)).collect();
        let locals: Vec<Ident> = (0..needed.len()).map(|number| own(&format!("value_{number}"))).collect();
        let literal = members.iter().map(|member| {
            let name = &member.name;
            let place = needed.iter().position(|needed| needed.name == *name);
            let value = match place {
                Some(place) => locals[place].to_token_stream(),
                None if self.includes(member) => quote! { #included.#name },
                None => {
                    member.default.map_or_else(TokenStream::new, |default| default_value(member, default))
                }
            };
            quote! { #name: #value }
        });
        let literal = quote! { #name { #(#literal),* } };
        let (first, argument, begun) = match self.included {
            Some(FirstIncluded { path, .. }) => (
                quote! { #path<D> },
                quote! { #included: impl ::core::convert::Into<#path<D>> },
                included.to_token_stream(),
            ),
            None => (quote! { () }, quote! {}, quote! { () }),
        };
        let given =
            self.included.map(|_| quote! { let #included: #first = ::core::convert::Into::into(#included); });
        let (result, body) = match types.first() {
            Some(first) => (quote! { #first<D> }, quote! { #first(#begun) }),
            None => (quote! { #name<D> }, literal.clone()),
        };
        // What the last setter takes apart.
        let mut pattern = begun;
        let steps = needed.iter().enumerate().map(|(place, member)| {
            let (Member { name: member_name, .. }, ty) = (member, &types[place]);
            let fields = match place.checked_sub(1) {
                None => first.clone(),
                Some(before) => {
                    let (before_type, before_value) = (&types[before], member_type(needed[before]));
                    quote! { #before_type<D>, #before_value }
                }
            };
            pattern = match place.checked_sub(1) {
                None => quote! { #ty(#pattern) },
                Some(before) => {
                    let local = &locals[before];
                    quote! { #ty(#pattern, #local) }
                }
            };
            let (argument, given) = setting(member, &value);
            let (next, body) = match types.get(place + 1) {
                Some(next) => (quote! { #next<D> }, quote! { #next(self, #given) }),
                None => {
                    let local = &locals[place];
                    (quote! { #name<D> }, quote! { let (#pattern, #local) = (self, #given); #literal })
                }
            };
            let documented = documentation(member);
            quote! {
                #[doc(hidden)]
                #[allow(non_camel_case_types)]
                #visibility struct #ty<const D: ::core::primitive::usize>(#fields);
                impl<const D: ::core::primitive::usize> #ty<D> {
                    #documented
                    pub fn #member_name(self, #value: #argument) -> #next {
                        #body
                    }
                }
            }
        });
        let steps: Vec<TokenStream> = steps.collect();
        quote! {
            #[doc = #text]
            #visibility fn #function<const D: ::core::primitive::usize>(#argument) -> #result {
                #given
                #body
            }
            #(#steps)*
        }
    }
}

/// A setter for each member of the data.
fn emit_setters(name: &Ident, members: &[&Member]) -> TokenStream {
    let value = Ident::new("value", Span::mixed_site());
    let setters = members.iter().map(|member| {
        let (Member { name, .. }, (argument, given)) = (member, setting(member, &value));
        let documented = documentation(member);
        quote! {
            #documented
            pub fn #name(mut self, #value: #argument) -> Self {
                self.#name = #given;
                self
            }
        }
    });
    quote! {
        impl<const D: ::core::primitive::usize> #name<D> {
            #(#setters)*
        }
    }
}

/// Type of a setter's argument, and the member's value made of it.
fn setting(member: &Member, value: &Ident) -> (TokenStream, TokenStream) {
    match member.kind {
        MemberKind::Given | MemberKind::Carried => {
            let components = value_type(member.rank);
            (quote! { impl contract::Datum<#components, D> }, quote! { contract::Datum::given(#value) })
        }
        _ => (member_type(member), value.to_token_stream()),
    }
}

/// A setter's documentation: that of its member.
fn documentation(member: &Member) -> TokenStream {
    let own = member.attributes.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let own: Vec<_> = own.collect();
    if own.is_empty() {
        let text = format!("The member `{}`.", member.name);
        return quote! { #[doc = #text] };
    }
    quote! { #(#own)* }
}

/// A member's value where none is given.
fn default_value(Member { kind, rank, .. }: &Member, default: f64) -> TokenStream {
    let value = rank.extents().iter().rev().fold(quote! { #default }, |entry, extent| {
        let extent = emit_extent(*extent);
        quote! { [#entry; #extent] }
    });
    match kind {
        MemberKind::Given | MemberKind::Carried => quote! { contract::Given::constant(#value) },
        _ => value,
    }
}

fn emit_member(member: &Member) -> TokenStream {
    let Member { attributes, name, default, .. } = member;
    let ty = member_type(member);
    let default = default.map(|value| {
        let text = format!("By default {value}.");
        quote! {
            ///
            #[doc = #text]
        }
    });
    quote! { #(#attributes)* #default pub #name: #ty }
}

fn member_type(member: &Member) -> TokenStream {
    let value = value_type(member.rank);
    match member.kind {
        MemberKind::Param => value,
        MemberKind::Given | MemberKind::Carried => quote! { contract::Given<#value, D> },
        MemberKind::History => quote! { contract::History<#value, D> },
        MemberKind::Table => quote! { contract::Table },
    }
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
