//! Matrices Cᵀ K C of reduced unknowns: each unknown is a weighted sum of some of them, or none.

use std::ops::Range;
use std::sync::Arc;

use crate::block_matrix::BlockMatrix;
use crate::block_sparsity::BlockSparsity;
use crate::csr::{CsrMatrix, Entry};
use crate::error::{LinearAlgebraError, check_size};
use crate::pattern::SparsityPattern;

/// C, row by row: the reduced unknowns that give each unknown, with their weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    ends: Vec<usize>,
    terms: Vec<(u32, f64)>,
}

impl Weights {
    /// One more unknown by its terms; none where it is prescribed.
    pub fn add(&mut self, terms: impl IntoIterator<Item = (u32, f64)>) {
        self.terms.extend(terms);
        self.ends.push(self.terms.len());
    }

    /// The terms of an unknown.
    pub fn of(&self, unknown: usize) -> &[(u32, f64)] {
        let start = if unknown == 0 { 0 } else { self.ends[unknown - 1] };
        &self.terms[start..self.ends[unknown]]
    }

    /// Entries of Cᵀ A C from those of A, each place once, ascending.
    pub fn reduce(&self, entries: impl IntoIterator<Item = Entry>) -> Vec<Entry> {
        let mut reduced = vec![];
        for Entry { row, column, value } in entries {
            for (row, a) in self.of(row as usize) {
                for (column, b) in self.of(column as usize) {
                    reduced.push(Entry { row: *row, column: *column, value: a * value * b });
                }
            }
        }
        // Stable: sums keep their order.
        reduced.sort_by_key(|entry| (entry.row, entry.column));
        reduced.dedup_by(|next, sum| {
            let is_same = (next.row, next.column) == (sum.row, sum.column);
            if is_same {
                sum.value += next.value;
            }
            is_same
        });
        reduced
    }
}

/// The map from matrices K of one structure to Cᵀ K C. Its pattern is computed once.
#[derive(Clone, Debug)]
pub struct WeightedRestriction {
    source: Arc<BlockSparsity>,
    target: Arc<SparsityPattern>,
    weights: Weights,
    /// For each reduced unknown those that it gives, with the weights: itself first.
    dependent: Vec<Vec<(u32, f64)>>,
}

impl WeightedRestriction {
    /// The map for the reduced unknowns `free`. A known pattern is shared if it is that of Cᵀ K C.
    ///
    /// # Errors
    /// If sizes disagree, or the reduced matrix has too many unknowns.
    pub fn new(
        source: &Arc<BlockSparsity>,
        weights: Weights,
        free: &[usize],
        known: Option<&Arc<SparsityPattern>>,
    ) -> Result<Self, LinearAlgebraError> {
        check_size("the set of rows", weights.ends.len(), source.row_count())?;
        check_size("the set of columns", weights.ends.len(), source.column_count())?;
        let count = free.len();
        let mut dependent: Vec<Vec<(u32, f64)>> = free.iter().map(|own| vec![(*own as u32, 1.0)]).collect();
        for unknown in 0..weights.ends.len() {
            for (number, a) in weights.of(unknown) {
                if free[*number as usize] != unknown {
                    dependent[*number as usize].push((unknown as u32, *a));
                }
            }
        }
        let (mut pointers, mut indices) = (vec![0_usize], Vec::<u32>::new());
        let mut seen = vec![usize::MAX; count];
        for (row, unknowns) in dependent.iter().enumerate() {
            let start = indices.len();
            for (unknown, _) in unknowns {
                source.visit_row(*unknown as usize, |first, _, width| {
                    for column in first..first + width {
                        for (number, _) in weights.of(column) {
                            if std::mem::replace(&mut seen[*number as usize], row) != row {
                                indices.push(*number);
                            }
                        }
                    }
                });
            }
            indices[start..].sort_unstable();
            pointers.push(indices.len());
        }
        // An unknown that others give represents them.
        let cells = source.cells().map(|cells| {
            Arc::new(cells.renumbered(|unknown, visit| {
                weights.of(unknown as usize).iter().for_each(|(number, _)| visit(*number));
            }))
        });
        let target = SparsityPattern::new(count, count, pointers, indices)?.with_cells(cells)?;
        let target = match known.filter(|known| ***known == target) {
            Some(known) => known.clone(),
            None => Arc::new(target),
        };
        Ok(WeightedRestriction { source: source.clone(), target, weights, dependent })
    }

    /// C.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Whether a matrix has the structure that the map was made for.
    pub fn fits(&self, matrix: &BlockMatrix) -> bool {
        Arc::ptr_eq(matrix.sparsity(), &self.source) || **matrix.sparsity() == *self.source
    }

    fn check(&self, matrix: &BlockMatrix) -> Result<(), LinearAlgebraError> {
        match self.fits(matrix) {
            true => Ok(()),
            false => Err(LinearAlgebraError::PatternMismatch { what: "reducing a matrix" }),
        }
    }

    /// Cᵀ K C.
    ///
    /// # Errors
    /// If the matrix does not have the structure that the map was made for.
    pub fn apply(&self, matrix: &BlockMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        self.check(matrix)?;
        let mut values = vec![0.0; self.target.entries()];
        let mut places = vec![0_usize; self.target.columns()];
        for (row, unknowns) in self.dependent.iter().enumerate() {
            for place in self.target.row_range(row) {
                places[self.target.column_indices()[place] as usize] = place;
            }
            for (unknown, a) in unknowns {
                for (column, value) in matrix.row(*unknown as usize) {
                    for (number, b) in self.weights.of(column) {
                        values[places[*number as usize]] += a * value * b;
                    }
                }
            }
        }
        CsrMatrix::from_pattern(&self.target, values)
    }

    /// Entries of Cᵀ (K − K₀) C, where K differs from K₀ at some places only, given as ranges of whole blocks: each entry once, also those
    /// that are zero.
    ///
    /// # Errors
    /// As [`WeightedRestriction::apply`].
    pub fn differences(
        &self,
        matrix: &BlockMatrix,
        base: &BlockMatrix,
        places: &[Range<usize>],
    ) -> Result<Vec<Entry>, LinearAlgebraError> {
        self.check(matrix)?;
        self.check(base)?;
        let mut entries = vec![];
        self.source.visit_places(places, |row, column, place| {
            let value = matrix.values()[place] - base.values()[place];
            entries.push(Entry { row: row as u32, column: column as u32, value });
        });
        Ok(self.weights.reduce(entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three unknowns, the second the mean of the others.
    fn weights() -> Weights {
        let mut weights = Weights::default();
        weights.add([(0, 1.0)]);
        weights.add([(0, 0.5), (1, 0.5)]);
        weights.add([(1, 1.0)]);
        weights
    }

    fn full(scale: f64) -> BlockMatrix {
        let triplets: Vec<_> =
            (0..9).map(|k| (k / 3, k % 3, scale * (10 * (k / 3) + k % 3 + 1) as f64)).collect();
        CsrMatrix::from_triplets(3, 3, &triplets).unwrap().into()
    }

    #[test]
    fn a_reduced_matrix_is_the_product_and_its_differences_those_of_products() {
        let matrix = full(1.0);
        let map = WeightedRestriction::new(matrix.sparsity(), weights(), &[0, 2], None).unwrap();
        let reduced = map.apply(&matrix).unwrap();
        let c = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];
        let product = |scale: f64, i: usize, j: usize| -> f64 {
            (0..9).map(|k| c[k / 3][i] * scale * (10 * (k / 3) + k % 3 + 1) as f64 * c[k % 3][j]).sum()
        };
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((reduced.get(i, j) - product(1.0, i, j)).abs() < 1e-14);
        }
        let differences = map.differences(&full(3.0), &matrix, std::slice::from_ref(&(0..9))).unwrap();
        assert_eq!(differences.len(), 4);
        for Entry { row, column, value } in differences {
            assert!((value - product(2.0, row as usize, column as usize)).abs() < 1e-13);
        }
        let again = WeightedRestriction::new(matrix.sparsity(), weights(), &[0, 2], Some(reduced.pattern()));
        assert!(Arc::ptr_eq(again.unwrap().apply(&matrix).unwrap().pattern(), reduced.pattern()));
        let other = BlockMatrix::from(CsrMatrix::from_triplets(3, 3, &[(0, 0, 1.0)]).unwrap());
        assert!(map.apply(&other).is_err());
    }
}
