//! Three ways to compute a node pair's block, and the choice among them by counted operations.
//!
//! accumulated: the coefficients are constant on the cell. Sums S_kl of weight × test slot k × trial
//!              slot l (values or derivatives of the basis functions) are accumulated, and contracted with the coefficients once per pair.
//! factored:    the integrand is a sum of few products (linear in the test function) × (linear in the
//!              trial function), as contact terms are; each factor is computed once per basis function.
//! dense:       a factored plan whose test factors are the slots themselves.

use std::collections::BTreeMap;

use super::linear::{Coefficients, Linear, SidedField, Slot, factors, of_component};
use super::polynomial;
use super::scalar::{Argument, Derivative, Graph, Node, Scalar};
use crate::tensor::Geometry;

/// How the blocks of a bilinear integral are computed.
pub enum BilinearPlan {
    Accumulated {
        /// Derivatives of the test and of the trial basis function in each accumulated sum.
        sums: Vec<(Derivative, Derivative)>,
        /// Row-major block in terms of [`Node::Accumulated`].
        block: Vec<Scalar>,
    },
    Factored {
        /// Per block entry, row-major: the products (test factor, trial factor) to add up. Test
        /// factors are free of the weight, trial factors hold it.
        block: Vec<Vec<(Scalar, Scalar)>>,
    },
}

/// Points per cell and nodes per cell that the count of operations assumes.
const POINTS: usize = 5;
const NODES: usize = 8;

/// `None`: not bilinear. `Some(None)`: zero.
pub fn plan(
    graph: &mut Graph,
    density: Scalar,
    functions: [SidedField; 2],
    components: [usize; 2],
    diagonal: bool,
    from_energy: bool,
) -> Option<Option<Planned>> {
    let [test, trial] = functions;
    let flux = Linear::new(graph, test).coefficients(density)?;
    let mut matrix: BTreeMap<Slot, Coefficients> = BTreeMap::new();
    {
        let mut linear = Linear::new(graph, trial);
        for (slot, coefficient) in flux.iter() {
            let row = linear.coefficients(*coefficient)?;
            if !row.is_empty() {
                matrix.insert(*slot, (*row).clone());
            }
        }
    }
    if matrix.is_empty() {
        return Some(None);
    }
    let symmetric = diagonal && (from_energy || is_symmetric(graph, &matrix));

    let structured = structured_factors(graph, density, functions);
    let dense = matrix
        .iter()
        .map(|(slot, row)| (Coefficients::from([(*slot, graph.number(1.0))]), row.clone()))
        .collect();
    let mut best = factored(graph, dense, components);
    let mut candidates = vec![("dense", best.cost)];
    if let Some(structured) = structured {
        let candidate = factored(graph, structured, components);
        candidates.push(("factored", candidate.cost));
        if candidate.cost <= best.cost {
            best = candidate;
        }
    }
    if let Some(candidate) = accumulated(graph, &matrix, components) {
        candidates.push(("accumulated", candidate.cost));
        if candidate.cost <= best.cost {
            best = candidate;
        }
    }
    Some(Some(Planned { plan: best.plan, symmetric, candidates }))
}

/// The cheapest plan.
pub struct Planned {
    pub plan: BilinearPlan,
    /// Proved.
    pub symmetric: bool,
    /// Each plan with its cost, for those who ask why.
    pub candidates: Vec<(&'static str, usize)>,
}

struct Candidate {
    plan: BilinearPlan,
    /// Multiply-adds for a cell of [`NODES`] nodes and [`POINTS`] points.
    cost: usize,
}

fn is_symmetric(graph: &Graph, matrix: &BTreeMap<Slot, Coefficients>) -> bool {
    matrix.iter().all(|(row, entries)| {
        entries.iter().all(|(column, entry)| match matrix.get(column).and_then(|other| other.get(row)) {
            Some(mirrored) => polynomial::equal(graph, *entry, *mirrored),
            None => false,
        })
    })
}

fn structured_factors(
    graph: &mut Graph,
    density: Scalar,
    [test, trial]: [SidedField; 2],
) -> Option<Vec<(Coefficients, Coefficients)>> {
    let is = |wanted: SidedField| move |node: &Node| wanted.owns(node);
    let one = graph.number(1.0);
    let products = factors(graph, density, one, &is(test), &is(trial))?;
    // Products with one test factor are one product.
    let mut by_test: BTreeMap<Scalar, Vec<Scalar>> = BTreeMap::new();
    for (first, second) in products {
        by_test.entry(first).or_default().push(second);
    }
    let mut by_trial: BTreeMap<Scalar, Vec<Scalar>> = BTreeMap::new();
    for (first, seconds) in by_test {
        let second = graph.sum(&seconds);
        by_trial.entry(second).or_default().push(first);
    }
    let mut result = Vec::new();
    for (second, firsts) in by_trial {
        let first = graph.sum(&firsts);
        let first = Linear::new(graph, test).coefficients(first)?;
        let second = Linear::new(graph, trial).coefficients(second)?;
        if !first.is_empty() && !second.is_empty() {
            result.push(((*first).clone(), (*second).clone()));
        }
    }
    Some(result)
}

fn factored(
    graph: &mut Graph,
    products: Vec<(Coefficients, Coefficients)>,
    [rows, columns]: [usize; 2],
) -> Candidate {
    let weight = graph.intern(Node::Weight);
    let one = graph.number(1.0);
    let mut block = vec![Vec::new(); rows * columns];
    let (mut per_node, mut per_pair) = (0, 0);
    for (test, trial) in products {
        per_node += test.len() + trial.len();
        let test = on_basis(graph, &test, rows, Argument::Test, one);
        let trial = on_basis(graph, &trial, columns, Argument::Trial, weight);
        for (row, first) in test.iter().enumerate() {
            for (column, second) in trial.iter().enumerate() {
                if let (Some(first), Some(second)) = (first, second) {
                    block[row * columns + column].push((*first, *second));
                    per_pair += 1;
                }
            }
        }
    }
    let cost = POINTS * (NODES * per_node + NODES * NODES * per_pair);
    Candidate { plan: BilinearPlan::Factored { block }, cost }
}

/// A linear expression applied to φ e_a, for each component a; `None` where it vanishes.
fn on_basis(
    graph: &mut Graph,
    coefficients: &Coefficients,
    components: usize,
    argument: Argument,
    factor: Scalar,
) -> Vec<Option<Scalar>> {
    (0..components)
        .map(|component| {
            let mut parts = Vec::new();
            for (derivative, coefficient) in of_component(coefficients, component) {
                let basis = graph.intern(Node::Basis(argument, derivative));
                parts.push(graph.product(&[(factor, 1), (coefficient, 1), (basis, 1)]));
            }
            (!parts.is_empty()).then(|| graph.sum(&parts))
        })
        .collect()
}

fn accumulated(
    graph: &mut Graph,
    matrix: &BTreeMap<Slot, Coefficients>,
    [rows, columns]: [usize; 2],
) -> Option<Candidate> {
    let mut sums: Vec<(Derivative, Derivative)> = Vec::new();
    let mut block: Vec<Vec<Scalar>> = vec![Vec::new(); rows * columns];
    let mut contraction = 0;
    for (row, entries) in matrix {
        for (column, coefficient) in entries {
            if graph.depends(*coefficient, varies_over_cell) {
                return None;
            }
            let key = (row.1, column.1);
            let index = sums.iter().position(|known| *known == key).unwrap_or_else(|| {
                sums.push(key);
                sums.len() - 1
            });
            let sum = graph.intern(Node::Accumulated(index));
            let part = graph.multiply(*coefficient, sum);
            block[row.0 * columns + column.0].push(part);
            contraction += 1;
        }
    }
    let cost = POINTS * NODES * NODES * sums.len() + NODES * NODES * contraction;
    let block = block.iter().map(|parts| graph.sum(parts)).collect();
    Some(Candidate { plan: BilinearPlan::Accumulated { sums, block }, cost })
}

/// May the terminal differ between the points of a cell, but for weight and basis functions?
pub fn varies_over_cell(node: &Node) -> bool {
    match node {
        Node::Field { .. } => true,
        Node::Geometry(geometry, _) => {
            matches!(geometry, Geometry::Normal | Geometry::Position | Geometry::Curvature)
        }
        _ => false,
    }
}
