//! Description of an integral, as a `contract::Integral`.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use crate::optimise::degree::{Degree, Part};
use crate::optimise::{Dependence, Description};
use crate::tensor::Side;

/// A test or trial function: its number among its kind, and its side.
#[derive(Clone, Copy)]
pub struct Argument {
    pub number: usize,
    pub side: Side,
}

/// The description of an integral that has no test (or no trial) function.
pub const NO_ARGUMENT: Argument = Argument { number: 0, side: Side::This };

/// The variant of `contract::Side`.
pub fn name_of_side(side: Side) -> Ident {
    match side {
        Side::This => format_ident!("This"),
        Side::Other => format_ident!("Other"),
    }
}

/// The text of a description; `used` are the function's regions.
pub fn describe(
    description: &Description,
    used: &[usize],
    [test, trial]: [Argument; 2],
    symmetric: bool,
    list_of_means: usize,
) -> TokenStream {
    let region = used.iter().position(|region| *region == description.region).unwrap_or_default();
    let dependence = match description.dependence {
        Dependence::Constant => quote! { Constant },
        Dependence::Linear => quote! { Linear },
        Dependence::Nonlinear => quote! { Nonlinear },
    };
    let vanishes = description.vanishes;
    let degree_of_rule = degree(&description.degree);
    let [test_side, trial_side] = [test.side, trial.side].map(name_of_side);
    let [test, trial] = [test.number, trial.number];
    let displacement = match &description.displacement {
        Some(fields) => quote! { ::core::option::Option::Some(&[#(#fields),*]) },
        None => quote! { ::core::option::Option::None },
    };
    let means = match description.means {
        Some(degree) => quote! {
            ::core::option::Option::Some(contract::Means { number: #list_of_means, degree: #degree })
        },
        None => quote! { ::core::option::Option::None },
    };
    quote! {
        contract::Integral {
            region: #region,
            displacement: #displacement,
            test: #test,
            trial: #trial,
            test_side: contract::Side::#test_side,
            trial_side: contract::Side::#trial_side,
            dependence: contract::Dependence::#dependence,
            vanishes: #vanishes,
            symmetric: #symmetric,
            means: #means,
            degree: #degree_of_rule,
        }
    }
}

/// The text of a degree.
fn degree(degree: &Degree) -> TokenStream {
    let sums = degree.0.iter().map(|sum| {
        let constant = sum.constant;
        let (mut positions, mut normals, mut fields) = (0, 0, vec![]);
        for (part, count) in &sum.parts {
            match part {
                Part::Field { field, order } => fields.push(quote! { [#field, #order, #count] }),
                Part::Position => positions += count,
                Part::Normal => normals += count,
            }
        }
        quote! {
            contract::DegreeSum {
                constant: #constant,
                positions: #positions,
                normals: #normals,
                fields: &[#(#fields),*],
            }
        }
    });
    quote! { contract::Degree(&[#(#sums),*]) }
}
