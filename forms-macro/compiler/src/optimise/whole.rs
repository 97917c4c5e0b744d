//! Residuals that are asked for as a whole: what [`super::Dependence`] keeps apart on a region, for Newton's method, is one
//! integral here, so that geometry and fields of a facet are computed once.

use std::collections::BTreeMap;

use super::degree::Degree;
use super::linear::{Linear, SidedField, without};
use super::scalar::{Graph, Scalar};
use super::{Dependence, Description, Group, Optimised, linear_integral, tests};
use crate::tensor::{FieldInfo, FieldRole};

/// The sum of a region's densities.
pub(super) struct Whole {
    region: usize,
    degree: Degree,
    density: Scalar,
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
        wholes.push(Whole { region, degree, density: graph.sum(&densities) });
    }
    wholes
}

/// Splits each by test function. `Err` has the name of one in which a density is not linear, which `check` rules out.
pub(super) fn plan(wholes: Vec<Whole>, graph: &mut Graph, planned: &mut Optimised) -> Result<(), String> {
    for Whole { region, degree, density } in wholes {
        let description = Description { region, dependence: Dependence::Nonlinear, degree };
        let tests = tests(&planned.fields, density, graph);
        for test in tests.iter().copied() {
            let others: Vec<SidedField> = tests.iter().copied().filter(|other| *other != test).collect();
            let density = without(graph, density, &others);
            let flux = Linear::new(graph, test).coefficients(density);
            let flux = flux.ok_or_else(|| planned.fields[test.field].name.clone())?;
            planned.joined.extend(linear_integral(graph, &description, test, &flux));
        }
    }
    Ok(())
}
