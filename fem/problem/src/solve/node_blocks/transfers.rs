//! Prolongations from spaces of lower degree, on free unknowns.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{DROPPED, FreeNodes};
use crate::linear_algebra::{BlockMatrix, BlockRows, BlockSparsity, CsrMatrix, LinearAlgebraError, NodeSet};

/// Coefficients below this are rounding.
const ROUNDING: f64 = 1e-14;

/// Most rounds in which given unknowns are replaced by what gives them; each doubles the depth.
const MOST_ROUNDS: usize = 8;

/// Unknowns of a space that its free ones give, with the coefficients.
pub(super) type Given = BTreeMap<usize, Vec<(usize, f64)>>;

/// The free unknowns of a space of lower degree, and what gives the others. A component of a node is what it is at the fine node of the
/// same place; where relations give it, the fine unknowns that they name are those of the embedded function.
pub(super) fn coarse_level(fine: &FreeNodes, given: &Given, embedding: &CsrMatrix) -> (FreeNodes, Given) {
    let components = fine.components;
    let mut is_free = vec![false; embedding.columns() * components];
    let mut coarse_given = Given::new();
    for node in 0..embedding.rows() {
        let ([column], [_]) = embedding.row(node) else { continue };
        for component in 0..components {
            let coarse = *column as usize * components + component;
            is_free[coarse] = fine.is_free(node, component);
            if let Some(terms) = given.get(&(node * components + component)) {
                coarse_given.insert(coarse, embedded(terms, components, embedding));
            }
        }
    }
    resolve(&mut coarse_given, &is_free);
    (FreeNodes::new(components, &is_free), coarse_given)
}

/// Terms in fine unknowns as terms in the coarse ones that interpolate them.
fn embedded(terms: &[(usize, f64)], components: usize, embedding: &CsrMatrix) -> Vec<(usize, f64)> {
    let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
    for (fine, a) in terms {
        let (columns, values) = embedding.row(fine / components);
        for (&column, value) in columns.iter().zip(values) {
            *sums.entry(column as usize * components + fine % components).or_default() += a * value;
        }
    }
    sums.into_iter().filter(|(_, a)| a.abs() > ROUNDING).collect()
}

/// Replaces given unknowns in the terms of others until only free ones are left. Terms of prescribed unknowns vanish, and those of unknowns
/// that give themselves by others, which levels of multigrid can do without.
fn resolve(given: &mut Given, is_free: &[bool]) {
    for _ in 0..MOST_ROUNDS {
        let names_given = |terms: &Vec<(usize, f64)>, given: &Given| {
            terms.iter().any(|(unknown, _)| given.contains_key(unknown))
        };
        if !given.values().any(|terms| names_given(terms, given)) {
            break;
        }
        let before = given.clone();
        for terms in given.values_mut().filter(|terms| names_given(terms, &before)) {
            let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
            for (unknown, a) in terms.iter() {
                match before.get(unknown) {
                    Some(others) => {
                        others.iter().for_each(|(other, b)| *sums.entry(*other).or_default() += a * b);
                    }
                    None => *sums.entry(*unknown).or_default() += a,
                }
            }
            *terms = sums.into_iter().filter(|(_, a)| a.abs() > ROUNDING).collect();
        }
    }
    for terms in given.values_mut() {
        terms.retain(|(unknown, _)| is_free[*unknown]);
    }
}

/// The embedding from the free unknowns of a coarse space to those of a fine one.
pub(super) fn transfer(
    fine: &FreeNodes,
    (coarse, given): (&FreeNodes, &Given),
    embedding: &CsrMatrix,
) -> Result<BlockMatrix, LinearAlgebraError> {
    let components = fine.components;
    let block = components * components;
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    // Of one row: the coarse nodes, and their blocks.
    let (mut nodes, mut blocks): (Vec<u32>, Vec<f64>) = (vec![], vec![]);
    for &node in &fine.kept {
        nodes.clear();
        blocks.clear();
        let mut add = |row: usize, unknown: usize, value: f64| {
            let number = coarse.number[unknown / components];
            if number == DROPPED {
                return;
            }
            let place = nodes.iter().position(|node| *node == number).unwrap_or_else(|| {
                nodes.push(number);
                blocks.resize(blocks.len() + block, 0.0);
                nodes.len() - 1
            });
            blocks[place * block + row * components + unknown % components] += value;
        };
        let (columns, entries) = embedding.row(node as usize);
        for (&column, value) in columns.iter().zip(entries) {
            for component in 0..components {
                if !fine.is_free(node as usize, component) {
                    continue;
                }
                let unknown = column as usize * components + component;
                if coarse.is_free(column as usize, component) {
                    add(component, unknown, *value);
                } else if let Some(terms) = given.get(&unknown) {
                    terms.iter().for_each(|(free, a)| add(component, *free, value * a));
                }
            }
        }
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        order.sort_unstable_by_key(|place| nodes[*place]);
        for place in order {
            indices.push(nodes[place]);
            values.extend_from_slice(&blocks[place * block..][..block]);
        }
        pointers.push(indices.len());
    }
    let sets = |nodes: &FreeNodes| NodeSet::in_a_row([(nodes.kept.len(), components)]);
    let rows = BlockRows::new(pointers, indices);
    let sparsity = BlockSparsity::new(sets(fine), sets(coarse), vec![vec![rows]])?;
    BlockMatrix::from_values(&Arc::new(sparsity), values)
}
