//! The start of the iteration for a projection: on each cell the polynomial that is nearest to the values, averaged at the nodes that
//! cells share. Of what is smooth it is near the answer.

use std::sync::Arc;

use crate::element::Tables;
use crate::linear_algebra::{Analysis, CsrMatrix, LinearAlgebraError, Ordering, SymmetricFactor};
use crate::quadrature::QuadratureRule;

/// The ratio of pivots below which a rule has too few points to tell the basis functions apart.
const INDEPENDENT: f64 = 1e-8;

/// Sums of cellwise coefficients, one list for each component.
pub(super) struct Start {
    sums: Vec<Vec<f64>>,
    counts: Vec<f64>,
}

impl Start {
    /// Nothing on any node.
    pub(super) fn new(nodes: usize, components: usize) -> Self {
        Start { sums: vec![vec![0.0; nodes]; components], counts: vec![0.0; nodes] }
    }

    /// Adds the polynomial of a cell with these nodes: `nearest` has a row for each of them, `values` all components of each point.
    pub(super) fn add(&mut self, nodes: &[u32], nearest: &[f64], values: &[f64]) {
        let components = self.sums.len();
        let points = values.len() / components;
        for (number, row) in nodes.iter().zip(nearest.chunks(points)) {
            self.counts[*number as usize] += 1.0;
            for (component, sums) in self.sums.iter_mut().enumerate() {
                let of_component = values.iter().skip(component).step_by(components);
                let coefficient: f64 = row.iter().zip(of_component).map(|(a, value)| a * value).sum();
                sums[*number as usize] += coefficient;
            }
        }
    }

    /// The averages; zero on nodes that no cell has added to.
    pub(super) fn averages(mut self) -> Vec<Vec<f64>> {
        for sums in &mut self.sums {
            for (sum, count) in sums.iter_mut().zip(&self.counts) {
                *sum /= count.max(1.0);
            }
        }
        self.sums
    }
}

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
    let value = |q: usize, node: usize| tables.value[q * nodes + node];
    let weighted = |q: usize, node: usize| rule.weights[q] * value(q, node);
    let product = |i: usize, j: usize| (0..points).map(|q| weighted(q, i) * value(q, j)).sum::<f64>();
    let places = (0..nodes).flat_map(|i| (0..nodes).map(move |j| (i, j)));
    let entries: Vec<(usize, usize, f64)> = places.map(|(i, j)| (i, j, product(i, j))).collect();
    let mass = CsrMatrix::from_triplets(nodes, nodes, &entries)?;
    let analysis = Arc::new(Analysis::new(mass.pattern(), &Ordering::default())?);
    let factor = SymmetricFactor::cholesky(&analysis, &mass, Vec::new())?;
    if factor.smallest_pivot_ratio() < INDEPENDENT {
        return Ok(None);
    }
    let mut found = vec![0.0; nodes * points];
    for q in 0..points {
        let mut column: Vec<f64> = (0..nodes).map(|node| weighted(q, node)).collect();
        factor.solve_in_place(&mut column)?;
        for (node, coefficient) in column.into_iter().enumerate() {
            found[node * points + q] = coefficient;
        }
    }
    Ok(Some(found))
}
