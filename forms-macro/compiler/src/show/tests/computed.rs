//! Proofs that what is shown is what is computed.

use super::*;

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
        opposite: OppositeSide::SamePoint,
        known: Default::default(),
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
        let derived = differentiate(checked, &module.regions, &mut Diagnostics::default());
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
                    content.push(Term { region, displacement: None, means: None, density });
                }
                let shown = differentiate(
                    CheckedFunction {
                        function,
                        dimension,
                        arena: outlined.arena.clone(),
                        fields: outlined.fields.clone(),
                        content: Content::Functional(content),
                    },
                    &module.regions,
                    &mut Diagnostics::default(),
                );
                let densities = |terms: &[Term]| terms.iter().map(|term| term.density).collect::<Vec<_>>();
                let parts = || derived.residual.iter().filter(|part| part.term.region == region);
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
                    _ => parts().map(|part| part.term.density).collect(),
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
fn what_is_shown_is_what_is_computed() {
    for dimension in [2, 3] {
        let of_the_paper = proved(&nitsche(), dimension);
        for name in ["direct", "discrete_adjoint", "consistent_adjoint", "extended_adjoint"] {
            assert!(of_the_paper.contains(&format!("tangent of {name}")), "{name}");
        }
        let of_materials = proved(MATERIALS, dimension);
        for name in
            ["neo_hookean", "first_piola", "saint_venant", "p_laplace", "coupled", "coupled_energy", "kinks"]
        {
            assert!(of_materials.contains(&format!("tangent of {name}")), "{name}");
        }
        let two_sided = proved(INTERIOR_PENALTY, dimension);
        assert!(two_sided.contains(&"tangent of poisson".to_string()));
        assert!(two_sided.contains(&"tangent of nonlinear".to_string()));
        assert!(of_materials.contains(&"content of sensitivity".to_string()));
        assert!(of_materials.contains(&"variation of coupled_energy".to_string()));
    }
}
