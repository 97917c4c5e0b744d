//! Names for editors: the functions of a forms module once more, as plain Rust, so that names inside their bodies are found.
//!
//! rust-analyzer looks names up in what a macro writes. Kernels hold numbers and no names, so for rust-analyzer alone the bodies
//! follow in a block of their own, as they were typed, where each name is an item: operators of the language, members of
//! the data, the module's functions and what it imports. rustc never sees them.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::{Attribute, FnArg, ForeignItem, Item, ItemFn, ItemMod, Signature};

use crate::parse::syntax::{MemberKind, Module, Output, Rank};

/// The bodies of a module's own functions, with a declaration for each name that they may hold.
pub fn bodies(item: &ItemMod, module: &Module, backend: &syn::Path) -> TokenStream {
    let items = || item.content.iter().flat_map(|(_, items)| items);
    let own: Vec<&ItemFn> = items()
        .filter_map(|item| match item {
            Item::Fn(function) => Some(function),
            _ => None,
        })
        .collect();
    // Its span is that of the member in the data struct: there an editor goes from each use.
    let members = module.members().map(|member| {
        let name = &member.name;
        let rank = match member.kind {
            MemberKind::Table => quote! { Table },
            _ => type_of(member.rank),
        };
        quote! { let #name: #rank = any(); }
    });
    let members: TokenStream = members.collect();
    let functions = own.iter().map(|ItemFn { attrs, sig, block, .. }| {
        let docs = documentation(attrs);
        quote! { #(#docs)* #sig { #members #block } }
    });
    let imported = module.functions.iter().filter(|function| function.foreign.is_some());
    let imported = imported.filter(|function| !own.iter().any(|own| own.sig.ident == function.name));
    let imported = imported.map(|function| {
        let docs = documentation(&function.attributes);
        let name = &function.name;
        let output = match function.output {
            Output::Value(rank) => type_of(rank),
            _ => quote! { Form },
        };
        let arguments = function.arguments.iter().map(|argument| {
            let name: &Ident = &argument.name;
            quote! { #name: impl ::core::marker::Sized }
        });
        quote! { #(#docs)* fn #name(#(#arguments),*) -> #output { any() } }
    });
    let external = items().filter_map(|item| match item {
        Item::ForeignMod(block) => Some(&block.items),
        _ => None,
    });
    let external = external.flatten().filter_map(|item| match item {
        ForeignItem::Fn(function) => Some(signature(&function.sig)),
        _ => None,
    });
    let imports = items().filter(|item| matches!(item, Item::Use(_)));
    quote! {
        #[allow(unused_imports)]
        const _: () = {
            #(#imports)*
        };
        const _: () = {
            use #backend::language::operators::*;
            use #backend::language::operators::editor::*;
            #(#functions)*
            #(#imported)*
            #(#external)*
        };
    }
}

/// Tensors of all ranks are one type: an editor shows names, and the compiler judges shapes.
fn type_of(rank: Rank) -> TokenStream {
    match rank {
        Rank::SCALAR => quote! { Scalar },
        Rank::VECTOR => quote! { Vector },
        _ => quote! { Tensor },
    }
}

fn signature(signature: &Signature) -> TokenStream {
    let (name, output) = (&signature.ident, &signature.output);
    let arguments = signature.inputs.iter().filter_map(|input| match input {
        FnArg::Typed(typed) => Some(typed),
        FnArg::Receiver(_) => None,
    });
    quote! { fn #name(#(#arguments),*) #output { any() } }
}

fn documentation(attributes: &[Attribute]) -> impl Iterator<Item = &Attribute> {
    attributes.iter().filter(|attribute| attribute.path().is_ident("doc"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostics::Diagnostics;
    use crate::parse::parse;

    /// The text for an editor is Rust, and holds each body as it was typed.
    #[test]
    fn bodies_stand_as_they_were_typed() {
        let item: ItemMod = syn::parse_quote! {
            mod contact {
                use super::elasticity::stress;
                pub struct Data { pub mu: Param, pub force: Given<Vector>, pub law: Table }
                #[cells]
                pub struct Omega;
                extern "Rust" { fn distance(y: Vector, radius: Scalar) -> Scalar; }
                /// Strain.
                fn strain(w: Vector) -> Tensor { let E = eps(w); mu * E }
                pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
                    integral(Omega, law(distance(x, 1)) * inner(strain(u), grad(v)) - dot(force, v))
                }
            }
        };
        let module = parse(item.clone(), &mut Diagnostics::default());
        let written = bodies(&item, &module, &syn::parse_quote!(::forms_fem)).to_string();
        let file: syn::File = syn::parse_str(&written).expect("Rust");
        assert_eq!(file.items.len(), 2);
        let has = |tokens: TokenStream| written.contains(&tokens.to_string());
        assert!(has(quote! { let E = eps(w); mu * E }));
        assert!(has(quote! { let mu: Scalar = any(); let force: Vector = any(); let law: Table = any(); }));
        assert!(has(quote! { fn distance(y: Vector, radius: Scalar) -> Scalar { any() } }));
        assert!(has(quote! { use super::elasticity::stress; }));
    }
}
