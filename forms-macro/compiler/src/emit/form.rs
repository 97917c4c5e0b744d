//! One function: its constructor, and the type that has its integrals.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::formula;
use super::integrals::emit_integrals;
use super::named_regions::{likely_regions, regions_named};
use super::names::{has_tangent, own, snake_case, stored_argument, stored_arguments};
use super::placeholder::placeholder;
use crate::check::field_members;
use crate::optimise::Optimised;
use crate::options::{Points, Products};
use crate::parse::syntax::*;
use crate::rustc_arguments;
use crate::show::Shown;
use crate::tensor::{FieldInfo, FieldRole};

/// Constructor and module of a function.
pub fn emit_function(
    module: &Module,
    function: &Function,
    dimensions: &[usize],
    optimised: Vec<Optimised>,
    formula: Option<&Shown>,
    derived: (Products, Points),
) -> TokenStream {
    let Function { attributes, visibility, name, .. } = function;
    let complete = optimised.len() == dimensions.len();
    let used = regions_named(module, function);
    let constructor_arguments = constructor_arguments(module, function, &used);
    let of_means = |field: &&FieldInfo| matches!(field.role, FieldRole::Mean(_) | FieldRole::MeanTest(_));
    let means = optimised.first().map_or(0, |one| one.fields.iter().filter(of_means).count());
    let inputs = inputs(module, function, &used, means);
    let mut integrals = TokenStream::new();
    let mut optimised: Vec<Option<Optimised>> = optimised.into_iter().map(Some).collect();
    for dimension in dimensions {
        let found =
            optimised.iter_mut().find(|one| one.as_ref().is_some_and(|one| one.dimension == *dimension));
        let found = found.and_then(Option::take);
        integrals.extend(emit_integrals(module, function, *dimension, found, &used, derived));
    }
    let own_inputs = own("inputs");
    let page = formula.map(|shown| formula::page(shown, module, function));
    let shown = formula::formula(formula);
    let (value, text) = (value(&function.output), name.to_string());
    let Compiled { bound, integrals: own_integrals } = compiled(name, dimensions);
    let constructor = match complete {
        true => quote! {
            #(#attributes)*
            #page
            #visibility fn #name<const D: ::core::primitive::usize>(#(#constructor_arguments),*) -> contract::#value<D>
            where
                #bound
            {
                #inputs
                contract::#value::of::<#own_integrals>(#text, &#name::FORMULA, #own_inputs)
            }
        },
        false => {
            let counts = [likely_regions(module, function), stored_arguments(function).count()];
            placeholder(module, visibility, name, &value, counts)
        }
    };
    quote! {
        #constructor
        #visibility mod #name {
            use super::contract;

            /// The function as mathematics.
            pub const FORMULA: contract::Formula = #shown;
            /// The integrals with their kernels, by dimension.
            #[derive(Clone, Copy, Debug)]
            pub struct Kernels;
            #integrals
        }
    }
}

/// The type of the value of a function with this output.
pub fn value(output: &Output) -> Ident {
    let name = match output {
        Output::Value(_) => "Expression",
        Output::Functional => "Functional",
        Output::Energy => "Energy",
        Output::Form => "Form",
    };
    Ident::new(name, proc_macro2::Span::call_site())
}

/// The integrals of a function in a dimension.
pub struct Compiled {
    /// The condition under which a function is compiled for the dimension D.
    pub bound: TokenStream,
    /// The type that has its integrals there.
    pub integrals: TokenStream,
}

/// The integrals of a function of this name that is compiled for these dimensions.
pub fn compiled(name: &Ident, dimensions: &[usize]) -> Compiled {
    match dimensions {
        [_] => Compiled {
            bound: quote! { #name::Kernels: contract::Integrals<D> },
            integrals: quote! { #name::Kernels },
        },
        _ => Compiled {
            bound: quote! { contract::Dim: contract::Dimension<D> },
            integrals: quote! { <contract::Dim as contract::Dimension<D>>::Of<#name::Kernels> },
        },
    }
}

fn constructor_arguments(module: &Module, function: &Function, used: &[usize]) -> Vec<TokenStream> {
    let mut arguments = Vec::new();
    if let Some(data) = &module.data {
        let name = &data.name;
        let data = own("data");
        arguments.push(quote! { #data: &#name<D> });
    }
    for (region, name) in used.iter().zip(region_arguments(module, used)) {
        let ty = &module.regions[*region].name;
        arguments.push(quote! { #name: &#ty });
    }
    for argument in stored_arguments(function) {
        let name = stored_argument(module, &argument.name);
        arguments.push(quote! { #name: impl ::core::convert::Into<contract::Source<D>> });
    }
    arguments
}

/// `GammaC` → `gamma_c_region`, and another name where that is taken.
fn region_arguments(module: &Module, used: &[usize]) -> Vec<Ident> {
    let mut taken: Vec<String> = Vec::new();
    for region in used {
        let mut text = format!("{}_region", snake_case(&module.regions[*region].name));
        while taken.contains(&text) {
            text.push('_');
        }
        taken.push(text);
    }
    taken.iter().map(|name| own(name)).collect()
}

/// `means` is the number of fields of means over own facets.
fn inputs(module: &Module, function: &Function, used: &[usize], means: usize) -> TokenStream {
    let (own_data, own_inputs) = (own("data"), own("inputs"));
    let parameters = module.members().filter(|member| member.kind == MemberKind::Param).map(|member| {
        let (name, text) = (&member.name, member.name.to_string());
        quote! { #own_inputs.push_parameter(#text, &#own_data.#name); }
    });
    let arguments = function.arguments.iter().map(|argument| match argument.role {
        ArgumentRole::Unknown | ArgumentRole::Test => quote! { ::core::option::Option::None },
        _ => {
            let name = stored_argument(module, &argument.name);
            quote! { ::core::option::Option::Some(::core::convert::Into::into(#name)) }
        }
    });
    let given = field_members(module).map(|member| {
        let name = &member.name;
        quote! { ::core::option::Option::Some(::core::clone::Clone::clone(#own_data.#name.source())) }
    });
    let tables = module.members().filter(|member| member.kind == MemberKind::Table);
    let tables = tables.map(|member| &member.name);
    // No argument names an energy's test function per unknown, means, nor a tangent's direction per unknown.
    let unknowns =
        function.arguments.iter().filter(|argument| argument.role == ArgumentRole::Unknown).count();
    let variations = if function.output == Output::Energy { unknowns } else { 0 };
    let directions = if has_tangent(function) { unknowns } else { 0 };
    let unnamed =
        std::iter::repeat_n(quote! { ::core::option::Option::None }, variations + means + directions);
    let regions = region_arguments(module, used).into_iter();
    let regions = regions.map(|name| quote! { ::core::clone::Clone::clone(&#name.0) });
    let unoptimised = (!rustc_arguments::optimised()).then(|| quote! { #own_inputs.optimised = false; });
    quote! {
        let mut #own_inputs = contract::Inputs::<D>::empty();
        #unoptimised
        #(#parameters)*
        #own_inputs.sources = ::std::vec![#(#arguments,)* #(#given,)* #(#unnamed,)*];
        #own_inputs.tables = ::std::vec![#(::core::clone::Clone::clone(&#own_data.#tables)),*];
        #own_inputs.regions = ::std::vec![#(#regions),*];
    }
}
