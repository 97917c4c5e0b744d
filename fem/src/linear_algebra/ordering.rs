//! Fill-reducing orderings of symmetric patterns.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::error::{LinearAlgebraError, check_size};
use super::pattern::SparsityPattern;

/// The order in which unknowns are eliminated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Ordering {
    /// Approximate minimum degree on the graph of blocks. A block is a run of consecutive unknowns whose
    /// rows have the same pattern: the free components of one node. Ordering blocks is faster than ordering
    /// unknowns and keeps the components of a node together.
    #[default]
    MinimumDegree,
    /// The unknown to eliminate first, the next, and so on. It should be postordered (descendants in the
    /// elimination tree just before their ancestors), as nested dissection is, or supernodes stay small.
    Given(Vec<u32>),
}

impl Ordering {
    /// Unknowns in the order of their elimination.
    ///
    /// # Errors
    /// If a given order is not a permutation, or the pattern is too large or memory too small.
    pub fn elimination_order(&self, pattern: &SparsityPattern) -> Result<Vec<u32>, LinearAlgebraError> {
        match self {
            Self::MinimumDegree => minimum_degree(pattern),
            Self::Given(order) => {
                check_size("the elimination order", pattern.rows(), order.len())?;
                inverse(order)?;
                Ok(order.clone())
            }
        }
    }
}

/// The inverse of a permutation.
///
/// # Errors
/// If the list is not a permutation of 0..n.
pub(crate) fn inverse(order: &[u32]) -> Result<Vec<u32>, LinearAlgebraError> {
    let size = order.len();
    let mut result = vec![u32::MAX; size];
    for (position, &unknown) in order.iter().enumerate() {
        match result.get_mut(unknown as usize) {
            Some(slot) if *slot == u32::MAX => *slot = position as u32,
            // Out of range, or named twice (then some other unknown is missing).
            _ => {
                return Err(LinearAlgebraError::IndexOutOfRange {
                    what: "unknown of the elimination order",
                    index: unknown as usize,
                    size,
                });
            }
        }
    }
    Ok(result)
}

/// First unknown of each block, and the number of unknowns at the end.
fn block_begins(pattern: &SparsityPattern) -> Vec<usize> {
    let size = pattern.rows();
    let mut begins: Vec<usize> =
        (0..size).filter(|&row| row == 0 || pattern.row(row) != pattern.row(row - 1)).collect();
    begins.push(size);
    begins
}

fn minimum_degree(pattern: &SparsityPattern) -> Result<Vec<u32>, LinearAlgebraError> {
    const TOO_LARGE: LinearAlgebraError = LinearAlgebraError::TooLarge { what: "the graph to order" };
    const NO_MEMORY: LinearAlgebraError = LinearAlgebraError::OutOfMemory { what: "the ordering" };
    let begins = block_begins(pattern);
    let blocks = begins.len() - 1;
    let mut block_of = vec![0_u32; pattern.columns()];
    for block in 0..blocks {
        block_of[begins[block]..begins[block + 1]].fill(block as u32);
    }
    let mut pointers = Vec::with_capacity(blocks + 1);
    pointers.push(0_u32);
    let mut neighbours: Vec<u32> = Vec::new();
    for &begin in &begins[..blocks] {
        let first = neighbours.len();
        for &column in pattern.row(begin) {
            let block = block_of[column as usize];
            // Columns ascend, and so do their blocks: a repeated block repeats at once.
            if neighbours.len() == first || neighbours.last() != Some(&block) {
                neighbours.push(block);
            }
        }
        pointers.push(u32::try_from(neighbours.len()).map_err(|_| TOO_LARGE)?);
    }
    let graph = SymbolicSparseColMatRef::new_checked(blocks, blocks, &pointers, None, &neighbours);
    let mut order = vec![0_u32; blocks];
    let mut positions = vec![0_u32; blocks];
    let mut memory =
        MemBuffer::try_new(amd::order_scratch::<u32>(blocks, neighbours.len())).map_err(|_| NO_MEMORY)?;
    amd::order(&mut order, &mut positions, graph, amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|_| TOO_LARGE)?;
    Ok(order
        .iter()
        .flat_map(|&block| begins[block as usize] as u32..begins[block as usize + 1] as u32)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_algebra::CsrMatrix;

    /// A star of `leaves` nodes around node 0, two unknowns per node.
    fn star(leaves: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for node in 0..=leaves {
            for other in [0, node] {
                for k in 0..4 {
                    triplets.push((2 * node + k / 2, 2 * other + k % 2, 1.0));
                    triplets.push((2 * other + k / 2, 2 * node + k % 2, 1.0));
                }
            }
        }
        CsrMatrix::from_triplets(2 * leaves + 2, 2 * leaves + 2, &triplets).unwrap()
    }

    #[test]
    fn the_centre_of_a_star_goes_last_and_nodes_stay_together() {
        let matrix = star(10);
        assert_eq!(block_begins(matrix.pattern()).len(), 12);
        let order = Ordering::MinimumDegree.elimination_order(matrix.pattern()).unwrap();
        inverse(&order).unwrap();
        for pair in order.chunks(2) {
            assert_eq!((pair[0] % 2, pair[1]), (0, pair[0] + 1));
        }
        // The centre and the last leaf have the same degree at the end.
        let centre = order.iter().position(|&unknown| unknown == 0).unwrap();
        assert!(centre >= 18, "the centre was eliminated at {centre}");
    }

    #[test]
    fn a_given_order_must_be_a_permutation() {
        let matrix = star(1);
        let order = |list: &[u32]| Ordering::Given(list.to_vec()).elimination_order(matrix.pattern());
        assert_eq!(order(&[3, 1, 0, 2]).unwrap(), [3, 1, 0, 2]);
        assert!(order(&[3, 1, 0, 1]).is_err());
        assert!(order(&[4, 1, 0, 2]).is_err());
        assert!(order(&[1, 0, 2]).is_err());
    }

    #[test]
    fn an_empty_pattern_has_an_empty_order() {
        let empty = CsrMatrix::from_triplets(0, 0, &[]).unwrap();
        assert!(Ordering::MinimumDegree.elimination_order(empty.pattern()).unwrap().is_empty());
    }
}
