//! Stage 5: [`Optimised`] functions → Rust: the data struct, the regions, a constructor per function, and
//! behind it a module with its kernels.

mod data;
mod description;
pub mod editor;
mod external;
mod form;
mod formula;
mod integrals;
mod kernel;
mod layout;
mod model;
pub mod named_regions;
pub mod names;
mod parts;
mod placeholder;
mod print;

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use self::model::Bound;
use crate::check::{is_building_block, is_reserved};
use crate::optimise::Optimised;
use crate::options::{Points, Products};
use crate::parse::syntax::*;
use crate::reuse::import::imported_path;
use crate::show::Shown;
use crate::sorted::SortedSet;

/// Writes the contents of the module. After a mistake all names still exist, so that what refers to them gives no further
/// errors: a function without an optimised version (it had a mistake) is written as [`placeholder`].
pub fn emit(
    module: &Module,
    dimensions: &[usize],
    optimised: Vec<Optimised>,
    formulas: &[Option<Shown>],
    backend: &syn::Path,
    derived: (Products, Points),
) -> TokenStream {
    let data = module.data.as_ref().map(|data| data::emit_data(data, module));
    // A name declared twice, or one that belongs to the emitted code, has been reported: the first counts.
    let mut taken: SortedSet<String> = module.data.iter().map(|data| data.name.to_string()).collect();
    let mut is_first = |name: &Ident| !is_reserved(&name.to_string()) && taken.insert(name.to_string());
    let regions: Vec<_> =
        module.regions.iter().filter(|region| is_first(&region.name)).map(emit_region).collect();
    let mut by_function: Vec<Vec<Optimised>> = module.functions.iter().map(|_| Vec::new()).collect();
    for one in optimised {
        by_function[one.function].push(one);
    }
    let functions = module.functions.iter().zip(by_function).enumerate();
    let functions = functions.filter(|(_, (function, _))| !is_building_block(function));
    let mut bound = Vec::new();
    let functions: Vec<_> = functions
        .filter(|(_, (function, _))| is_first(&function.name))
        .map(|(index, (function, optimised))| {
            if optimised.len() == dimensions.len() {
                bound.push(Bound { function, regions: named_regions::regions_named(module, function) });
            }
            let formula = formulas.get(index).and_then(Option::as_ref);
            form::emit_function(module, function, dimensions, optimised, formula, derived)
        })
        .collect();
    let unread = module.mistaken.iter().filter_map(|mistaken| match mistaken {
        Mistaken::Function { visibility, name, arguments, output } => {
            let regions = if matches!(output, Output::Value(_)) { 0 } else { module.regions.len() };
            let value = form::value(output);
            let placeholder =
                placeholder::placeholder(module, visibility, name, &value, [regions, *arguments]);
            Some(quote! {
                #placeholder
                #visibility mod #name {}
            })
        }
        Mistaken::Member(_) | Mistaken::Region(_) | Mistaken::Import(_) | Mistaken::External(_) => None,
    });
    let model = model::emit_model(module, &bound, dimensions);
    let externals = module.externals.iter().map(|one| external::emit_external(one, dimensions));
    quote! {
        use #backend::contract;
        #data
        #(#regions)*
        #(#functions)*
        #model
        #(#externals)*
        #(#unread)*
    }
}

/// The traits that every declaration derives, except for those that its own attributes do.
fn derived(attributes: &[syn::Attribute]) -> TokenStream {
    let mut own = Vec::new();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("derive")) {
        // rustc reports what is no list of paths.
        let _ = attribute.parse_nested_meta(|derived| {
            own.extend(derived.path.segments.last().map(|segment| segment.ident.to_string()));
            Ok(())
        });
    }
    let clone = (!own.iter().any(|name| name == "Clone")).then(|| quote! { ::core::clone::Clone, });
    let debug = (!own.iter().any(|name| name == "Debug")).then(|| quote! { ::core::fmt::Debug, });
    quote! { #[derive(#clone #debug)] }
}

fn emit_region(region: &Region) -> TokenStream {
    let Region { attributes, visibility, name, entity, rule } = region;
    if let Some(path) = imported_path(attributes) {
        return quote! { #[allow(unused_imports)] #visibility use #path as #name; };
    }
    let (symbol, derived) = (name.to_string(), derived(attributes));
    let entity = match entity {
        Entity::Cells => quote! { Cells },
        Entity::Facets => quote! { Facets },
        Entity::InteriorFacets => quote! { InteriorFacets },
        Entity::Interface => quote! { Interface },
        Entity::Pairs => {
            return quote! {
                #(#attributes)*
                #derived
                #visibility struct #name(#[doc(hidden)] pub contract::Region);
                impl #name {
                    /// Binds this region to surfaces of the mesh; a name alone is a surface that may touch itself.
                    pub fn on(pairing: impl ::core::convert::Into<contract::Pairing>) -> Self {
                        #name(contract::Region::of_pairs(#symbol, ::core::convert::Into::into(pairing)))
                    }
                }
            };
        }
    };
    let at_vertices = (*rule == RegionRule::Vertices).then(|| quote! { .at_vertices() });
    quote! {
        #(#attributes)*
        #derived
        #visibility struct #name(#[doc(hidden)] pub contract::Region);
        impl #name {
            /// Binds this region to a name of the mesh.
            pub fn on(name: impl ::core::convert::Into<::std::string::String>) -> Self {
                #name(contract::Region::named(contract::Entity::#entity, #symbol, name) #at_vertices)
            }
        }
    }
}
