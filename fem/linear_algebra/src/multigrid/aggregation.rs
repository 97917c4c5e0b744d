//! Aggregates: groups of strongly coupled nodes that become one node of the next coarser level.

use super::super::block_matrix::BlockMatrix;
use super::super::block_product::Single;
use super::super::error::LinearAlgebraError;

/// A node without an aggregate.
pub(super) const NONE: u32 = u32::MAX;

/// The aggregate of each node, and their number.
pub(super) struct Aggregates {
    pub(super) of_node: Vec<u32>,
    pub(super) count: usize,
}

impl Aggregates {
    /// Groups nodes whose blocks satisfy ‖A_ij‖² > threshold² ‖A_ii‖ ‖A_jj‖ (Vaněk, Mandel and Brezina 1996): first
    /// whole neighbourhoods that are still free, then what is left joins its strongest neighbour, then the rest among
    /// itself. Nodes that are coupled to nothing, such as prescribed ones, stay without an aggregate.
    pub(super) fn new(matrix: &BlockMatrix, threshold: f64) -> Result<Self, LinearAlgebraError> {
        let single = Single::of(matrix)?;
        let nodes = single.rows.nodes;
        let square = |block: &[f64]| block.iter().map(|value| value * value).sum::<f64>();
        let mut diagonal = vec![0.0; nodes];
        for (node, target) in diagonal.iter_mut().enumerate() {
            if let Some((_, block)) = single.row(node).find(|(column, _)| *column as usize == node) {
                *target = square(block).sqrt();
            }
        }
        // Strength of a coupling, or none if it is weak. Couplings of 1e-8 are rounding.
        let threshold = threshold.max(1e-8);
        let strength = |node: usize, other: u32, block: &[f64]| {
            let value = square(block);
            let scale = diagonal[node] * diagonal[other as usize];
            (other as usize != node && value > threshold * threshold * scale).then_some(value)
        };
        let strong =
            |node: usize| single.row(node).filter_map(move |(j, block)| Some((j, strength(node, j, block)?)));
        let mut of_node = vec![NONE; nodes];
        let mut count = 0;
        for node in 0..nodes {
            let mut near = strong(node).peekable();
            if of_node[node] == NONE
                && near.peek().is_some()
                && near.all(|(j, _)| of_node[j as usize] == NONE)
            {
                of_node[node] = count as u32;
                strong(node).for_each(|(j, _)| of_node[j as usize] = count as u32);
                count += 1;
            }
        }
        let roots = of_node.clone();
        for (node, own) in of_node.iter_mut().enumerate().filter(|(_, own)| **own == NONE) {
            let near = strong(node).filter(|(j, _)| roots[*j as usize] != NONE);
            if let Some((j, _)) = near.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))) {
                *own = roots[j as usize];
            }
        }
        for node in 0..nodes {
            if of_node[node] == NONE && strong(node).next().is_some() {
                of_node[node] = count as u32;
                for (j, _) in strong(node) {
                    if of_node[j as usize] == NONE {
                        of_node[j as usize] = count as u32;
                    }
                }
                count += 1;
            }
        }
        Ok(Aggregates { of_node, count })
    }

    /// The nodes of each aggregate, ascending: where they start, and the nodes.
    pub(super) fn members(&self) -> (Vec<usize>, Vec<u32>) {
        let mut starts = vec![0; self.count + 1];
        let grouped = || self.of_node.iter().enumerate().filter(|(_, aggregate)| **aggregate != NONE);
        grouped().for_each(|(_, aggregate)| starts[*aggregate as usize + 1] += 1);
        for aggregate in 0..self.count {
            starts[aggregate + 1] += starts[aggregate];
        }
        let mut next = starts.clone();
        let mut nodes = vec![0; starts[self.count]];
        for (node, aggregate) in grouped() {
            nodes[next[*aggregate as usize]] = node as u32;
            next[*aggregate as usize] += 1;
        }
        (starts, nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CsrMatrix;

    #[test]
    fn a_chain_falls_into_runs_of_three_and_a_weak_link_separates() {
        let mut triplets = vec![(9, 9, 2.0)];
        for i in 0..9 {
            let value = if i == 4 { -1e-4 } else { -1.0 };
            triplets.extend([(i, i, 2.0), (i, i + 1, value), (i + 1, i, value)]);
        }
        triplets.push((10, 10, 1.0)); // coupled to nothing
        let matrix: BlockMatrix = CsrMatrix::from_triplets(11, 11, &triplets).unwrap().into();
        let found = Aggregates::new(&matrix, 0.05).unwrap();
        assert_eq!(found.of_node, [0, 0, 1, 1, 1, 2, 2, 3, 3, 3, NONE]);
        let (starts, nodes) = found.members();
        assert_eq!((starts, nodes.len()), (vec![0, 2, 5, 7, 10], 10));
    }
}
