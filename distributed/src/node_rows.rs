//! The rows of PETSc's matrices: whole nodes, as block methods want them, of those that have free unknowns.

use forms_fem::linear_algebra::rigid_motions;
use forms_fem::prelude::*;
use forms_fem::solve::communicator::Fingerprint;

use crate::error::PetscError;
use crate::petsc::Index;
use crate::rows::Rows;
use crate::world::World;

/// A motion whose part outside of the span of others is smaller than this, relative to its length, adds nothing to them.
const DEPENDENT: f64 = 1e-8;

/// The rows of the free unknowns of a space with constraints: a component that is not free at a node with free ones
/// gets a row with 1 on the diagonal; nodes without free components have no rows.
#[derive(Clone, Debug)]
pub(crate) struct NodeRows {
    pub rows: Rows,
    /// Row of each free unknown.
    pub places: Vec<Index>,
    /// Rows of components that are not free.
    pub held: Vec<Index>,
    /// An orthonormal basis of the rigid motions of a displacement, zero in the held rows; empty for other fields.
    pub motions: Vec<Vec<f64>>,
}

impl NodeRows {
    pub fn new<const D: usize>(world: &World, constraints: &Constraints<D>) -> Result<Self, PetscError> {
        let space = constraints.space();
        let components = space.components();
        let mut is_free = vec![false; space.unknowns()];
        constraints.free().into_iter().for_each(|unknown| is_free[unknown] = true);
        let (mut places, mut held, mut positions) = (Vec::new(), Vec::new(), Vec::new());
        let mut row = 0;
        for (free, position) in is_free.chunks_exact(components).zip(space.positions()) {
            if !free.contains(&true) {
                continue;
            }
            positions.push(*position);
            for free in free {
                if *free {
                    places.push(row)
                } else {
                    held.push(row)
                }
                row += 1;
            }
        }
        let motions = if components == D && D > 1 { rigid_motions(&positions) } else { vec![] };
        Ok(NodeRows {
            rows: Rows::of_nodes(world, positions.len(), components)?,
            places,
            motions: orthonormal(motions, &held),
            held,
        })
    }

    /// A number that tells rows of other nodes, places or constraints apart.
    pub fn fingerprint(&self, positions: &[impl AsRef<[f64]>]) -> u64 {
        let places = self.places.iter().chain(&self.held).map(|place| *place as u64);
        let sizes = [self.rows.count, self.rows.block, self.places.len()].map(|size| size as u64);
        let positions = positions.iter().flat_map(|position| position.as_ref());
        Fingerprint::default().numbers(sizes).numbers(places).reals(positions).finish()
    }

    /// A vector over the rows from one over the free unknowns.
    pub fn spread(&self, reduced: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.rows.count];
        for (place, value) in self.places.iter().zip(reduced) {
            all[*place as usize] = *value;
        }
        all
    }

    /// The free unknowns of a vector over the rows.
    pub fn gather(&self, all: &[f64]) -> Vec<f64> {
        self.places.iter().map(|place| all[*place as usize]).collect()
    }
}

/// Gram and Schmidt's basis of some vectors that are zero in the held rows.
fn orthonormal(vectors: Vec<Vec<f64>>, held: &[Index]) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut vector in vectors {
        held.iter().for_each(|row| vector[*row as usize] = 0.0);
        let before = product(&vector, &vector).sqrt();
        // Once more, for what rounding left.
        for _ in 0..2 {
            for known in &basis {
                let factor = product(known, &vector);
                vector.iter_mut().zip(known).for_each(|(value, known)| *value -= factor * known);
            }
        }
        let length = product(&vector, &vector).sqrt();
        if length > DEPENDENT * before {
            vector.iter_mut().for_each(|value| *value /= length);
            basis.push(vector);
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_become_a_basis_that_leaves_held_rows_alone() {
        let vectors = vec![vec![1.0, 1.0, 0.0], vec![1.0, 1.0, 1.0], vec![2.0, 2.0, 5.0]];
        let basis = orthonormal(vectors, &[0]);
        assert_eq!(basis, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }
}
