//! Formulas of forms that matter, and proofs that what is shown is what is computed.

use std::collections::HashMap;

use super::equations::variations;
use super::formula::{Formula, Infix};
use super::latex::Latex;
use super::notation::Notation;
use super::outlines::Outlines;
use super::unicode::Unicode;
use super::{Shown, formulas};
use crate::check::{CheckedFunction, Content, Term, check};
use crate::diagnostics::Diagnostics;
use crate::differentiate::differentiate;
use crate::optimise::scalar::Graph;
use crate::optimise::scalarise::Scalariser;
use crate::optimise::{equal_scalars, parameter_offsets};
use crate::parse::parse;
use crate::parse::syntax::Module;
use crate::tensor::{Arena, FieldRole, Side, Tensor};

fn module(source: &str) -> Module {
    let item = syn::parse_str(source).unwrap_or_else(|error| panic!("{error}"));
    parse(item, &mut Diagnostics::default())
}

fn shown(source: &str, name: &str) -> Shown {
    let module = module(source);
    let index = module.functions.iter().position(|function| function.name == name);
    let index = index.unwrap_or_else(|| panic!("no function {name}"));
    let found = formulas(&module, 2).swap_remove(index);
    found.unwrap_or_else(|| panic!("{name} has no formula"))
}

/// The forms of the paper.
fn nitsche() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../contact/src/nitsche.rs");
    let file = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let from = file.find("pub mod nitsche").unwrap_or_else(|| panic!("{path} has no module `nitsche`"));
    file[from..].to_string()
}

const MATERIALS: &str = r#"mod materials {
    struct Data { mu: Param, lambda: Param, p: Param, q: Param, f: Given<Scalar>, b: Given<Vector>, k: Param<Tensor> }
    #[cells] struct Omega;
    #[facets] struct GammaN;

    fn psi(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * pow(ln(J), 2)
    }
    fn deformation(u: Vector) -> Tensor { I + grad(u) }
    fn cauchy_green(u: Vector) -> Tensor { transpose(deformation(u)) * deformation(u) }
    fn quadratic(C: Tensor) -> Scalar { mu / 4 * inner(C - I, C - I) + lambda / 8 * pow(tr(C - I), 2) }
    fn flux(w: Scalar) -> Vector { pow(q + dot(grad(w), grad(w)), (p - 2) / 2) * grad(w) }
    fn mixed(a: Vector, s: Scalar) -> Vector { s * a + dot(b, a) * a }

    fn neo_hookean(u: Unknown<Vector>) -> Energy {
        integral(Omega, psi(deformation(u)) - dot(b, u)) - integral(GammaN, f * dot(u, n))
    }
    fn first_piola(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = deformation(u);
        integral(Omega, inner(diff(psi(F), F), grad(v)) - dot(b, v))
    }
    fn saint_venant(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = deformation(u);
        let C = transpose(F) * F;
        integral(Omega, inner(F * (2 * diff(quadratic(C), C)), grad(v)))
    }
    fn p_laplace(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(t), grad(v)) - f * v)
    }
    fn coupled(u: Unknown<Vector>, s: Unknown<Scalar>, v: Test<Vector>, r: Test<Scalar>) -> Form {
        integral(Omega, dot(mixed(u, s), v) + inner(grad(mixed(u, s)), grad(v)) + s * s * r)
            + integral(GammaN, max(s, u[0]) * r + min(exp(s), 1) * r * tanh(s))
    }
    fn coupled_energy(u: Unknown<Vector>, s: Unknown<Scalar>) -> Energy {
        integral(Omega, pow(1 - s, 2) * quadratic(cauchy_green(u)) + f * (s * s + dot(grad(s), k * grad(s))))
    }
    fn sensitivity(u: State<Vector>, w: State<Vector>) -> Functional {
        derivative(integral(Omega, psi(deformation(u))), mu, lambda)
            + derivative(derivative(integral(Omega, psi(deformation(u))), u, w), u, w)
    }
    fn kinks(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let s = t - f;
        let limited = if s > 1 && s * s < q { sqrt(q) * s } else { abs(s) / 2 };
        integral(Omega, (pos_part(s) - (neg_part(2 * s) - sign(s) * s) + limited) * v / (q * mu))
            - integral(GammaN, -(s + 1) * (-2) * v)
    }
}"#;

/// Sums the densities of a region as one scalar of the graph.
fn total(
    graph: &mut Graph,
    module: &Module,
    dimension: usize,
    arena: &Arena,
    densities: &[Tensor],
) -> crate::optimise::scalar::Scalar {
    let offsets = parameter_offsets(module, dimension);
    let mut scalariser = Scalariser {
        arena,
        graph,
        parameter_offsets: &offsets,
        dimension,
        side: Side::This,
        known: HashMap::new(),
    };
    let parts: Vec<_> = densities.iter().map(|density| scalariser.scalar(*density)).collect();
    graph.sum(&parts)
}

/// Expands every name in the formulas of derivatives, and compares with what is compiled: as polynomials in the
/// fields' components, not at some points only.
fn proved(source: &str, dimension: usize) -> Vec<String> {
    let module = module(source);
    let mut proved = Vec::new();
    for checked in check(&module, dimension, &mut Diagnostics::default()).functions {
        let function = checked.function;
        let name = module.functions[function].name.to_string();
        let mut outlines = Outlines::new(&module, dimension);
        let Some(mut outlined) = variations(&mut outlines, function) else { continue };
        let derived = differentiate(checked, &mut Diagnostics::default());
        let mut cases = vec![("content", &outlined.own, None)];
        let mut tangents =
            derived.fields.iter().enumerate().filter(|(_, field)| matches!(field.role, FieldRole::Trial(_)));
        for variation in &outlined.derivatives {
            cases.push(match variation.name.as_str() {
                "tangent" => ("tangent", &variation.terms, tangents.next().map(|(trial, _)| trial)),
                _ => ("variation", &variation.terms, None),
            });
        }
        for (what, terms, trial) in cases {
            for region in 0..module.regions.len() {
                let in_region = terms.iter().filter(|term| term.region == region);
                let mut content = Vec::new();
                for term in in_region {
                    let density = outlines.inlined(&mut outlined.arena, term.density, &outlined.fields);
                    let density = density.unwrap_or_else(|| panic!("{name} cannot be expanded"));
                    content.push(Term { region, density });
                }
                let shown = differentiate(
                    CheckedFunction {
                        function,
                        dimension,
                        arena: outlined.arena.clone(),
                        fields: outlined.fields.clone(),
                        content: Content::Functional(content),
                    },
                    &mut Diagnostics::default(),
                );
                let densities = |terms: &[Term]| terms.iter().map(|term| term.density).collect::<Vec<_>>();
                let parts = || derived.residual.iter().filter(|part| part.region == region);
                let compiled: Vec<Tensor> = match (what, trial) {
                    ("content", _) if !derived.density.is_empty() => {
                        let terms = derived.density.iter().filter(|term| term.region == region);
                        terms.map(|term| term.density).collect()
                    }
                    ("tangent", Some(trial)) => parts()
                        .flat_map(|part| &part.tangent)
                        .filter(|one| one.0 == trial)
                        .map(|one| one.1)
                        .collect(),
                    _ => parts().map(|part| part.density).collect(),
                };
                let mut graph = Graph::default();
                let one = total(&mut graph, &module, dimension, &shown.arena, &densities(&shown.density));
                let other = total(&mut graph, &module, dimension, &derived.arena, &compiled);
                assert!(
                    equal_scalars(&graph, one, other),
                    "{what} of {name} in {dimension}D, region {region}"
                );
                if !graph.is_zero(other) {
                    proved.push(format!("{what} of {name}"));
                }
            }
        }
    }
    proved
}

#[test]
fn print_all() {
    for source in [nitsche().as_str(), MATERIALS] {
        let m = module(source);
        for (f, s) in m.functions.iter().zip(formulas(&m, 2)) {
            println!("--- {}\n{}", f.name, s.map_or("none".into(), |s| s.unicode()));
        }
    }
}

#[test]
fn what_is_shown_is_what_is_computed() {
    for dimension in [2, 3] {
        let of_the_paper = proved(&nitsche(), dimension);
        println!("{of_the_paper:?}");
        let of_materials = proved(MATERIALS, dimension);
        println!("{of_materials:?}");
    }
}
