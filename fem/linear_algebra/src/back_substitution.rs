//! Back-substitution for a few unknowns: x = Pᵀ L⁻ᵀ y reads, for each of them, the supernode that holds it and the
//! ancestors of that supernode in the elimination tree, and nothing else of L.

use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;

use super::cholesky::SymmetricFactor;
use super::error::{LinearAlgebraError, check_size};
use super::ordering::inverse;

/// The supernodes that some unknowns depend on, and memory for their values.
#[derive(Clone, Debug)]
pub struct PartialBackSubstitution {
    /// Ascending.
    supernodes: Vec<u32>,
    /// Place in the elimination order of each unknown asked for.
    places: Vec<u32>,
    /// In elimination order; only what the supernodes hold is up to date.
    x: Vec<f64>,
}

impl PartialBackSubstitution {
    /// The plan for some unknowns of an LLᵀ factor.
    ///
    /// # Errors
    /// If an unknown is not one of the factor's.
    pub fn new(factor: &SymmetricFactor, unknowns: &[u32]) -> Result<Self, LinearAlgebraError> {
        let (analysis, symbolic) = (factor.analysis(), factor.supernodes());
        let size = analysis.size();
        let place = inverse(analysis.elimination_order())?;
        let places = unknowns.iter().map(|&unknown| {
            let found = place.get(unknown as usize).copied();
            let index = unknown as usize;
            found.ok_or(LinearAlgebraError::IndexOutOfRange { what: "unknown to solve for", index, size })
        });
        let places = places.collect::<Result<Vec<u32>, _>>()?;
        let ends = symbolic.supernode_end();
        // The supernode of a place: the first that ends behind it.
        let holder = |place: u32| ends.partition_point(|end| *end <= place);
        let mut needed = vec![false; symbolic.n_supernodes()];
        let llt = SupernodalLltRef::new(symbolic, factor.values());
        for &place in &places {
            let mut s = holder(place);
            while !std::mem::replace(&mut needed[s], true) {
                // The rows below a supernode belong to its ancestors, and the first of them to its parent.
                let Some(&first) = llt.supernode(s).pattern().first() else { break };
                s = holder(first);
            }
        }
        let supernodes = (0..needed.len() as u32).filter(|s| needed[*s as usize]).collect();
        Ok(Self { supernodes, places, x: vec![0.0; size] })
    }

    /// Numbers of the factor that a solve reads.
    pub fn entries(&self, factor: &SymmetricFactor) -> usize {
        let llt = SupernodalLltRef::new(factor.supernodes(), factor.values());
        let entries =
            |s: &u32| llt.supernode(*s as usize).val().nrows() * llt.supernode(*s as usize).val().ncols();
        self.supernodes.iter().map(entries).sum()
    }

    /// The values of the unknowns in x = Pᵀ L⁻ᵀ y, for y in elimination order.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn solve(&mut self, factor: &SymmetricFactor, y: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the right-hand side", self.x.len(), y.len())?;
        let symbolic = factor.supernodes();
        for &s in &self.supernodes {
            let ends =
                [symbolic.supernode_begin(), symbolic.supernode_end()].map(|ends| ends[s as usize] as usize);
            self.x[ends[0]..ends[1]].copy_from_slice(&y[ends[0]..ends[1]]);
        }
        factor.solve_with_upper_at(&self.supernodes, &mut [&mut self.x]);
        Ok(self.places.iter().map(|place| self.x[*place as usize]).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Analysis, CsrMatrix, Ordering};

    /// The five-point stencil on m × m nodes.
    fn grid(m: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for node in 0..m * m {
            triplets.push((node, node, 4.2));
            for (step, inside) in [(1, node % m + 1 < m), (m, node / m + 1 < m)] {
                if inside {
                    triplets.extend([(node, node + step, -1.0), (node + step, node, -1.0)]);
                }
            }
        }
        CsrMatrix::from_triplets(m * m, m * m, &triplets).unwrap()
    }

    #[test]
    fn a_few_unknowns_are_those_of_the_whole_solution() {
        let matrix = grid(40);
        for ordering in [Ordering::MinimumDegree, Ordering::NestedDissection] {
            let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
            let factor = SymmetricFactor::cholesky(&analysis, &matrix, vec![]).unwrap();
            let b: Vec<f64> = (0..1600).map(|k| (k as f64 * 0.37).sin()).collect();
            let y = factor.solve_lower(&b).unwrap();
            let whole = factor.solve_upper(y.clone()).unwrap();
            let unknowns: Vec<u32> = (0..40).map(|k| 40 * k + 3).collect();
            let mut partial = PartialBackSubstitution::new(&factor, &unknowns).unwrap();
            assert!(2 * partial.entries(&factor) < analysis.factor_entries());
            for (found, unknown) in partial.solve(&factor, &y).unwrap().iter().zip(&unknowns) {
                assert_eq!(*found, whole[*unknown as usize]);
            }
            assert!(partial.solve(&factor, &y[1..]).is_err());
            assert!(PartialBackSubstitution::new(&factor, &[1600]).is_err());
        }
    }
}
