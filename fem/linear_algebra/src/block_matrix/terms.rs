//! The terms a_ij x_j of the rows of a block matrix: their sums, and the sums of their sizes.

use super::BlockMatrix;
use crate::block_sparsity::BlockRows;

impl BlockMatrix {
    /// Calls `visit(row − that of the first node, (A x)_i, (|A| |x|)_i)` for the rows of some nodes of a set, one after
    /// the other.
    pub(crate) fn visit_terms(
        &self,
        set: usize,
        first: usize,
        nodes: usize,
        x: &[f64],
        mut visit: impl FnMut(usize, f64, f64),
    ) {
        let rows = &self.sparsity.row_sets()[set];
        let visit: &mut dyn FnMut(usize, f64, f64) = &mut visit;
        if let [columns] = self.sparsity.column_sets() {
            let pair = self.sparsity.pair(set, 0);
            let nodes = first..first + nodes;
            let values = &self.values[pair.values()];
            match (rows.components, columns.components) {
                (1, 1) => return visit_blocks::<1, 1>(pair, values, nodes, x, visit),
                (2, 2) => return visit_blocks::<2, 2>(pair, values, nodes, x, visit),
                (3, 3) => return visit_blocks::<3, 3>(pair, values, nodes, x, visit),
                _ => (),
            }
        }
        for place in 0..nodes * rows.components {
            let (mut sum, mut size) = (0.0, 0.0);
            let row = rows.offset + first * rows.components + place;
            self.sparsity.visit_row(row, |column, begin, width| {
                let terms = self.values[begin..begin + width].iter().zip(&x[column..column + width]);
                for term in terms.map(|(value, x)| value * x) {
                    (sum, size) = (sum + term, size + term.abs());
                }
            });
            visit(place, sum, size);
        }
    }
}

/// The same for blocks of a size that the compiler knows.
fn visit_blocks<const HEIGHT: usize, const WIDTH: usize>(
    pair: &BlockRows,
    values: &[f64],
    nodes: std::ops::Range<usize>,
    x: &[f64],
    visit: &mut dyn FnMut(usize, f64, f64),
) {
    let (rows, _) = values.as_chunks::<WIDTH>();
    let (blocks, _) = rows.as_chunks::<HEIGHT>();
    let (x, _) = x.as_chunks::<WIDTH>();
    for (number, node) in nodes.enumerate() {
        let range = pair.range(node);
        let (mut sums, mut sizes) = ([0.0; HEIGHT], [0.0; HEIGHT]);
        for (column, block) in pair.columns[range.clone()].iter().zip(&blocks[range]) {
            let x = &x[*column as usize];
            for ((sum, size), values) in sums.iter_mut().zip(&mut sizes).zip(block) {
                for (value, x) in values.iter().zip(x) {
                    let term = value * x;
                    (*sum, *size) = (*sum + term, *size + term.abs());
                }
            }
        }
        for (component, (sum, size)) in sums.iter().zip(&sizes).enumerate() {
            visit(number * HEIGHT + component, *sum, *size);
        }
    }
}
