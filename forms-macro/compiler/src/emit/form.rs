//! One function: its constructor, its type, and the traits by which a backend walks its kernels.

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};

use super::description::{Argument as Described, NO_ARGUMENT, describe};
use super::external::ExternalNames;
use super::formula;
use super::kernel::KernelWriter;
use super::placeholder::{likely_regions, placeholder};
use crate::check::{field_members, fields_of};
use crate::optimise::degree::Degree;
use crate::optimise::linear::SidedField;
use crate::optimise::{Dependence, Description, Optimised};
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
) -> TokenStream {
    let Function { attributes, visibility, name, .. } = function;
    let complete = optimised.len() == dimensions.len();
    let used = used_regions(optimised.iter(), function);
    let constructor_arguments = constructor_arguments(module, function, &used);
    let inputs = inputs(module, function, &used);
    let mut implementations = TokenStream::new();
    let mut optimised: Vec<Option<Optimised>> = optimised.into_iter().map(Some).collect();
    for dimension in dimensions {
        let found =
            optimised.iter_mut().find(|one| one.as_ref().is_some_and(|one| one.dimension == *dimension));
        let found = found.and_then(Option::take);
        implementations.extend(implementation(module, function, *dimension, found, &used));
    }
    let own_inputs = own("inputs");
    let page = formula.map(|shown| formula::page(shown, module, function));
    let shown = formula::formula(formula);
    let constructor = match complete {
        true => quote! {
            #(#attributes)*
            #page
            #visibility fn #name<const D: ::core::primitive::usize>(#(#constructor_arguments),*) -> #name::Form<D> {
                #inputs
                #name::Form::with(#own_inputs)
            }
        },
        false => {
            let counts = [likely_regions(module, function), stored_arguments(function).count()];
            placeholder(module, visibility, name, counts)
        }
    };
    quote! {
        #constructor
        #visibility mod #name {
            use super::contract;
            #[allow(unused_imports)]
            use contract::{Form as _, Lane};

            /// The function with its data, ready for a backend.
            #[derive(Clone, Debug)]
            pub struct Form<const D: usize> {
                inputs: contract::Inputs<D>,
            }
            impl<const D: usize> Form<D> {
                pub(super) fn with(inputs: contract::Inputs<D>) -> Self {
                    Form { inputs }
                }
                /// The function as mathematics.
                pub fn formula(&self) -> &'static contract::Formula {
                    const FORMULA: contract::Formula = #shown;
                    &FORMULA
                }
            }
            #implementations
        }
    }
}

/// Regions of the module that the function integrates over, in the order of their declaration.
pub fn used_regions<'a>(optimised: impl Iterator<Item = &'a Optimised>, function: &Function) -> Vec<usize> {
    if matches!(function.output, Output::Value(_)) {
        return vec![];
    }
    let mut used: Vec<usize> = optimised
        .flat_map(|one| {
            let linear = one.residual.iter().map(|integral| integral.description.region);
            linear.chain(one.density.iter().map(|integral| integral.description.region)).collect::<Vec<_>>()
        })
        .collect();
    used.sort_unstable();
    used.dedup();
    used
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

/// The arguments that a constructor takes: known fields.
fn stored_arguments(function: &Function) -> impl Iterator<Item = &Argument> {
    function
        .arguments
        .iter()
        .filter(|argument| matches!(argument.role, ArgumentRole::State | ArgumentRole::Plain))
}

/// The constructor's name for a known field: the argument's, unless Rust reads that as a pattern (`None`, or a region,
/// which has been reported).
fn stored_argument(module: &Module, name: &Ident) -> Ident {
    let mut patterns = module.regions.iter().map(|region| region.name.to_string());
    let variant = ["Some", "None", "Ok", "Err"].iter().any(|variant| name == variant);
    match variant || patterns.any(|region| name == &region) {
        true => own(&format!("{name}_")),
        false => name.clone(),
    }
}

/// `GammaC` → `gamma_c_region`, and another name where that is taken.
fn region_arguments(module: &Module, used: &[usize]) -> Vec<Ident> {
    let mut taken: Vec<String> = Vec::new();
    for region in used {
        let mut text = String::new();
        for character in syn::ext::IdentExt::unraw(&module.regions[*region].name).to_string().chars() {
            if character.is_uppercase() && !text.is_empty() {
                text.push('_');
            }
            text.extend(character.to_lowercase());
        }
        text.push_str("_region");
        while taken.contains(&text) {
            text.push('_');
        }
        taken.push(text);
    }
    taken.iter().map(|name| own(name)).collect()
}

/// A name of the constructor's own, which an argument of the form cannot hide.
fn own(name: &str) -> Ident {
    Ident::new(name, Span::mixed_site())
}

fn inputs(module: &Module, function: &Function, used: &[usize]) -> TokenStream {
    let (own_data, own_inputs) = (own("data"), own("inputs"));
    let parameters = module
        .data
        .iter()
        .flat_map(|data| &data.members)
        .filter(|member| member.kind == MemberKind::Param)
        .map(|member| {
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
    let tables = module.data.iter().flat_map(|data| &data.members);
    let tables = tables.filter(|member| member.kind == MemberKind::Table).map(|member| &member.name);
    // No argument names an energy's test function per unknown, nor a tangent's direction per unknown.
    let unknowns =
        function.arguments.iter().filter(|argument| argument.role == ArgumentRole::Unknown).count();
    let variations = if function.output == Output::Energy { unknowns } else { 0 };
    let directions = if has_tangent(function) { unknowns } else { 0 };
    let unnamed = std::iter::repeat_n(quote! { ::core::option::Option::None }, variations + directions);
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

fn implementation(
    module: &Module,
    function: &Function,
    dimension: usize,
    optimised: Option<Optimised>,
    used: &[usize],
) -> TokenStream {
    let kernels_name = format_ident!("kernels_{dimension}");
    let mut kernels = TokenStream::new();
    let [mut residual, mut whole, mut tangent, mut whole_tangent, mut action, mut switches, mut density] =
        [const { Vec::new() }; 7];
    let mut value = None;
    let mut fields = fields_of(module, function, dimension);
    if let Some(mut optimised) = optimised {
        fields = std::mem::take(&mut optimised.fields);
        let mut graph = std::mem::take(&mut optimised.graph);
        let externals = ExternalNames::new(module, dimension);
        let mut writer =
            KernelWriter { graph: &mut graph, fields: &fields, externals: &externals, dimension };
        let visit = |description: TokenStream, kernel: &Ident| {
            quote! { visitor.visit(&#description, &#kernels_name::#kernel::new(&self.inputs.parameters, &self.inputs.tables))?; }
        };
        for (list, integrals, prefix) in [
            (&mut residual, &optimised.residual, "Residual"),
            (&mut whole, &optimised.joined, "Joined"),
            (&mut action, &optimised.action, "Action"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                kernels.extend(writer.linear(&kernel, integral.test.field, &integral.flux));
                let arguments = [argument(integral.test, &fields), NO_ARGUMENT];
                let description = describe(&integral.description, used, arguments, false);
                list.push(visit(description, &kernel));
            }
        }
        for (list, integrals, prefix) in [
            (&mut tangent, &optimised.tangent, "Tangent"),
            (&mut whole_tangent, &optimised.joined_tangent, "JoinedTangent"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                kernels.extend(writer.bilinear(&kernel, integral));
                let arguments = [integral.test, integral.trial].map(|one| argument(one, &fields));
                let description = describe(&integral.description, used, arguments, integral.symmetric);
                list.push(visit(description, &kernel));
            }
        }
        // What is joined on no region stands by itself in the whole, too.
        if !whole.is_empty() {
            let regions: Vec<usize> = optimised.joined.iter().map(|one| one.description.region).collect();
            let apart = |region: usize| !regions.contains(&region);
            let residuals = optimised.residual.iter().zip(&residual);
            let residuals = residuals.filter(|(integral, _)| apart(integral.description.region));
            whole.extend(residuals.map(|(_, visit)| visit.clone()));
            let tangents = optimised.tangent.iter().zip(&tangent);
            let tangents = tangents.filter(|(integral, _)| apart(integral.description.region));
            whole_tangent.extend(tangents.map(|(_, visit)| visit.clone()));
        }
        for (list, integrals, prefix) in
            [(&mut switches, &optimised.switches, "Switches"), (&mut density, &optimised.density, "Density")]
        {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                let shape = if prefix == "Density" { vec![] } else { vec![integral.components.len()] };
                kernels.extend(writer.expression(&kernel, &integral.components, &shape));
                let description = describe(&integral.description, used, [NO_ARGUMENT; 2], false);
                list.push(visit(description, &kernel));
            }
        }
        if let Some((components, shape)) = &optimised.value {
            let kernel = format_ident!("Value");
            kernels.extend(writer.expression(&kernel, components, shape));
            let description =
                Description { region: 0, dependence: Dependence::Constant, degree: Degree::constant(0) };
            value = Some(visit(describe(&description, &[0], [NO_ARGUMENT; 2], false), &kernel));
        }
    }
    let common = common_methods(function, &fields, dimension);
    let whole = (!whole.is_empty()).then(|| {
        quote! {
            fn whole_residual<V: contract::LinearVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                #(#whole)*
                Ok(())
            }
            fn whole_tangent<V: contract::BilinearVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                #(#whole_tangent)*
                Ok(())
            }
        }
    });
    let traits = match function.output {
        Output::Value(rank) => {
            let shape = rank.shape(dimension);
            quote! {
                impl contract::Expression<#dimension> for Form<#dimension> {
                    #common
                    fn shape(&self) -> &'static [usize] { &[#(#shape),*] }
                    fn expression<V: contract::ExpressionVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                        #value
                        Ok(())
                    }
                }
            }
        }
        output => {
            let functional = quote! {
                impl contract::Functional<#dimension> for Form<#dimension> {
                    #common
                    fn density<V: contract::ExpressionVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                        #(#density)*
                        Ok(())
                    }
                }
            };
            let form = quote! {
                impl contract::Form<#dimension> for Form<#dimension> {
                    #common
                    fn residual<V: contract::LinearVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                        #(#residual)*
                        Ok(())
                    }
                    #whole
                    fn tangent<V: contract::BilinearVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                        #(#tangent)*
                        Ok(())
                    }
                    fn action<V: contract::LinearVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                        #(#action)*
                        Ok(())
                    }
                    fn switches<V: contract::ExpressionVisitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                        #(#switches)*
                        Ok(())
                    }
                }
            };
            match output {
                Output::Functional => functional,
                Output::Energy => quote! { #functional #form },
                _ => form,
            }
        }
    };
    quote! {
        #traits
        mod #kernels_name {
            #[allow(unused_imports)]
            use super::contract::{self, Lane};
            #kernels
        }
    }
}

fn has_tangent(function: &Function) -> bool {
    matches!(function.output, Output::Form | Output::Energy)
}

/// What a backend is told of a test or trial function.
fn argument(function: SidedField, fields: &[FieldInfo]) -> Described {
    let number = match fields[function.field].role {
        FieldRole::Unknown(number) | FieldRole::Test(number) | FieldRole::Trial(number) => number,
        FieldRole::State | FieldRole::Given | FieldRole::Carried | FieldRole::History => 0,
    };
    Described { number, side: function.side }
}

fn common_methods(function: &Function, fields: &[FieldInfo], dimension: usize) -> TokenStream {
    let text = function.name.to_string();
    let fields = fields.iter().filter_map(|field| {
        let role = match field.role {
            FieldRole::Unknown(number) => quote! { Unknown(#number) },
            FieldRole::Test(number) => quote! { Test(#number) },
            FieldRole::State => quote! { State },
            FieldRole::Given | FieldRole::Carried | FieldRole::History => quote! { Given },
            FieldRole::Trial(number) if has_tangent(function) => quote! { Direction(#number) },
            FieldRole::Trial(_) => return None,
        };
        let (name, shape) = (&field.name, &field.shape);
        Some(quote! {
            contract::FieldDescription { name: #name, role: contract::Role::#role, shape: &[#(#shape),*] }
        })
    });
    quote! {
        fn name(&self) -> &'static str { #text }
        fn fields(&self) -> &'static [contract::FieldDescription] { &[#(#fields),*] }
        fn inputs(&self) -> &contract::Inputs<#dimension> { &self.inputs }
        fn formula(&self) -> &'static contract::Formula { Form::formula(self) }
    }
}
