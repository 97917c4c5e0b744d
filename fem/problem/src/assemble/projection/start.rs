//! The start of the iteration for a projection: on each cell the polynomial that is nearest to the values, averaged at the nodes that
//! cells share. Of what is smooth it is near the answer, and of a space without continuity, on affine cells, the answer.

use std::sync::Arc;

use crate::element::Tables;
use crate::linear_algebra::{Analysis, CsrMatrix, LinearAlgebraError, Ordering, SymmetricFactor};
use crate::quadrature::QuadratureRule;

/// The ratio of pivots below which a rule has too few points to tell the basis functions apart.
const INDEPENDENT: f64 = 1e-8;

/// The coefficients of the polynomial that is nearest to values at the points of a rule on the reference cell: one row for each node,
/// in it a factor for each point. None where the rule has too few points.
pub(super) fn nearest_on_reference<const D: usize>(
    rule: &QuadratureRule<D>,
    tables: &Tables<D>,
) -> Option<Vec<f64>> {
    // Without such a start the iteration begins at zero.
    factors(rule, tables).ok().flatten()
}

fn factors<const D: usize>(
    rule: &QuadratureRule<D>,
    tables: &Tables<D>,
) -> Result<Option<Vec<f64>>, LinearAlgebraError> {
    let (nodes, points) = (tables.nodes, rule.len());
    let Some(factor) = factor(nodes, &reference_mass(rule, tables))? else { return Ok(None) };
    let mut found = vec![0.0; nodes * points];
    for q in 0..points {
        let basis = &tables.value[q * nodes..(q + 1) * nodes];
        let mut column: Vec<f64> = basis.iter().map(|value| rule.weights[q] * value).collect();
        factor.solve_in_place(&mut column)?;
        for (node, coefficient) in column.into_iter().enumerate() {
            found[node * points + q] = coefficient;
        }
    }
    Ok(Some(found))
}

/// E M⁻¹ E of a cell's matrix M with the diagonal E, row by row. None where the rule of the matrix has too few points.
pub(super) fn scaled_inverse(nodes: usize, mass: &[f64]) -> Option<Vec<f64>> {
    let factor = factor(nodes, mass).ok().flatten()?;
    let mut found = Vec::with_capacity(nodes * nodes);
    for j in 0..nodes {
        let mut column = vec![0.0; nodes];
        column[j] = mass[j * nodes + j];
        factor.solve_in_place(&mut column).ok()?;
        found.extend(column.iter().enumerate().map(|(i, value)| mass[i * nodes + i] * value));
    }
    Some(found)
}

/// The factor of a cell's matrix; none where the rule of the matrix has too few points.
fn factor(nodes: usize, mass: &[f64]) -> Result<Option<SymmetricFactor>, LinearAlgebraError> {
    let places = (0..nodes).flat_map(|i| (0..nodes).map(move |j| (i, j)));
    let entries = places.zip(mass).map(|((i, j), entry)| (i, j, *entry));
    let mass = CsrMatrix::from_triplets(nodes, nodes, &entries.collect::<Vec<_>>())?;
    let analysis = Arc::new(Analysis::new(mass.pattern(), &Ordering::default())?);
    let factor = SymmetricFactor::cholesky(&analysis, &mass, Vec::new())?;
    Ok((factor.smallest_pivot_ratio() >= INDEPENDENT).then_some(factor))
}

/// The mass matrix of the reference cell by a rule, row by row.
pub(super) fn reference_mass<const D: usize>(rule: &QuadratureRule<D>, tables: &Tables<D>) -> Vec<f64> {
    let n = tables.nodes;
    let mut mass = vec![0.0; n * n];
    for (weight, basis) in rule.weights.iter().zip(tables.value.chunks(n)) {
        for (row, test) in mass.chunks_mut(n).zip(basis) {
            row.iter_mut().zip(basis).for_each(|(entry, trial)| *entry += weight * test * trial);
        }
    }
    mass
}
