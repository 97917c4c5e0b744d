//! Sparse matrices of small dense blocks, one per pair of nodes that are coupled.

mod terms;
mod transposed;

use std::sync::Arc;

use super::asymmetry::{Asymmetry, sizes_of_unknowns};
use super::block_sparsity::{BlockRows, BlockSparsity, NodeSet};
use super::csr::CsrMatrix;
use super::error::{LinearAlgebraError, check_size};
use super::large_pages::zeros;
use crate::threads::Threads;

/// A real sparse matrix over the unknowns of several spaces: blocks of row components × column components on a
/// shared [`BlockSparsity`]. The blocks of each pair of spaces follow each other, row node after row node, each
/// block row-major. It holds one index per block where a [`CsrMatrix`] has one per entry.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    sparsity: Arc<BlockSparsity>,
    values: Vec<f64>,
    /// Of each pair of spaces and row node whether all values are known to be zero; empty where nothing is known.
    zero_rows: Vec<bool>,
}

/// Matrices with the same positions and values.
impl PartialEq for BlockMatrix {
    fn eq(&self, other: &Self) -> bool {
        self.sparsity == other.sparsity && self.values == other.values
    }
}

impl BlockMatrix {
    /// The zero matrix.
    pub fn zero(sparsity: &Arc<BlockSparsity>) -> Self {
        let zero_rows = vec![true; sparsity.pair_rows_count()];
        BlockMatrix { sparsity: sparsity.clone(), values: zeros(sparsity.entries()), zero_rows }
    }

    /// A matrix with these values at these positions.
    ///
    /// # Errors
    /// If the number of values is not the number of entries.
    pub fn from_values(sparsity: &Arc<BlockSparsity>, values: Vec<f64>) -> Result<Self, LinearAlgebraError> {
        check_size("the list of matrix values", sparsity.entries(), values.len())?;
        Ok(BlockMatrix { sparsity: sparsity.clone(), values, zero_rows: vec![] })
    }

    /// The positions.
    #[inline]
    pub fn sparsity(&self) -> &Arc<BlockSparsity> {
        &self.sparsity
    }

    /// Number of scalar rows.
    #[inline]
    pub fn rows(&self) -> usize {
        self.sparsity.row_count()
    }

    /// Number of scalar columns.
    #[inline]
    pub fn columns(&self) -> usize {
        self.sparsity.column_count()
    }

    /// All values, in the order of [`BlockSparsity`].
    #[inline]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All values, to be overwritten.
    #[inline]
    pub fn values_mut(&mut self) -> &mut [f64] {
        self.zero_rows.clear();
        &mut self.values
    }

    /// All values, and of each pair of spaces and row node ([`BlockSparsity::pair_rows`]) whether its values are known to be zero: who
    /// sets rows to zero may pass these by, and who writes to one says that it is not zero any more.
    pub fn values_and_zero_rows(&mut self) -> (&mut [f64], &mut [bool]) {
        self.zero_rows.resize(self.sparsity.pair_rows_count(), false);
        (&mut self.values, &mut self.zero_rows)
    }

    /// Bytes of the values and their positions.
    pub fn memory(&self) -> usize {
        size_of_val(&self.values[..]) + self.sparsity.memory()
    }

    /// Columns and values of a scalar row, in ascending columns.
    ///
    /// # Panics
    /// If `row` is not below [`BlockMatrix::rows`].
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        self.sparsity.row(row).map(|(column, place)| (column, self.values[place]))
    }

    /// Entry (row, column); zero where nothing is stored.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.sparsity.find(row, column).map_or(0.0, |place| self.values[place])
    }

    /// The diagonal, `min(rows, columns)` values.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows().min(self.columns())).map(|i| self.get(i, i)).collect()
    }

    /// A x.
    ///
    /// # Errors
    /// If `x` does not have one entry per column.
    pub fn multiply(&self, x: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        let mut y = vec![0.0; self.rows()];
        self.multiply_on(Threads::ONE, x, &mut y)?;
        Ok(y)
    }

    /// y = A x on some threads; the same numbers for each number of threads.
    ///
    /// # Errors
    /// If the sizes of `x` and `y` are not the numbers of columns and rows.
    pub fn multiply_on(&self, threads: Threads, x: &[f64], y: &mut [f64]) -> Result<(), LinearAlgebraError> {
        check_size("the vector to multiply", self.columns(), x.len())?;
        check_size("the product", self.rows(), y.len())?;
        let mut rest = y;
        for (row_set, rows) in self.sparsity.row_sets().iter().enumerate() {
            let (own, later) = rest.split_at_mut(rows.nodes * rows.components);
            rest = later;
            let length = rows.nodes.div_ceil(threads.for_work(self.values.len())).max(1);
            let parts = own.chunks_mut(length * rows.components.max(1)).enumerate().collect();
            threads.run(parts, |(part, y)| {
                y.fill(0.0);
                for (column_set, columns) in self.sparsity.column_sets().iter().enumerate() {
                    let pair = self.sparsity.pair(row_set, column_set);
                    let (values, x) = (&self.values[pair.values()], &x[columns.unknowns()]);
                    multiply_rows((rows, columns), pair, values, part * length, x, y);
                }
            });
        }
        Ok(())
    }

    /// Aᵀ x.
    ///
    /// # Errors
    /// If `x` does not have one entry per row.
    pub fn multiply_transposed(&self, x: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector to multiply", self.rows(), x.len())?;
        let mut y = vec![0.0; self.columns()];
        for (row_set, rows) in self.sparsity.row_sets().iter().enumerate() {
            for (column_set, columns) in self.sparsity.column_sets().iter().enumerate() {
                let pair = self.sparsity.pair(row_set, column_set);
                let (block, width) = (rows.components * columns.components, columns.components);
                let (values, y) = (&self.values[pair.values()], &mut y[columns.unknowns()]);
                for (node, x) in x[rows.unknowns()].chunks_exact(rows.components.max(1)).enumerate() {
                    let range = pair.range(node);
                    let blocks = values[range.start * block..range.end * block].chunks_exact(block);
                    for (column, block) in pair.columns[range].iter().zip(blocks) {
                        let y = &mut y[*column as usize * width..][..width];
                        for (x, values) in x.iter().zip(block.chunks_exact(width)) {
                            for (y, value) in y.iter_mut().zip(values) {
                                *y += value * x;
                            }
                        }
                    }
                }
            }
        }
        Ok(y)
    }

    /// Largest |a_ij − a_ji| relative to the size of the entry, as in [`CsrMatrix::asymmetry`].
    ///
    /// # Errors
    /// If the matrix is not square.
    pub fn asymmetry(&self) -> Result<f64, LinearAlgebraError> {
        check_size("the set of columns of a square matrix", self.rows(), self.columns())?;
        if self.values.iter().any(|value| value.is_nan()) {
            return Ok(f64::NAN);
        }
        let sizes = sizes_of_unknowns(self.diagonal(), |row, visit| {
            self.row(row).for_each(|(column, value)| visit(column, value));
        });
        let mut asymmetry = Asymmetry { sizes: &sizes, most: 0.0 };
        for row in 0..self.rows() {
            for (column, value) in self.row(row) {
                asymmetry.visit((row, column), value, self.get(column, row));
            }
        }
        Ok(asymmetry.most)
    }

    /// This matrix with an index per entry; all such matrices share one pattern.
    pub fn to_csr(&self) -> CsrMatrix {
        let mut values = Vec::with_capacity(self.values.len());
        for row in 0..self.rows() {
            self.sparsity.visit_row(row, |_, place, width| {
                values.extend_from_slice(&self.values[place..place + width]);
            });
        }
        CsrMatrix::of_checked(self.sparsity.pattern(), values)
    }

    /// This matrix with an index per entry; where all blocks are single entries of one pair of spaces, without a copy.
    pub fn into_csr(self) -> CsrMatrix {
        let scalar = |sets: &[NodeSet]| matches!(sets, [NodeSet { components: 1, .. }]);
        if scalar(self.sparsity.row_sets()) && scalar(self.sparsity.column_sets()) {
            return CsrMatrix::of_checked(self.sparsity.pattern(), self.values);
        }
        self.to_csr()
    }
}

impl From<CsrMatrix> for BlockMatrix {
    /// Blocks of one entry each.
    fn from(matrix: CsrMatrix) -> Self {
        let sparsity = Arc::new(BlockSparsity::from(matrix.pattern()));
        BlockMatrix { sparsity, values: matrix.into_values(), zero_rows: vec![] }
    }
}

/// y += A x on some row nodes of a pair, from `first` on.
fn multiply_rows(
    (rows, columns): (&NodeSet, &NodeSet),
    pair: &BlockRows,
    values: &[f64],
    first: usize,
    x: &[f64],
    y: &mut [f64],
) {
    match (rows.components, columns.components) {
        (1, 1) => multiply_blocks::<1, 1>(pair, values, first, x, y),
        (2, 2) => multiply_blocks::<2, 2>(pair, values, first, x, y),
        (2, 3) => multiply_blocks::<2, 3>(pair, values, first, x, y),
        (3, 2) => multiply_blocks::<3, 2>(pair, values, first, x, y),
        (3, 3) => multiply_blocks::<3, 3>(pair, values, first, x, y),
        (3, 6) => multiply_blocks::<3, 6>(pair, values, first, x, y),
        (6, 3) => multiply_blocks::<6, 3>(pair, values, first, x, y),
        (6, 6) => multiply_blocks::<6, 6>(pair, values, first, x, y),
        (height, width) => {
            let block = height * width;
            for (node, y) in y.chunks_exact_mut(height.max(1)).enumerate() {
                let range = pair.range(first + node);
                let blocks = values[range.start * block..range.end * block].chunks_exact(block.max(1));
                for (column, block) in pair.columns[range].iter().zip(blocks) {
                    let x = &x[*column as usize * width..][..width];
                    for (y, values) in y.iter_mut().zip(block.chunks_exact(width)) {
                        for (value, x) in values.iter().zip(x) {
                            *y += value * x;
                        }
                    }
                }
            }
        }
    }
}

/// The same for blocks of a size that the compiler knows.
fn multiply_blocks<const HEIGHT: usize, const WIDTH: usize>(
    pair: &BlockRows,
    values: &[f64],
    first: usize,
    x: &[f64],
    y: &mut [f64],
) {
    let (rows, _) = values.as_chunks::<WIDTH>();
    let (blocks, _) = rows.as_chunks::<HEIGHT>();
    let (x, _) = x.as_chunks::<WIDTH>();
    let (y, _) = y.as_chunks_mut::<HEIGHT>();
    for (node, y) in y.iter_mut().enumerate() {
        let range = pair.range(first + node);
        let mut sums = *y;
        for (column, block) in pair.columns[range.clone()].iter().zip(&blocks[range]) {
            let x = &x[*column as usize];
            for (sum, values) in sums.iter_mut().zip(block) {
                for (value, x) in values.iter().zip(x) {
                    *sum += value * x;
                }
            }
        }
        *y = sums;
    }
}

#[cfg(test)]
mod tests;
