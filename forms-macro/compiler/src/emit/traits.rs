//! The traits of a compiled function's type, by which a backend walks its integrals: for all dimensions at once, or for
//! the one that the module was compiled for.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use crate::parse::syntax::{Function, Output};

/// The `impl` blocks of `Compiled`.
pub fn implementations(function: &Function, dimensions: &[usize]) -> TokenStream {
    let writer = match dimensions {
        [dimension] => Writer {
            generics: quote! {},
            dimension: quote! { #dimension },
            bound: quote! {},
            walks: quote! { <Kernels as contract::Integrals<#dimension>> },
            kernels: quote! {},
        },
        _ => Writer {
            generics: quote! { <const D: usize> },
            dimension: quote! { D },
            bound: quote! { where contract::Dim: contract::Dimension<D> },
            walks: quote! { <contract::Dim as contract::Dimension<D>> },
            kernels: quote! { Kernels },
        },
    };
    let linear = format_ident!("LinearVisitor");
    let bilinear = format_ident!("BilinearVisitor");
    let expression = format_ident!("ExpressionVisitor");
    let form = [
        ("residual", &linear),
        ("whole_residual", &linear),
        ("tangent", &bilinear),
        ("whole_tangent", &bilinear),
        ("action", &linear),
        ("switches", &expression),
    ];
    let density = [("density", &expression)];
    let name = function.name.to_string();
    match function.output {
        Output::Value(_) => writer.implement("Expression", &name, &[("expression", &expression)]),
        Output::Functional => writer.implement("Functional", &name, &density),
        Output::Energy => {
            let functional = writer.implement("Functional", &name, &density);
            let form = writer.implement("Form", &name, &form);
            quote! { #functional #form }
        }
        Output::Form => writer.implement("Form", &name, &form),
    }
}

/// The parts of an implementation that differ between a function for all dimensions and one for a single dimension.
struct Writer {
    generics: TokenStream,
    dimension: TokenStream,
    bound: TokenStream,
    /// The type whose functions walk the integrals.
    walks: TokenStream,
    /// The first type argument of those functions, if they take one.
    kernels: TokenStream,
}

impl Writer {
    /// The trait, with the walks that it has, each with the trait of its visitor.
    fn implement(&self, name: &str, function: &str, walks: &[(&str, &Ident)]) -> TokenStream {
        let Writer { generics, dimension, bound, walks: owner, kernels } = self;
        let trait_name = format_ident!("{name}");
        let of_kernels = (!kernels.is_empty()).then(|| quote! { ::<#kernels> });
        let separator = (!kernels.is_empty()).then(|| quote! { , });
        let walks = walks.iter().map(|(walk, visitor)| {
            let walk = format_ident!("{walk}");
            quote! {
                #[inline]
                fn #walk<V: contract::#visitor<#dimension>>(&self, visitor: &mut V) -> Result<(), V::Error> {
                    #owner::#walk::<#kernels #separator V>(self.inputs.constants(), visitor)
                }
            }
        });
        let shape = (name == "Expression").then(|| {
            quote! { fn shape(&self) -> &'static [usize] { #owner::shape #of_kernels() } }
        });
        quote! {
            impl #generics contract::#trait_name<#dimension> for Compiled<#dimension> #bound {
                fn name(&self) -> &'static str { #function }
                fn fields(&self) -> &'static [contract::FieldDescription] { #owner::fields #of_kernels() }
                fn inputs(&self) -> &contract::Inputs<#dimension> { &self.inputs }
                fn formula(&self) -> &'static contract::Formula { Compiled::formula(self) }
                #shape
                #(#walks)*
            }
        }
    }
}
