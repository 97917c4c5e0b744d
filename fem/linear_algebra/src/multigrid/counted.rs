//! Counted work of multigrid: numbers that are read or multiplied, and how threads share them.

use super::super::block_matrix::BlockMatrix;
use super::super::block_product::Single;
use super::super::error::LinearAlgebraError;
use super::super::task_graph::SharedWork;
use crate::threads::Threads;

/// Work that is divided evenly where there are enough numbers for several threads.
pub(super) fn divided(work: usize, numbers: usize) -> SharedWork {
    SharedWork::of_parts(|threads| {
        let parts = Threads::new(threads).for_work(numbers);
        vec![work as f64 / parts as f64; parts]
    })
}

/// A product with a vector: rows of nodes in parts of equal length.
pub(super) fn product_with_vector(matrix: &BlockMatrix) -> Result<SharedWork, LinearAlgebraError> {
    let Single { rows, pair, .. } = Single::of(matrix)?;
    let per_block = matrix.values().len().checked_div(pair.blocks()).unwrap_or(0);
    Ok(SharedWork::of_parts(|threads| {
        let parts = Threads::new(threads).for_work(matrix.values().len());
        let length = rows.nodes.div_ceil(parts).max(1);
        let entries = |first: usize| {
            let last = (first + length).min(rows.nodes);
            (first..last).map(|node| pair.range(node).len()).sum::<usize>() * per_block
        };
        (0..rows.nodes).step_by(length).map(|first| entries(first) as f64).collect()
    }))
}

/// A product of two matrices.
pub(super) fn product(a: &BlockMatrix, b: &BlockMatrix) -> Result<SharedWork, LinearAlgebraError> {
    let (left, right) = (Single::of(a)?, Single::of(b)?);
    let of_block = |middle: &u32| right.pair.range(*middle as usize).len();
    let blocks: usize = left.pair.columns.iter().map(of_block).sum();
    Ok(divided(blocks * left.block() * right.columns.components, a.values().len()))
}

/// A transposed matrix: threads share the values, and one finds their places.
pub(super) fn transposition(matrix: &BlockMatrix) -> Result<SharedWork, LinearAlgebraError> {
    let values = divided(matrix.values().len(), matrix.values().len());
    Ok(values.then(&SharedWork::alone(Single::of(matrix)?.pair.blocks() as f64)))
}
