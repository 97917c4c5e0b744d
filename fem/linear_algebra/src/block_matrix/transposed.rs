//! Equality of a block matrix with its transposed.

use super::BlockMatrix;

impl BlockMatrix {
    /// Whether the matrix is equal to its transposed to the last bit; false where it does not have the places of its transposed. Of two
    /// unknowns a node it looks for a fourth of the partners that [`CsrMatrix::asymmetry`](crate::CsrMatrix::asymmetry) looks for.
    pub fn equals_transposed(&self) -> bool {
        let (rows, columns) = (self.sparsity.row_sets(), self.sparsity.column_sets());
        let pairs = || (0..rows.len()).flat_map(|a| (a..rows.len()).map(move |b| (a, b)));
        rows == columns && pairs().all(|(a, b)| self.pair_equals_transposed(a, b))
    }

    /// Whether the blocks of a row set and a column set are those of the two the other way round, transposed.
    fn pair_equals_transposed(&self, a: usize, b: usize) -> bool {
        let (own, other) = (self.sparsity.pair(a, b), self.sparsity.pair(b, a));
        let [height, width] = [a, b].map(|set| self.sparsity.row_sets()[set].components);
        if own.blocks() != other.blocks() || own.blocks() == 0 {
            return own.blocks() == other.blocks();
        }
        let [values, partners] = [own, other].map(|pair| &self.values[pair.values()]);
        // Row nodes come in ascending order, so the partner of a block is the next one of its row that has not been met. Of one set
        // with itself a row's partners before the diagonal have met their blocks.
        let mut next = other.pointers().to_vec();
        for node in 0..own.pointers().len() - 1 {
            let range = own.range(node);
            for place in if a == b { next[node] } else { range.start }..range.end {
                let column = own.columns[place] as usize;
                let partner = next[column];
                if partner >= other.pointers()[column + 1] || other.columns[partner] as usize != node {
                    return false;
                }
                next[column] += 1;
                let block = &values[place * height * width..][..height * width];
                let turned = &partners[partner * height * width..][..height * width];
                for (i, row) in block.chunks_exact(width).enumerate() {
                    if row.iter().enumerate().any(|(j, value)| *value != turned[j * height + i]) {
                        return false;
                    }
                }
            }
        }
        true
    }
}
