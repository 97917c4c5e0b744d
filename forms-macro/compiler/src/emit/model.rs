//! A forms module bound once: `Regions`, the names of its regions in a mesh, and `Model`, data and regions together, with
//! a method per function.

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};

use super::form::{Compiled, compiled, value};
use super::names::{snake_case, stored_argument, stored_arguments};
use crate::parse::syntax::*;
use crate::sorted::SortedSet;

/// A function that is emitted, and the regions that its constructor asks for.
pub struct Bound<'m> {
    pub function: &'m Function,
    pub regions: Vec<usize>,
}

/// The two structs. A region or a function that could not be read has no part in them.
pub fn emit_model(module: &Module, functions: &[Bound], dimensions: &[usize]) -> TokenStream {
    let members = member_names(&module.regions);
    let regions = emit_regions(&module.regions, &members);
    let data = module.data.as_ref();
    let generics = data.map(|_| quote! { <const D: ::core::primitive::usize> });
    let of_dimension = data.map(|_| quote! { <D> });
    let own_generics = data.is_none().then(|| quote! { <const D: ::core::primitive::usize> });
    let data_member = data.map(|Data { visibility, name, .. }| {
        quote! {
            /// Parameters and fields.
            #visibility data: #name<D>,
        }
    });
    let derives = match data {
        Some(_) => quote! { ::core::clone::Clone, ::core::fmt::Debug },
        None => quote! { ::core::clone::Clone, ::core::fmt::Debug, ::core::default::Default },
    };
    let new = data.filter(|_| functions.iter().all(|bound| bound.function.name != "new"));
    let new = new.map(|Data { visibility, name, .. }| {
        quote! {
            /// The data, with all regions under their own names.
            #visibility fn new(data: #name<D>) -> Self {
                Model { data, regions: ::core::default::Default::default() }
            }
        }
    });
    let methods = functions.iter().map(|Bound { function, regions }| {
        let Function { attributes, visibility, name, .. } = function;
        let documented = attributes.iter().filter(|attribute| attribute.path().is_ident("doc"));
        let data = data.map(|_| quote! { &self.data, });
        let regions = regions.iter().map(|region| {
            let member = &members[*region];
            quote! { &self.regions.#member, }
        });
        let arguments: Vec<Ident> =
            stored_arguments(function).map(|argument| stored_argument(module, &argument.name)).collect();
        let (value, Compiled { bound, .. }) = (value(&function.output), compiled(name, dimensions));
        quote! {
            #(#documented)*
            #visibility fn #name #own_generics(&self, #(#arguments: impl ::core::convert::Into<contract::Source<D>>),*) -> contract::#value<D>
            where
                #bound
            {
                #name(#data #(#regions)* #(#arguments),*)
            }
        }
    });
    quote! {
        #regions

        /// The module's functions with their data and regions: bound once, each function a method that takes its known
        /// fields.
        #[derive(#derives)]
        pub struct Model #generics {
            #data_member
            /// The regions by their names in the mesh.
            pub regions: Regions,
        }
        impl #generics Model #of_dimension {
            #new
            #(#methods)*
        }
    }
}

/// The regions' members: no keyword, no method that every struct has, none twice.
fn member_names(regions: &[Region]) -> Vec<Ident> {
    let mut taken: SortedSet<String> =
        ["default", "clone", "self", "super", "crate", "_"].map(str::to_owned).into();
    let names = regions.iter().map(|region| {
        let mut text = snake_case(&region.name);
        while !taken.insert(text.clone()) {
            text.push('_');
        }
        let ident = syn::parse_str::<Ident>(&text);
        ident.map_or_else(
            |_| Ident::new_raw(&text, region.name.span()),
            |_| Ident::new(&text, region.name.span()),
        )
    });
    names.collect()
}

/// The regions by their names in the mesh.
fn emit_regions(regions: &[Region], members: &[Ident]) -> TokenStream {
    let one_of = |entity: Entity| regions.iter().filter(|region| region.entity == entity).count() == 1;
    let defaults: Vec<String> = regions
        .iter()
        .map(|region| match region.entity {
            Entity::Cells if one_of(Entity::Cells) => "all".to_owned(),
            Entity::Interface if one_of(Entity::Interface) => "all".to_owned(),
            Entity::InteriorFacets if one_of(Entity::InteriorFacets) => "interior".to_owned(),
            _ => snake_case(&region.name),
        })
        .collect();
    let declared = regions.iter().zip(members).zip(&defaults).map(|((region, member), default)| {
        let Region { visibility, name, attributes, entity, .. } = region;
        let documented = attributes.iter().filter(|attribute| attribute.path().is_ident("doc"));
        let text = match entity {
            Entity::Pairs => format!("The surface `\"{default}\"` with itself unless others are given."),
            _ => format!("`\"{default}\"` unless another name is given."),
        };
        quote! {
            #(#documented)*
            ///
            #[doc = #text]
            #visibility #member: #name
        }
    });
    let by_default = regions.iter().zip(members).zip(&defaults).map(|((region, member), default)| {
        let name = &region.name;
        quote! { #member: #name::on(#default) }
    });
    let own_name = Ident::new("name", Span::mixed_site());
    let setters = regions.iter().zip(members).map(|(Region { visibility, name, entity, .. }, member)| {
        let (text, bound) = match entity {
            Entity::Pairs => (
                format!("The regions with `{name}` on these surfaces of the mesh."),
                quote! { contract::Pairing },
            ),
            _ => (
                format!("The regions with `{name}` under this name of the mesh."),
                quote! { ::std::string::String },
            ),
        };
        let setter = format_ident!("{member}");
        quote! {
            #[doc = #text]
            #visibility fn #setter(mut self, #own_name: impl ::core::convert::Into<#bound>) -> Self {
                self.#member = #name::on(#own_name);
                self
            }
        }
    });
    quote! {
        /// The module's regions by their names in a mesh. A single region of cells or of an interface is `"all"`, a single one of
        /// interior facets `"interior"`, every other one goes by its own name in snake case, unless another is given.
        #[derive(::core::clone::Clone, ::core::fmt::Debug)]
        pub struct Regions {
            #(#declared),*
        }
        impl ::core::default::Default for Regions {
            fn default() -> Self {
                Regions { #(#by_default),* }
            }
        }
        impl Regions {
            #(#setters)*
        }
    }
}
