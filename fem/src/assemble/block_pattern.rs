//! Which matrix entries a form can touch: nodes that share a cell, for each pair of test and trial space.

use std::sync::Arc;

use crate::linear_algebra::{LinearAlgebraError, SparsityPattern};
use crate::space::Space;

/// The sparsity pattern of a matrix over the unknowns of several spaces in a row, with what is needed to
/// find the entries of a node pair.
#[derive(Clone, Debug)]
pub struct BlockPattern {
    pattern: Arc<SparsityPattern>,
    /// First row of each test space.
    row_offsets: Vec<usize>,
    /// First column of each trial space.
    column_offsets: Vec<usize>,
    /// `adjacency[test][trial]`: the nodes of the trial space that share a cell with a node.
    adjacency: Vec<Vec<Adjacency>>,
    test_components: Vec<usize>,
    trial_components: Vec<usize>,
}

/// Neighbours of each node, in compressed rows, sorted.
#[derive(Clone, Debug)]
struct Adjacency {
    pointers: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    fn new<const D: usize>(test: &Space<D>, trial: &Space<D>) -> Self {
        let cells = test.mesh.cell_count();
        // Cells around each test node, then the union of their trial nodes.
        let mut counts = vec![0_usize; test.node_count() + 1];
        for &node in test.cell_nodes.iter() {
            counts[node as usize + 1] += 1;
        }
        for node in 0..test.node_count() {
            counts[node + 1] += counts[node];
        }
        let mut around = vec![0_u32; test.cell_nodes.len()];
        let mut next = counts.clone();
        for cell in 0..cells {
            for &node in test.cell_nodes(cell) {
                around[next[node as usize]] = cell as u32;
                next[node as usize] += 1;
            }
        }
        let mut pointers = vec![0];
        let mut neighbours: Vec<u32> = Vec::new();
        let mut seen_by = vec![u32::MAX; trial.node_count()];
        for node in 0..test.node_count() {
            let start = neighbours.len();
            for &cell in &around[counts[node]..counts[node + 1]] {
                for &other in trial.cell_nodes(cell as usize) {
                    if seen_by[other as usize] != node as u32 {
                        seen_by[other as usize] = node as u32;
                        neighbours.push(other);
                    }
                }
            }
            neighbours[start..].sort_unstable();
            pointers.push(neighbours.len());
        }
        Adjacency { pointers, neighbours }
    }

    fn row(&self, node: usize) -> &[u32] {
        &self.neighbours[self.pointers[node]..self.pointers[node + 1]]
    }
}

impl BlockPattern {
    /// The pattern for test and trial spaces on one mesh.
    ///
    /// # Errors
    /// When the matrix is too large to be numbered.
    pub fn new<const D: usize>(
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<Self, LinearAlgebraError> {
        let mut adjacency: Vec<Vec<Adjacency>> = Vec::new();
        for test in tests {
            adjacency.push(trials.iter().map(|trial| Adjacency::new(test, trial)).collect());
        }
        let offsets = |spaces: &[&Arc<Space<D>>]| {
            let mut offsets = vec![0];
            for space in spaces {
                offsets.push(offsets[offsets.len() - 1] + space.unknowns());
            }
            offsets
        };
        let components = |spaces: &[&Arc<Space<D>>]| spaces.iter().map(|space| space.components()).collect();
        let (row_offsets, column_offsets) = (offsets(tests), offsets(trials));
        let (test_components, trial_components): (Vec<usize>, Vec<usize>) =
            (components(tests), components(trials));
        let (rows, columns) = (row_offsets[tests.len()], column_offsets[trials.len()]);
        let mut row_pointers = vec![0];
        let mut column_indices: Vec<u32> = Vec::new();
        for (test, space) in tests.iter().enumerate() {
            for node in 0..space.node_count() {
                let start = column_indices.len();
                for (trial, count) in trial_components.iter().enumerate() {
                    for &neighbour in adjacency[test][trial].row(node) {
                        let first = column_offsets[trial] + neighbour as usize * count;
                        column_indices.extend((first..first + count).map(|column| column as u32));
                    }
                }
                let end = column_indices.len();
                row_pointers.push(end);
                for _ in 1..test_components[test] {
                    column_indices.extend_from_within(start..end);
                    row_pointers.push(column_indices.len());
                }
            }
        }
        let pattern = SparsityPattern::new(rows, columns, row_pointers, column_indices)?;
        Ok(BlockPattern {
            pattern: Arc::new(pattern),
            row_offsets,
            column_offsets,
            adjacency,
            test_components,
            trial_components,
        })
    }

    /// The pattern in compressed rows.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.pattern
    }

    /// First unknown of a test space in a vector over all of them.
    pub fn row_offset(&self, test: usize) -> usize {
        self.row_offsets[test]
    }

    /// First unknown of a trial space in a vector over all of them.
    pub fn column_offset(&self, trial: usize) -> usize {
        self.column_offsets[trial]
    }

    /// Adds the block of a node pair; entries row-major, test components × trial components.
    pub(super) fn add(
        &self,
        values: &mut [f64],
        (test, i): (usize, usize),
        (trial, j): (usize, usize),
        block: impl Fn(usize) -> f64,
    ) {
        let (rows, columns) = (self.test_components[test], self.trial_components[trial]);
        // Both nodes belong to one cell, so the pair is in the pattern.
        let Ok(place) = self.adjacency[test][trial].row(i).binary_search(&(j as u32)) else { return };
        let before: usize =
            (0..trial).map(|t| self.adjacency[test][t].row(i).len() * self.trial_components[t]).sum();
        for row in 0..rows {
            let start = self.pattern.row_pointers()[self.row_offsets[test] + i * rows + row];
            let start = start + before + place * columns;
            for column in 0..columns {
                values[start + column] += block(row * columns + column);
            }
        }
    }
}
