//! Products and transposes of block matrices over one set of nodes each.

use std::ops::Range;
use std::sync::Arc;

use super::block_matrix::BlockMatrix;
use super::block_sparsity::{BlockRows, BlockSparsity, NodeSet};
use super::error::{LinearAlgebraError, check_size};
use super::large_pages::zeros;
use super::vector::in_pieces;
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
    of_rows((rows, height), (columns, width), BlockRows::new(pointers, indices), values)
}

fn of_rows(
    rows: (usize, usize),
    columns: (usize, usize),
    blocks: BlockRows,
    values: Vec<f64>,
) -> Result<BlockMatrix, LinearAlgebraError> {
    let (rows, columns) = (NodeSet::in_a_row([rows]), NodeSet::in_a_row([columns]));
    let sparsity = BlockSparsity::new(rows, columns, vec![vec![blocks]])?;
    BlockMatrix::from_values(&Arc::new(sparsity), values)
}

/// The transposed matrix, on some threads.
///
/// # Errors
/// If there are several sets of rows or columns.
pub fn transpose(matrix: &BlockMatrix, threads: Threads) -> Result<BlockMatrix, LinearAlgebraError> {
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
    // The place from which each block comes.
    let mut origins = vec![0_usize; source.pair.blocks()];
    for row in 0..source.rows.nodes {
        for place in source.pair.range(row) {
            let next = &mut next[source.pair.columns[place] as usize];
            indices[*next] = row as u32;
            origins[*next] = place;
            *next += 1;
        }
    }
    let mut values = zeros(source.values.len());
    in_pieces(threads, &mut values, block, |first, values| {
        for (to, origin) in values.chunks_exact_mut(block).zip(&origins[first / block..]) {
            let from = &source.values[origin * block..(origin + 1) * block];
            for i in 0..height {
                for j in 0..width {
                    to[j * height + i] = from[i * width + j];
                }
            }
        }
    });
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
    let ranges = left.pair.parts(threads.for_work(a.values().len()));
    let found = threads.run(ranges, |rows| columns_of_product(&left, &right, rows));
    let mut pointers = Vec::with_capacity(left.rows.nodes + 1);
    let mut columns = Vec::with_capacity(found.iter().map(|(_, columns)| columns.len()).sum());
    pointers.push(0);
    for (ends, of_part) in found {
        let first = columns.len();
        pointers.extend(ends.iter().map(|end| first + end));
        columns.extend(of_part);
    }
    // A factor without blocks has no pointers, and its rows none to count.
    pointers.resize(left.rows.nodes + 1, columns.len());
    let product = BlockRows::new(pointers, columns);
    let (height, width) = (left.rows.components, right.columns.components);
    let mut values = zeros(product.blocks() * height * width);
    product.on_threads(threads, (&mut values, height * width), |rows, values| match width {
        1 => multiply_rows::<1>(&left, &right, &product, rows, values),
        2 => multiply_rows::<2>(&left, &right, &product, rows, values),
        3 => multiply_rows::<3>(&left, &right, &product, rows, values),
        6 => multiply_rows::<6>(&left, &right, &product, rows, values),
        _ => multiply_rows::<0>(&left, &right, &product, rows, values),
    });
    of_rows((left.rows.nodes, height), (right.columns.nodes, width), product, values)
}

/// Marks a column that a row does not have.
const NONE: u32 = u32::MAX;

/// The columns of some rows of a product, ascending, and where each row ends among them.
fn columns_of_product(left: &Single, right: &Single, rows: Range<usize>) -> (Vec<usize>, Vec<u32>) {
    let (mut ends, mut columns) = (Vec::with_capacity(rows.len()), Vec::new());
    let mut last_row = vec![NONE; right.columns.nodes];
    for row in rows {
        let first = columns.len();
        for middle in left.pair.row(row) {
            for &column in right.pair.row(*middle as usize) {
                if std::mem::replace(&mut last_row[column as usize], row as u32) != row as u32 {
                    columns.push(column);
                }
            }
        }
        columns[first..].sort_unstable();
        ends.push(columns.len());
    }
    (ends, columns)
}

/// Some rows of a product. WIDTH: the components of the columns, 0 where the compiler does not know them.
fn multiply_rows<const WIDTH: usize>(
    left: &Single,
    right: &Single,
    product: &BlockRows,
    rows: Range<usize>,
    values: &mut [f64],
) {
    let width = if WIDTH == 0 { right.columns.components } else { WIDTH };
    let (height, inner) = (left.rows.components, left.columns.components);
    let block = height * width;
    let mut place = vec![NONE; right.columns.nodes];
    let mut rest = values;
    for row in rows {
        let columns = product.row(row);
        let (sums, later) = rest.split_at_mut(columns.len() * block);
        rest = later;
        for (slot, column) in columns.iter().enumerate() {
            place[*column as usize] = slot as u32;
        }
        for (middle, a) in left.row(row) {
            for (column, b) in right.row(middle as usize) {
                let sum = &mut sums[place[column as usize] as usize * block..][..block];
                for (sum, a) in sum.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
                    for (factor, b) in a.iter().zip(b.chunks_exact(width)) {
                        for (sum, b) in sum.iter_mut().zip(b) {
                            *sum += factor * b;
                        }
                    }
                }
            }
        }
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
    fn large_products_do_not_depend_on_threads() {
        // Rows with many blocks first, so that threads get different numbers of rows.
        let (mut pointers, mut indices) = (vec![0], Vec::new());
        for row in 0..900_usize {
            indices.extend((0..if row < 90 { 60 } else { 7 }).map(|k| (row % 5 + 10 * k) as u32));
            pointers.push(indices.len());
        }
        let values: Vec<f64> = (0..6 * indices.len()).map(|k| (k as f64 * 0.37).sin()).collect();
        let a = block_matrix((900, 2), (600, 3), pointers, indices, values).unwrap();
        let at = transpose(&a, Threads::ONE).unwrap();
        let product = multiply(&a, &at, Threads::ONE).unwrap();
        for threads in [2, 3, 7, 16].map(Threads::new) {
            assert_eq!(transpose(&a, threads).unwrap(), at);
            assert_eq!(multiply(&a, &at, threads).unwrap(), product);
        }
        let x: Vec<f64> = (0..1800).map(|k| f64::from(k % 11) - 5.0).collect();
        let expected = a.multiply(&at.multiply(&x).unwrap()).unwrap();
        let found = product.multiply(&x).unwrap();
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-10), "{found:?}");
    }

    #[test]
    fn products_and_transposes_act_as_they_should() {
        let a = sample();
        let at = transpose(&a, Threads::ONE).unwrap();
        assert_eq!(transpose(&at, Threads::new(2)).unwrap(), a);
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
