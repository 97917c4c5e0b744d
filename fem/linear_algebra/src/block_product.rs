//! Products and transposes of block matrices over one set of nodes each.

use std::ops::Range;
use std::sync::Arc;

use super::block_matrix::BlockMatrix;
use super::block_sparsity::{BlockRows, BlockSparsity, NodeSet};
use super::error::{LinearAlgebraError, check_size};
use crate::threads::Threads;

/// The only pair of sets of a matrix.
pub(super) struct Single<'a> {
    pub(super) rows: NodeSet,
    pub(super) columns: NodeSet,
    pub(super) pair: &'a BlockRows,
    pub(super) values: &'a [f64],
}

impl<'a> Single<'a> {
    /// # Errors
    /// If the matrix has several sets of rows or columns.
    pub(super) fn of(matrix: &'a BlockMatrix) -> Result<Self, LinearAlgebraError> {
        let sparsity = matrix.sparsity();
        check_size("the list of row sets", 1, sparsity.row_sets().len())?;
        check_size("the list of column sets", 1, sparsity.column_sets().len())?;
        let (rows, columns) = (sparsity.row_sets()[0], sparsity.column_sets()[0]);
        Ok(Single { rows, columns, pair: sparsity.pair(0, 0), values: matrix.values() })
    }

    /// Numbers in a block.
    pub(super) fn block(&self) -> usize {
        self.rows.components * self.columns.components
    }

    /// The columns of a row and its blocks.
    pub(super) fn row(&self, node: usize) -> impl Iterator<Item = (u32, &'a [f64])> {
        let range = self.pair.range(node);
        let blocks =
            self.values[range.start * self.block()..range.end * self.block()].chunks_exact(self.block());
        self.pair.columns[range].iter().copied().zip(blocks)
    }
}

/// A matrix over one set of row nodes and one of column nodes from its rows of blocks.
pub(super) fn block_matrix(
    (rows, height): (usize, usize),
    (columns, width): (usize, usize),
    pointers: Vec<usize>,
    indices: Vec<u32>,
    values: Vec<f64>,
) -> Result<BlockMatrix, LinearAlgebraError> {
    let (rows, columns) = (NodeSet::in_a_row([(rows, height)]), NodeSet::in_a_row([(columns, width)]));
    let sparsity = BlockSparsity::new(rows, columns, vec![vec![BlockRows::new(pointers, indices)]])?;
    BlockMatrix::from_values(&Arc::new(sparsity), values)
}

/// The transposed matrix.
///
/// # Errors
/// If there are several sets of rows or columns.
pub fn transpose(matrix: &BlockMatrix) -> Result<BlockMatrix, LinearAlgebraError> {
    let source = Single::of(matrix)?;
    let (height, width, block) = (source.rows.components, source.columns.components, source.block());
    let mut pointers = vec![0_usize; source.columns.nodes + 1];
    for &column in &source.pair.columns {
        pointers[column as usize + 1] += 1;
    }
    for column in 0..source.columns.nodes {
        pointers[column + 1] += pointers[column];
    }
    let mut next = pointers.clone();
    let mut indices = vec![0_u32; source.pair.blocks()];
    let mut values = vec![0.0; source.values.len()];
    for row in 0..source.rows.nodes {
        for (column, from) in source.row(row) {
            let place = next[column as usize];
            next[column as usize] += 1;
            indices[place] = row as u32;
            let to = &mut values[place * block..(place + 1) * block];
            for i in 0..height {
                for j in 0..width {
                    to[j * height + i] = from[i * width + j];
                }
            }
        }
    }
    block_matrix((source.columns.nodes, width), (source.rows.nodes, height), pointers, indices, values)
}

/// A B. Rows are computed one by one, so the numbers do not depend on the threads.
///
/// # Errors
/// If the sizes do not fit or there are several sets of rows or columns.
pub fn multiply(
    a: &BlockMatrix,
    b: &BlockMatrix,
    threads: Threads,
) -> Result<BlockMatrix, LinearAlgebraError> {
    let (left, right) = (Single::of(a)?, Single::of(b)?);
    check_size("the set of rows of the second factor", left.columns.nodes, right.rows.nodes)?;
    check_size("a block of the second factor", left.columns.components, right.rows.components)?;
    let length = left.rows.nodes.div_ceil(threads.for_work(a.values().len())).max(1);
    let parts: Vec<Range<usize>> = (0..left.rows.nodes)
        .step_by(length)
        .map(|first| first..(first + length).min(left.rows.nodes))
        .collect();
    let found = threads.run(parts, |rows| match right.columns.components {
        1 => Rows::multiply::<1>(&left, &right, rows),
        2 => Rows::multiply::<2>(&left, &right, rows),
        3 => Rows::multiply::<3>(&left, &right, rows),
        6 => Rows::multiply::<6>(&left, &right, rows),
        _ => Rows::multiply::<0>(&left, &right, rows),
    });
    let blocks = found.iter().map(|part| part.indices.len()).sum();
    let block = left.rows.components * right.columns.components;
    let (mut pointers, mut indices) = (vec![0_usize], Vec::with_capacity(blocks));
    let mut values = Vec::with_capacity(blocks * block);
    for part in found {
        let first = indices.len();
        pointers.extend(part.ends.iter().map(|end| first + end));
        indices.extend(part.indices);
        values.extend(part.values);
    }
    block_matrix(
        (left.rows.nodes, left.rows.components),
        (right.columns.nodes, right.columns.components),
        pointers,
        indices,
        values,
    )
}

/// Some rows of a product.
#[derive(Default)]
struct Rows {
    ends: Vec<usize>,
    indices: Vec<u32>,
    values: Vec<f64>,
}

impl Rows {
    /// WIDTH: the components of the columns, 0 where the compiler does not know them.
    fn multiply<const WIDTH: usize>(left: &Single, right: &Single, rows: Range<usize>) -> Self {
        const NONE: u32 = u32::MAX;
        let width = if WIDTH == 0 { right.columns.components } else { WIDTH };
        let (height, inner) = (left.rows.components, left.columns.components);
        let block = height * width;
        let mut result = Rows::default();
        let mut place = vec![NONE; right.columns.nodes];
        let (mut columns, mut sums): (Vec<u32>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut order: Vec<u32> = Vec::new();
        for row in rows {
            columns.clear();
            sums.clear();
            for (middle, a) in left.row(row) {
                for (column, b) in right.row(middle as usize) {
                    let slot = &mut place[column as usize];
                    if *slot == NONE {
                        *slot = columns.len() as u32;
                        columns.push(column);
                        sums.resize(sums.len() + block, 0.0);
                    }
                    let sum = &mut sums[*slot as usize * block..][..block];
                    for (sum, a) in sum.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
                        for (factor, b) in a.iter().zip(b.chunks_exact(width)) {
                            for (sum, b) in sum.iter_mut().zip(b) {
                                *sum += factor * b;
                            }
                        }
                    }
                }
            }
            order.clear();
            order.extend(0..columns.len() as u32);
            order.sort_unstable_by_key(|&slot| columns[slot as usize]);
            for &slot in &order {
                let column = columns[slot as usize];
                place[column as usize] = NONE;
                result.indices.push(column);
                result.values.extend_from_slice(&sums[slot as usize * block..][..block]);
            }
            result.ends.push(result.indices.len());
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of 2 × 3 blocks on 5 × 4 nodes with irregular entries.
    fn sample() -> BlockMatrix {
        let pointers = vec![0, 2, 3, 3, 6, 7];
        let values = (0..42).map(|k| f64::from(k * k % 23) - 7.0).collect();
        block_matrix((5, 2), (4, 3), pointers, vec![0, 2, 1, 0, 1, 3, 3], values).unwrap()
    }

    #[test]
    fn products_and_transposes_act_as_they_should() {
        let a = sample();
        let at = transpose(&a).unwrap();
        assert_eq!(transpose(&at).unwrap(), a);
        let x: Vec<f64> = (0..10).map(|k| f64::from(k) - 4.0).collect();
        assert_eq!(at.multiply(&x).unwrap(), a.multiply_transposed(&x).unwrap());
        for threads in [1, 3] {
            let product = multiply(&a, &at, Threads::new(threads)).unwrap();
            assert_eq!(product.multiply(&x).unwrap(), a.multiply(&at.multiply(&x).unwrap()).unwrap());
            assert_eq!(product.asymmetry().unwrap(), 0.0);
        }
        assert!(multiply(&a, &a, Threads::ONE).is_err());
    }
}
