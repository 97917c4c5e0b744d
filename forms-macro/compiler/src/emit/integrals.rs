//! The integrals of a function in one dimension: descriptions, kernels, and the lists of them.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::description::{Argument as Described, NO_ARGUMENT, describe};
use super::external::ExternalNames;
use super::kernel::{KernelWriter, Motion};
use super::layout::PointsOf;
use super::names::has_tangent;
use crate::check::fields_of;
use crate::optimise::degree::Degree;
use crate::optimise::linear::SidedField;
use crate::optimise::{Dependence, Description, Optimised};
use crate::options::{Points, Products};
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
    (products, points): (Products, Points),
) -> TokenStream {
    let kernels_name = format_ident!("kernels_{dimension}");
    let mut kernels = TokenStream::new();
    let mut lists = Lists::default();
    let mut fields = fields_of(module, function, dimension);
    if let Some(mut optimised) = optimised {
        fields = std::mem::take(&mut optimised.fields);
        let mut graph = std::mem::take(&mut optimised.graph);
        let externals = ExternalNames::new(module, dimension);
        let writer = KernelWriter {
            graph: &mut graph,
            fields: &fields,
            externals: &externals,
            dimension,
            points_of: PointsOf::default(),
            points,
        };
        if products == Products::ByMatrices {
            optimised.action.clear();
        }
        lists = match rustc_arguments::only_checked() {
            true => Lists::left_out(),
            false => Lists::of(&optimised, used, &kernels_name, writer, &mut kernels),
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
    let lists = lists.into_methods(dimension);
    quote! {
        impl contract::Integrals<#dimension> for Kernels {
            fn fields() -> &'static [contract::FieldDescription] { &[#(#fields),*] }
            #shape
            #lists
        }
        mod #kernels_name {
            #[allow(unused_imports)]
            use super::contract::{self, Lane};
            #kernels
        }
    }
}

/// The terms of each list.
#[derive(Default)]
struct Lists {
    residual: Vec<TokenStream>,
    joined_residual: Vec<TokenStream>,
    tangent: Vec<TokenStream>,
    joined_tangent: Vec<TokenStream>,
    action: Vec<TokenStream>,
    motion: Vec<TokenStream>,
    means: Vec<TokenStream>,
    means_by_unknowns: Vec<TokenStream>,
    residual_by_means: Vec<TokenStream>,
    switches: Vec<TokenStream>,
    density: Vec<TokenStream>,
}

impl Lists {
    /// Lists without kernels, for a crate without machine code; if it is made after all, rustc says why it cannot be.
    fn left_out() -> Self {
        let never = vec![quote! {
            const { ::core::panic!("forms have no kernels where their crate was only checked (`--emit=metadata`)") }
        }];
        Lists { residual: never.clone(), tangent: never.clone(), density: never, ..Lists::default() }
    }

    /// The terms of an optimised function, whose kernels are written at the same time.
    fn of(
        optimised: &Optimised,
        used: &[usize],
        kernels_name: &Ident,
        mut writer: KernelWriter,
        kernels: &mut TokenStream,
    ) -> Self {
        let mut lists = Lists::default();
        let (mut means, mut means_by_unknowns, mut residual_by_means) = (vec![], vec![], vec![]);
        let term = |kernel: &Ident, kind: &str| {
            let (kernel, kind) = (quote! { #kernels_name::#kernel }, format_ident!("{kind}"));
            quote! {
                contract::Term {
                    integral: &#kernel::INTEGRAL,
                    kernel: B::#kind(#kernel::new(constants.parameters, constants.tables)),
                }
            }
        };
        for (list, integrals, prefix) in [
            (&mut lists.residual, &optimised.residual, "Residual"),
            (&mut lists.joined_residual, &optimised.joined, "Joined"),
            (&mut lists.action, &optimised.action, "Action"),
            (&mut lists.motion, &optimised.motion, "Motion"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                let displaced = integral.description.displacement.iter().flatten();
                let unknown = |field: &usize| matches!(writer.fields[*field].role, FieldRole::Unknown(_));
                // Products without a matrix are derivatives already.
                let slides = prefix == "Motion" || (prefix != "Action" && displaced.into_iter().any(unknown));
                let motion = match (slides, writer.points) {
                    (true, _) if prefix == "Motion" && optimised.from_energy => Motion::OfEnergy,
                    (true, _) => Motion::Slides,
                    (false, Points::MovedByLevelSet) if prefix == "Residual" => Motion::ByLevelSet,
                    (false, _) => Motion::Fixed,
                };
                writer.points_of = PointsOf::integral(&integral.description);
                kernels.extend(writer.linear(&kernel, integral.test.field, &integral.flux, motion));
                let arguments = [argument(integral.test, writer.fields), NO_ARGUMENT];
                let of_means = list_of_means(integral.test, writer.fields);
                let number = of_means.unwrap_or_default();
                let description = describe(&integral.description, used, arguments, false, number);
                kernels.extend(described(&kernel, description));
                match of_means {
                    Some(_) => means.push(term(&kernel, "linear")),
                    None => list.push(term(&kernel, "linear")),
                }
            }
        }
        for (list, integrals, prefix) in [
            (&mut lists.tangent, &optimised.tangent, "Tangent"),
            (&mut lists.joined_tangent, &optimised.joined_tangent, "JoinedTangent"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                writer.points_of = PointsOf::integral(&integral.description);
                kernels.extend(writer.bilinear(&kernel, integral));
                let arguments = [integral.test, integral.trial].map(|one| argument(one, writer.fields));
                let [made, by] = [integral.test, integral.trial].map(|one| list_of_means(one, writer.fields));
                // A product of two derivatives of an energy's means is symmetric.
                let symmetric = integral.symmetric || (by.is_some() && optimised.from_energy);
                let number = made.or(by).unwrap_or_default();
                let description = describe(&integral.description, used, arguments, symmetric, number);
                kernels.extend(described(&kernel, description));
                match (made, by) {
                    (Some(_), _) => means_by_unknowns.push(term(&kernel, "bilinear")),
                    (None, Some(_)) => residual_by_means.push(term(&kernel, "bilinear")),
                    (None, None) => list.push(term(&kernel, "bilinear")),
                }
            }
        }
        for (list, integrals, prefix) in [
            (&mut lists.switches, &optimised.switches, "Switches"),
            (&mut lists.density, &optimised.density, "Density"),
        ] {
            for (index, integral) in integrals.iter().enumerate() {
                let kernel = format_ident!("{prefix}{index}");
                let shape = if prefix == "Density" { vec![] } else { vec![integral.components.len()] };
                writer.points_of = PointsOf::integral(&integral.description);
                kernels.extend(writer.expression(&kernel, &integral.components, &shape));
                let description = describe(&integral.description, used, [NO_ARGUMENT; 2], false, 0);
                kernels.extend(described(&kernel, description));
                list.push(term(&kernel, "expression"));
            }
        }
        if let Some((components, shape)) = &optimised.value {
            let kernel = format_ident!("Value");
            writer.points_of = PointsOf::default();
            kernels.extend(writer.expression(&kernel, components, shape));
            let description = Description {
                region: 0,
                displacement: None,
                means: None,
                dependence: Dependence::Constant,
                vanishes: false,
                holds_points: false,
                varies_energy: false,
                moves: false,
                degree: Degree::constant(0),
            };
            let description = describe(&description, &[0], [NO_ARGUMENT; 2], false, 0);
            kernels.extend(described(&kernel, description));
            lists.density.push(term(&kernel, "expression"));
        }
        Lists { means, means_by_unknowns, residual_by_means, ..lists }
    }

    /// The lists that have terms; the others are the trait's own.
    fn into_methods(self, dimension: usize) -> TokenStream {
        let methods = [
            ("residual", "Linear", self.residual),
            ("joined_residual", "Linear", self.joined_residual),
            ("tangent", "Bilinear", self.tangent),
            ("joined_tangent", "Bilinear", self.joined_tangent),
            ("action", "Linear", self.action),
            ("motion", "Linear", self.motion),
            ("means", "Linear", self.means),
            ("means_by_unknowns", "Bilinear", self.means_by_unknowns),
            ("residual_by_means", "Bilinear", self.residual_by_means),
            ("switches", "Expression", self.switches),
            ("density", "Expression", self.density),
        ];
        methods
            .into_iter()
            .filter(|(_, _, terms)| !terms.is_empty())
            .map(|(list, kind, terms)| {
                let (list, kind) = (format_ident!("{list}"), format_ident!("{kind}"));
                quote! {
                    fn #list<B: contract::Backend<#dimension>>(constants: contract::Constants<'_>) -> ::std::vec::Vec<contract::Term<B::#kind>> {
                        ::std::vec![#(#terms),*]
                    }
                }
            })
            .collect()
    }
}

/// The description of a kernel's integral next to the kernel, where it is compiled once and not for every backend.
fn described(kernel: &Ident, description: TokenStream) -> TokenStream {
    quote! { impl #kernel { pub const INTEGRAL: contract::Integral = #description; } }
}

/// A test or trial function as a backend sees it.
fn argument(function: SidedField, fields: &[FieldInfo]) -> Described {
    let number = match fields[function.field].role {
        FieldRole::Unknown(number) | FieldRole::Test(number) | FieldRole::Trial(number) => number,
        // Of means the description has the number of the list.
        FieldRole::Mean(_) | FieldRole::MeanTest(_) | FieldRole::MeanTrial(_) => 0,
        FieldRole::State | FieldRole::Given | FieldRole::Carried | FieldRole::History => 0,
    };
    Described { number, side: function.side }
}

/// The list of means that a test function makes, or by which a trial function differentiates.
fn list_of_means(function: SidedField, fields: &[FieldInfo]) -> Option<usize> {
    match fields[function.field].role {
        FieldRole::MeanTest(number) | FieldRole::MeanTrial(number) => Some(number),
        _ => None,
    }
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
            FieldRole::Mean(number) => quote! { Mean(#number) },
            FieldRole::MeanTest(number) => quote! { MeanTest(#number) },
            FieldRole::Trial(_) | FieldRole::MeanTrial(_) => return None,
        };
        let (name, shape) = (&field.name, &field.shape);
        Some(quote! {
            contract::FieldDescription { name: #name, role: contract::Role::#role, shape: &[#(#shape),*] }
        })
    });
    described.collect()
}
