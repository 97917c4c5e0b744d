//! Stage 5: [`Optimised`] functions → Rust: the data struct, the regions, a constructor per function, and
//! behind it a module with the form's type and its kernels.

mod form;
mod kernel;
mod straight_line;

use proc_macro2::TokenStream;
use quote::quote;

use crate::check::is_building_block;
use crate::optimise::Optimised;
use crate::parse::syntax::*;

/// Writes the module. A function without an optimised version (it had a mistake) is written without
/// integrals, so that what refers to it still compiles.
pub fn emit(
    module: &Module,
    dimensions: &[usize],
    optimised: Vec<Optimised>,
    backend: &syn::Path,
) -> TokenStream {
    let Module { attributes, visibility, name, .. } = module;
    let data = module.data.as_ref().map(emit_data);
    let regions = module.regions.iter().map(emit_region);
    let mut by_function: Vec<Vec<Optimised>> = module.functions.iter().map(|_| Vec::new()).collect();
    for one in optimised {
        by_function[one.function].push(one);
    }
    let functions =
        module.functions.iter().zip(by_function).filter(|(function, _)| !is_building_block(function)).map(
            |(function, optimised)| form::emit_function(module, function, dimensions, optimised, backend),
        );
    quote! {
        #(#attributes)*
        #[allow(missing_docs, dead_code, unused_variables, non_snake_case, uncommon_codepoints, mixed_script_confusables)]
        #[allow(clippy::all)]
        #visibility mod #name {
            use #backend::contract;
            #data
            #(#regions)*
            #(#functions)*
        }
    }
}

fn emit_data(data: &Data) -> TokenStream {
    let Data { attributes, visibility, name, members } = data;
    let members = members.iter().map(|member| {
        let Member { attributes, name, kind, rank } = member;
        let value = value_type(*rank);
        let ty = match kind {
            MemberKind::Param => value,
            MemberKind::Given => quote! { contract::Given<#value, D> },
        };
        quote! { #(#attributes)* pub #name: #ty }
    });
    quote! {
        #(#attributes)*
        #[derive(Clone, Debug)]
        #visibility struct #name<const D: usize> {
            #(#members),*
        }
    }
}

fn value_type(rank: Rank) -> TokenStream {
    match rank {
        Rank::Scalar => quote! { f64 },
        Rank::Vector => quote! { [f64; D] },
        Rank::Tensor => quote! { [[f64; D]; D] },
    }
}

fn emit_region(region: &Region) -> TokenStream {
    let Region { attributes, visibility, name, facets } = region;
    let symbol = name.to_string();
    let entity = if *facets {
        quote! { Facets }
    } else {
        quote! { Cells }
    };
    quote! {
        #(#attributes)*
        #[derive(Clone, Debug)]
        #visibility struct #name(contract::Region);
        impl #name {
            /// Binds this region to a name of the mesh.
            pub fn on(name: impl Into<::std::string::String>) -> Self {
                #name(contract::Region { entity: contract::Entity::#entity, symbol: #symbol, name: name.into() })
            }
        }
    }
}
