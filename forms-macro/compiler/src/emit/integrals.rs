//! The integrals of a function in one dimension: descriptions, kernels, and the walks that visit them.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::description::{Argument as Described, NO_ARGUMENT, describe};
use super::external::ExternalNames;
use super::kernel::KernelWriter;
use super::names::has_tangent;
use crate::check::fields_of;
use crate::optimise::degree::Degree;
use crate::optimise::linear::SidedField;
use crate::optimise::{Dependence, Description, Optimised};
use crate::parse::syntax::*;
use crate::rustc_arguments;
use crate::tensor::{FieldInfo, FieldRole};

/// `impl Integrals<D> for Kernels`, and the module of its kernels. A function with a mistake has no integrals.
pub fn emit_integrals(
    module: &Module,
    function: &Function,
    dimension: usize,
    optimised: Option<Optimised>,
    used: &[usize],
) -> TokenStream {
    let kernels_name = format_ident!("kernels_{dimension}");
    let mut kernels = TokenStream::new();
    let mut walks = Walks::default();
    let mut fields = fields_of(module, function, dimension);
    if let Some(mut optimised) = optimised {
        fields = std::mem::take(&mut optimised.fields);
        let mut graph = std::mem::take(&mut optimised.graph);
        let externals = ExternalNames::new(module, dimension);
        let writer = KernelWriter { graph: &mut graph, fields: &fields, externals: &externals, dimension };
        walks = match rustc_arguments::only_checked() {
            true => Walks::left_out(),
            false => Walks::of(&optimised, used, &kernels_name, writer, &mut kernels),
        };
    }
    let fields = describe_fields(function, &fields);
    let shape = match function.output {
        Output::Value(rank) => {
            let shape = rank.shape(dimension);
            Some(quote! { fn shape() -> &'static [usize] { &[#(#shape),*] } })
        }
        _ => None,
    };
    let walks = walks.into_methods(dimension);
    quote! {
        impl contract::Integrals<#dimension> for Kernels {
            fn fields() -> &'static [contract::FieldDescription] { &[#(#fields),*] }
            #shape
            #walks
        }
        mod #kernels_name {
            #[allow(unused_imports)]
            use super::contract::{self, Lane};
            #kernels
        }
    }
}

/// The visits of each walk.
#[derive(Default)]
struct Walks {
    residual: Vec<TokenStream>,
    whole_residual: Vec<TokenStream>,
    tangent: Vec<TokenStream>,
    whole_tangent: Vec<TokenStream>,
    action: Vec<TokenStream>,
    switches: Vec<TokenStream>,
    density: Vec<TokenStream>,
    expression: Vec<TokenStream>,
}

impl Walks {
    /// Walks without kernels, for a crate without machine code; if it is made after all, rustc says why it cannot be.
    fn left_out() -> Self {
        let never = vec![quote! {
            const { ::core::panic!("forms have no kernels where their crate was only checked (`--emit=metadata`)") };
        }];
        Walks {
            residual: never.clone(),
            whole_residual: never.clone(),
            tangent: never.clone(),
            whole_tangent: never.clone(),
            action: never.clone(),
            switches: never.clone(),
            density: never.clone(),
            expression: never,
        }
    }

    /// The visits of an optimised function, whose kernels are written besides.
    fn of(
        optimised: &Optimised,
        used: &[usize],
        kernels_name: &Ident,
        mut writer: KernelWriter,
        kernels: &mut TokenStream,
    ) -> Self {
        let mut walks = Walks::default();
        let visit = |kernel: &Ident| {
            let kernel = quote! { #kernels_name::#kernel };
            quote! { visitor.visit(&#kernel::INTEGRAL, &#kernel::new(constants.parameters, constants.tables))?; }
        };
        for (list, integrals, prefix) in [
            (&mut walks.residual, &optimised.residual, "Residual"),
            (&mut walks.whole_residual, &optimised.joined, "Joined"),
            (&mut walks.action, &optimised.action, "Action"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                kernels.extend(writer.linear(&kernel, integral.test.field, &integral.flux));
                let arguments = [argument(integral.test, writer.fields), NO_ARGUMENT];
                let description = describe(&integral.description, used, arguments, false);
                kernels.extend(described(&kernel, description));
                list.push(visit(&kernel));
            }
        }
        for (list, integrals, prefix) in [
            (&mut walks.tangent, &optimised.tangent, "Tangent"),
            (&mut walks.whole_tangent, &optimised.joined_tangent, "JoinedTangent"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                kernels.extend(writer.bilinear(&kernel, integral));
                let arguments = [integral.test, integral.trial].map(|one| argument(one, writer.fields));
                let description = describe(&integral.description, used, arguments, integral.symmetric);
                kernels.extend(described(&kernel, description));
                list.push(visit(&kernel));
            }
        }
        walks.complete_whole(optimised);
        for (list, integrals, prefix) in [
            (&mut walks.switches, &optimised.switches, "Switches"),
            (&mut walks.density, &optimised.density, "Density"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                let shape = if prefix == "Density" { vec![] } else { vec![integral.components.len()] };
                kernels.extend(writer.expression(&kernel, &integral.components, &shape));
                let description = describe(&integral.description, used, [NO_ARGUMENT; 2], false);
                kernels.extend(described(&kernel, description));
                list.push(visit(&kernel));
            }
        }
        if let Some((components, shape)) = &optimised.value {
            let kernel = format_ident!("Value");
            kernels.extend(writer.expression(&kernel, components, shape));
            let description = Description {
                region: 0,
                displacement: None,
                dependence: Dependence::Constant,
                vanishes: false,
                degree: Degree::constant(0),
            };
            let description = describe(&description, &[0], [NO_ARGUMENT; 2], false);
            kernels.extend(described(&kernel, description));
            walks.expression.push(visit(&kernel));
        }
        walks
    }

    /// Adds to the whole the integrals of regions on which nothing is joined.
    fn complete_whole(&mut self, optimised: &Optimised) {
        if self.whole_residual.is_empty() {
            return;
        }
        let place = |description: &Description| (description.region, description.displacement.clone());
        let joined: Vec<_> = optimised.joined.iter().map(|one| place(&one.description)).collect();
        let apart = |description: &Description| !joined.contains(&place(description));
        let residuals = optimised.residual.iter().zip(&self.residual);
        let residuals = residuals.filter(|(integral, _)| apart(&integral.description));
        self.whole_residual.extend(residuals.map(|(_, visit)| visit.clone()));
        let tangents = optimised.tangent.iter().zip(&self.tangent);
        let tangents = tangents.filter(|(integral, _)| apart(&integral.description));
        self.whole_tangent.extend(tangents.map(|(_, visit)| visit.clone()));
    }

    /// The walks that visit anything; the others are the trait's own. The whole is walked as the residual and the tangent
    /// are where nothing is joined.
    fn into_methods(self, dimension: usize) -> TokenStream {
        let whole = !self.whole_residual.is_empty();
        let linear = format_ident!("LinearVisitor");
        let bilinear = format_ident!("BilinearVisitor");
        let expression = format_ident!("ExpressionVisitor");
        let methods = [
            ("residual", &linear, self.residual, false),
            ("whole_residual", &linear, self.whole_residual, false),
            ("tangent", &bilinear, self.tangent, false),
            ("whole_tangent", &bilinear, self.whole_tangent, whole),
            ("action", &linear, self.action, false),
            ("switches", &expression, self.switches, false),
            ("density", &expression, self.density, false),
            ("expression", &expression, self.expression, false),
        ];
        methods
            .into_iter()
            .filter(|(_, _, visits, needed)| *needed || !visits.is_empty())
            .map(|(walk, visitor, visits, _)| {
                let walk = format_ident!("{walk}");
                quote! {
                    fn #walk<V: contract::#visitor<#dimension>>(constants: contract::Constants<'_>, visitor: &mut V) -> Result<(), V::Error> {
                        #(#visits)*
                        Ok(())
                    }
                }
            })
            .collect()
    }
}

/// The description of a kernel's integral next to the kernel, where it is compiled once and not for every visitor.
fn described(kernel: &Ident, description: TokenStream) -> TokenStream {
    quote! { impl #kernel { pub const INTEGRAL: contract::Integral = #description; } }
}

/// A test or trial function as a backend sees it.
fn argument(function: SidedField, fields: &[FieldInfo]) -> Described {
    let number = match fields[function.field].role {
        FieldRole::Unknown(number) | FieldRole::Test(number) | FieldRole::Trial(number) => number,
        FieldRole::State | FieldRole::Given | FieldRole::Carried | FieldRole::History => 0,
    };
    Described { number, side: function.side }
}

/// A `contract::FieldDescription` per field.
fn describe_fields(function: &Function, fields: &[FieldInfo]) -> Vec<TokenStream> {
    let described = fields.iter().filter_map(|field| {
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
    described.collect()
}
