//! Smoothed aggregation: prolongations that reproduce the near-null space, smoothed by one step of Jacobi's method.

use super::super::block_matrix::BlockMatrix;
use super::super::block_product::{Single, block_matrix, multiply};
use super::super::error::{LinearAlgebraError, check_size};
use super::aggregation::{Aggregates, NONE};
use super::diagonal::BlockDiagonal;
use crate::threads::Threads;

/// A column that keeps at most this part of its length after orthogonalisation depends on the columns before it.
const DEPENDENT: f64 = 1e-6;

/// The prolongation P from aggregates to nodes with P N_c = N, and N_c, for a near-null space N given as vectors. A node
/// of the coarser level has one unknown per vector. The columns of P are orthonormal, or zero where the vectors are
/// linearly dependent on an aggregate (a single node has no rotations).
///
/// # Errors
/// If a vector has the wrong size.
pub(super) fn tentative(
    aggregates: &Aggregates,
    components: usize,
    vectors: &[Vec<f64>],
) -> Result<(BlockMatrix, Vec<Vec<f64>>), LinearAlgebraError> {
    let (nodes, width) = (aggregates.of_node.len(), vectors.len());
    for vector in vectors {
        check_size("a near-null vector", nodes * components, vector.len())?;
    }
    let (starts, members) = aggregates.members();
    let block = components * width;
    // Blocks of the nodes in the order of the nodes; those without an aggregate have none.
    let mut pointers = vec![0; nodes + 1];
    for (node, aggregate) in aggregates.of_node.iter().enumerate() {
        pointers[node + 1] = pointers[node] + usize::from(*aggregate != NONE);
    }
    let indices: Vec<u32> =
        aggregates.of_node.iter().copied().filter(|aggregate| *aggregate != NONE).collect();
    let mut values = vec![0.0; indices.len() * block];
    let mut coarse = vec![vec![0.0; aggregates.count * width]; width];
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); width];
    for aggregate in 0..aggregates.count {
        let members = &members[starts[aggregate]..starts[aggregate + 1]];
        for (column, vector) in columns.iter_mut().zip(vectors) {
            column.clear();
            for &node in members {
                column.extend_from_slice(&vector[node as usize * components..][..components]);
            }
        }
        for k in 0..width {
            let (done, rest) = columns.split_at_mut(k);
            let column = &mut rest[0];
            let length = norm(column);
            for _ in 0..2 {
                for (j, earlier) in done.iter().enumerate() {
                    let part: f64 = earlier.iter().zip(column.iter()).map(|(a, b)| a * b).sum();
                    coarse[k][aggregate * width + j] += part;
                    column.iter_mut().zip(earlier).for_each(|(value, other)| *value -= part * other);
                }
            }
            let left = norm(column);
            if left <= DEPENDENT * length {
                column.fill(0.0);
            } else {
                coarse[k][aggregate * width + k] = left;
                column.iter_mut().for_each(|value| *value /= left);
            }
        }
        for (place, &node) in members.iter().enumerate() {
            let target = &mut values[pointers[node as usize] * block..][..block];
            for (k, column) in columns.iter().enumerate() {
                for i in 0..components {
                    target[i * width + k] = column[place * components + i];
                }
            }
        }
    }
    let prolongation =
        block_matrix((nodes, components), (aggregates.count, width), pointers, indices, values)?;
    Ok((prolongation, coarse))
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// (I − ω D⁻¹ A) P.
///
/// # Errors
/// If the sizes do not fit.
pub(super) fn smoothed(
    matrix: &BlockMatrix,
    diagonal: &BlockDiagonal,
    prolongation: &BlockMatrix,
    omega: f64,
    threads: Threads,
) -> Result<BlockMatrix, LinearAlgebraError> {
    let mut product = multiply(matrix, prolongation, threads)?;
    let tentative = Single::of(prolongation)?;
    let sparsity = product.sparsity().clone();
    let (height, width) = (tentative.rows.components, tentative.columns.components);
    let block = height * width;
    let pair = sparsity.pair(0, 0);
    pair.on_threads(threads, (product.values_mut(), block), |nodes, values| {
        let first = pair.pointers()[nodes.start];
        let mut copy = vec![0.0; block];
        for node in nodes {
            let inverse = diagonal.block(node);
            for place in pair.range(node) {
                let target = &mut values[(place - first) * block..][..block];
                copy.copy_from_slice(target);
                for i in 0..height {
                    for k in 0..width {
                        let sum: f64 =
                            (0..height).map(|j| inverse[i * height + j] * copy[j * width + k]).sum();
                        target[i * width + k] = -omega * sum;
                    }
                }
            }
            // The node's own aggregate is among the columns, as A has its diagonal.
            for (column, given) in tentative.row(node) {
                if let Some(place) = pair.place(node, column) {
                    let target = &mut values[(place - first) * block..][..block];
                    target.iter_mut().zip(given).for_each(|(target, given)| *target += given);
                }
            }
        }
    });
    Ok(product)
}
