//! What the compiler knows of an integral, as a `contract::Integral`.

use proc_macro2::TokenStream;
use quote::quote;

use crate::optimise::degree::{Degree, Part};
use crate::optimise::{Dependence, Description};

/// The text of a description; `used` are the function's regions.
pub fn describe(
    description: &Description,
    used: &[usize],
    test: usize,
    trial: usize,
    symmetric: bool,
) -> TokenStream {
    let region = used.iter().position(|region| *region == description.region).unwrap_or_default();
    let dependence = match description.dependence {
        Dependence::Constant => quote! { Constant },
        Dependence::Linear => quote! { Linear },
        Dependence::Nonlinear => quote! { Nonlinear },
    };
    let degree = degree(&description.degree);
    quote! {
        contract::Integral {
            region: #region,
            test: #test,
            trial: #trial,
            test_side: contract::Side::This,
            trial_side: contract::Side::This,
            dependence: contract::Dependence::#dependence,
            symmetric: #symmetric,
            degree: #degree,
        }
    }
}

/// A function from the fields' degrees to the integrand's.
fn degree(degree: &Degree) -> TokenStream {
    let sums = degree.0.iter().map(|sum| {
        let constant = sum.constant;
        let parts = sum.parts.iter().map(|(part, count)| {
            let value = match part {
                Part::Value(field) => quote! { fields[#field] },
                Part::Gradient(field) => quote! { fields[#field].saturating_sub(simplex as usize) },
                Part::Position => quote! { geometry },
                Part::Normal => quote! { geometry.saturating_sub(1) },
            };
            quote! { + #count * #value }
        });
        quote! { .max(#constant #(#parts)*) }
    });
    quote! { |fields, geometry, simplex| 0usize #(#sums)* }
}
