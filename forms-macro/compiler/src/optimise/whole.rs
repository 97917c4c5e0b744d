//! Residuals and tangents that are asked for as a whole: what [`super::Dependence`] keeps apart on a region, for Newton's method, is one
//! integral here, so that geometry and fields of a facet are computed once.

use std::collections::BTreeMap;

use super::degree::Degree;
use super::linear::{Linear, SidedField, without};
use super::scalar::{Graph, Scalar};
use super::{Dependence, Description, Group, Optimised, Setting, bilinear_integrals, linear_integral, tests};
use crate::parse::syntax::Entity;
use crate::tensor::{FieldInfo, FieldRole};

/// The sum of a region's densities, and of their tangents per trial function.
pub(super) struct Whole {
    region: usize,
    degree: Degree,
    density: Scalar,
    tangent: BTreeMap<usize, Scalar>,
}

/// The regions on which at least two groups depend on the unknowns. None where the form has a history, whose points
/// belong to the integrals that read it.
pub(super) fn densities(groups: &[Group], fields: &[FieldInfo], graph: &mut Graph) -> Vec<Whole> {
    if fields.iter().any(|field| field.role == FieldRole::History) {
        return vec![];
    }
    let mut regions: BTreeMap<usize, Vec<&Group>> = BTreeMap::new();
    for group in groups {
        regions.entry(group.description.region).or_default().push(group);
    }
    let depends = |group: &&&Group| group.description.dependence != Dependence::Constant;
    let mut wholes = Vec::new();
    for (region, groups) in regions {
        if groups.iter().filter(depends).count() < 2 {
            continue;
        }
        let densities: Vec<Scalar> = groups.iter().map(|group| group.density).collect();
        let degrees = groups.iter().map(|group| group.description.degree.clone());
        let degree = degrees.reduce(Degree::largest).unwrap_or_else(|| Degree::constant(0));
        let mut tangent = BTreeMap::new();
        for (trial, derivative) in groups.iter().flat_map(|group| &group.tangent) {
            let sum = match tangent.get(trial) {
                Some(known) => graph.add(*known, *derivative),
                None => *derivative,
            };
            tangent.insert(*trial, sum);
        }
        wholes.push(Whole { region, degree, density: graph.sum(&densities), tangent });
    }
    wholes
}

/// Splits each by test function. `Err` has the name of one in which a density is not linear, which `check` rules out.
pub(super) fn plan(
    wholes: Vec<Whole>,
    from_energy: bool,
    graph: &mut Graph,
    entities: &[Entity],
    planned: &mut Optimised,
) -> Result<(), String> {
    let fields = &planned.fields;
    let setting = Setting { dimension: planned.dimension, fields, entities };
    for Whole { region, degree, density, tangent } in wholes {
        let description = Description { region, dependence: Dependence::Nonlinear, degree };
        let tests = tests(fields, density, graph);
        for test in tests.iter().copied() {
            let others: Vec<SidedField> = tests.iter().copied().filter(|other| *other != test).collect();
            let not_linear = || fields[test.field].name.clone();
            let density = without(graph, density, &others);
            let flux = Linear::new(graph, test).coefficients(density).ok_or_else(not_linear)?;
            planned.joined.extend(linear_integral(graph, &description, test, &flux));
            for (trial, derivative) in &tangent {
                let derivative = without(graph, *derivative, &others);
                let functions = (test, *trial);
                let integrals =
                    bilinear_integrals(graph, &description, functions, derivative, from_energy, &setting);
                planned.joined_tangent.extend(integrals.ok_or_else(not_linear)?);
            }
        }
    }
    Ok(())
}
