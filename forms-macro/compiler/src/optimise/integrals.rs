//! Integrals of a group by test function, trial function and their sides.

use super::collect;
use super::factor::{self, Bilinear};
use super::groups::Group;
use super::linear::{Coefficients, Linear, SidedField, without};
use super::scalar::{Graph, Scalar};
use super::{BilinearIntegral, Dependence, Description, LinearIntegral, Setting};
use crate::tensor::{FieldInfo, FieldRole};

/// Splits residual and tangent of a group by test function, trial function, and their sides. `Err` has the
/// name of a function in which a density is not linear.
pub(super) fn split(
    group: &Group,
    from_energy: bool,
    graph: &mut Graph,
    setting: &Setting,
) -> Result<(Vec<LinearIntegral>, Vec<BilinearIntegral>), String> {
    let (mut residual, mut tangent) = (vec![], vec![]);
    for (test, others) in tests(setting.fields, group.density, graph) {
        let not_linear = || setting.fields[test.field].name.clone();
        let description = &group.description;
        let density = without(graph, group.density, &others);
        let flux = Linear::new(graph, test, &[density]).coefficients(density).ok_or_else(not_linear)?;
        let vanishes = description.dependence == Dependence::Linear
            && graph.vanishes_with(density, |node| setting.is_of_unknown(node));
        let of_residual = Description { vanishes, ..description.clone() };
        residual.extend(linear_integral(graph, &of_residual, test, &flux));
        for (trial, derivative) in &group.tangent {
            let derivative = without(graph, *derivative, &others);
            let integrals =
                bilinear_integrals(graph, description, (test, *trial), derivative, from_energy, setting);
            tangent.extend(integrals.ok_or_else(not_linear)?);
        }
    }
    Ok((residual, tangent))
}

/// The tangent of a group applied to directions, by test function. `Err` as from [`split`].
pub(super) fn action(
    group: &Group,
    graph: &mut Graph,
    setting: &Setting,
) -> Result<Vec<LinearIntegral>, String> {
    let derivatives: Vec<Scalar> = group.tangent.values().copied().collect();
    let action = graph.sum(&derivatives);
    let mut integrals = vec![];
    for (test, others) in tests(setting.fields, group.density, graph) {
        let action = without(graph, action, &others);
        let flux = Linear::new(graph, test, &[action]).coefficients(action);
        let flux = flux.ok_or_else(|| setting.fields[test.field].name.clone())?;
        integrals.extend(linear_integral(graph, &group.description, test, &flux));
    }
    Ok(integrals)
}

/// The integrals of a test function and a trial function on both sides; `None` where they are not linear in them.
fn bilinear_integrals(
    graph: &mut Graph,
    description: &Description,
    (test, trial): (SidedField, usize),
    derivative: Scalar,
    from_energy: bool,
    setting: &Setting,
) -> Option<Vec<BilinearIntegral>> {
    let mut integrals = Vec::new();
    let [this, other] = SidedField::on_sides(trial);
    for (trial, rest) in [(this, other), (other, this)] {
        let density = without(graph, derivative, &[rest]);
        let [first, second] = [test, trial].map(|function| &setting.fields[function.field]);
        let diagonal = matches!((first.role, second.role), (FieldRole::Test(a), FieldRole::Trial(b)) if a == b)
            && first.shape == second.shape
            && test.side == trial.side;
        let components = [first, second].map(|field| field.shape.iter().product());
        let form = Bilinear { density, test, trial, components, diagonal, from_energy };
        if let Some(factor::Planned { plan, symmetric, candidates }) =
            factor::plan(graph, &form, description, setting)?
        {
            let description = description.clone();
            integrals.push(BilinearIntegral { description, test, trial, symmetric, plan, candidates });
        }
    }
    Some(integrals)
}

/// The test functions that a density holds, on their sides, each with the others: what is linear in several
/// functions is a sum, and each takes its own share.
fn tests(fields: &[FieldInfo], density: Scalar, graph: &Graph) -> Vec<(SidedField, Vec<SidedField>)> {
    let tests: Vec<SidedField> = (0..fields.len())
        .filter(|field| matches!(fields[*field].role, FieldRole::Test(_) | FieldRole::MeanTest(_)))
        .flat_map(SidedField::on_sides)
        .filter(|test| graph.depends(density, |node| test.owns(node)))
        .collect();
    let others = |test: &SidedField| tests.iter().copied().filter(|other| other != test).collect();
    tests.iter().map(|test| (*test, others(test))).collect()
}

/// With common factors taken out of the coefficients; `None` if there are none.
fn linear_integral(
    graph: &mut Graph,
    description: &Description,
    test: SidedField,
    flux: &Coefficients,
) -> Option<LinearIntegral> {
    let coefficients = collect::cheaper(graph, flux.values().copied().collect());
    let flux: Coefficients = flux.keys().copied().zip(coefficients).collect();
    (!flux.is_empty()).then(|| LinearIntegral { description: description.clone(), test, flux })
}
