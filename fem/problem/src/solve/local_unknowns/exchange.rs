//! Multipliers as local unknowns: their equations are exchanged with those of what they act on, which determine them.
//!
//! Where a multiplier acts, its own equation does not have it, so that its block is singular: a displacement follows from the condition, and the
//! multiplier from the balance of the displacement. With dual functions this balance has one multiplier, and the exchanged
//! matrix R P A C a regular block per node, with a permutation P of equations and powers of two R, C, which give a condition the size of a balance.

use super::Transpose;
use crate::linear_algebra::{CsrMatrix, Groups, LinearAlgebraError, MultiplierNode, SparsityPattern};

/// An entry below this part of its column's largest is rounding of a duality.
const ROUNDING: f64 = 1e-13;
/// An equation of no node.
const NO_NODE: u32 = u32::MAX;
/// A rank above those of cells and facets, which are eliminated before.
const RANK: u8 = 2;

/// The exchange of equations for a matrix.
#[derive(Debug, PartialEq)]
pub(super) struct Exchange {
    /// The equation in each row.
    rows: Vec<u32>,
    row_factors: Vec<f64>,
    column_factors: Vec<f64>,
    /// Of each multiplier, the largest entry in the equations of its node; zero of other unknowns.
    largest: Vec<f64>,
    /// The node whose equation it is, that of a multiplier or a balance that was exchanged with one.
    node: Vec<u32>,
}

impl Exchange {
    /// The exchange of the equations of multipliers; none where the matrix determines none of them by another equation.
    pub fn new(matrix: &CsrMatrix, groups: &Groups) -> Option<Self> {
        let size = matrix.rows();
        let mut exchange = Exchange {
            rows: (0..size as u32).collect(),
            row_factors: vec![1.0; size],
            column_factors: vec![1.0; size],
            largest: vec![0.0; size],
            node: vec![NO_NODE; size],
        };
        let numbered = (0..).zip(groups.multipliers());
        let acting: usize = numbered.map(|(number, node)| exchange.add(matrix, number, node)).sum();
        (acting > 0).then_some(exchange)
    }

    /// Adds a node; the number of its multipliers that balances determine.
    fn add(&mut self, matrix: &CsrMatrix, number: u32, node: &MultiplierNode) -> usize {
        let mut left: Vec<u32> =
            node.balances.iter().copied().filter(|row| self.node[*row as usize] == NO_NODE).collect();
        let size = |row: u32, column: u32| matrix.get(row as usize, column as usize).abs();
        let largest =
            |rows: &[u32], column: u32| rows.iter().map(|row| size(*row, column)).fold(0.0, f64::max);
        for unknown in &node.unknowns {
            self.node[*unknown as usize] = number;
            self.largest[*unknown as usize] = largest(&left, *unknown).max(largest(&node.unknowns, *unknown));
        }
        let acts = |column: &u32| largest(&left, *column) > 0.0;
        let acting: Vec<u32> = node.unknowns.iter().copied().filter(acts).collect();
        if acting.len() > left.len() {
            return 0;
        }
        for column in &acting {
            let by_size = |a: &usize, b: &usize| size(left[*a], *column).total_cmp(&size(left[*b], *column));
            let Some(place) = (0..left.len()).max_by(by_size) else { break };
            let balance = left.swap_remove(place);
            let [row, column] = [balance, *column].map(|number| number as usize);
            self.rows.swap(row, column);
            self.node[row] = number;
            let ratio = (matrix.get(row, row).abs() / self.largest[column]).log2().round().exp2();
            if ratio.is_finite() && ratio > 0.0 {
                // The condition, which has come to the row of the balance, and the multiplier.
                (self.row_factors[row], self.column_factors[column]) = (ratio, ratio);
            }
        }
        acting.len()
    }

    /// The exchanged matrix, without entries that are rounding of a duality.
    ///
    /// # Errors
    /// Those of a pattern.
    pub fn matrix(&self, matrix: &CsrMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        let size = matrix.rows();
        let (mut pointers, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for (row, equation) in self.rows.iter().enumerate() {
            let equation = *equation as usize;
            let (own, entries) = matrix.row(equation);
            for (column, value) in own.iter().zip(entries) {
                let place = *column as usize;
                let apart = self.node[place] != NO_NODE && self.node[equation] != NO_NODE;
                let is_of_others =
                    apart && self.node[place] != self.node[equation] && self.largest[place] > 0.0;
                if !(is_of_others && value.abs() <= ROUNDING * self.largest[place]) {
                    columns.push(*column);
                    values.push(self.row_factors[row] * value * self.column_factors[place]);
                }
            }
            pointers.push(columns.len());
        }
        let pattern = SparsityPattern::new(size, size, pointers, columns)?;
        CsrMatrix::from_pattern(&pattern.into(), values)
    }

    /// The right-hand side of the exchanged system, or of its transposed one.
    pub fn right_hand_side(&self, b: &[f64], transpose: Transpose) -> Vec<f64> {
        match transpose {
            Transpose::No => {
                let of_rows = self.rows.iter().zip(&self.row_factors);
                of_rows.map(|(equation, factor)| factor * b[*equation as usize]).collect()
            }
            Transpose::Yes => b.iter().zip(&self.column_factors).map(|(b, factor)| factor * b).collect(),
        }
    }

    /// The solution from that of the exchanged system, or of its transposed one.
    pub fn solution(&self, x: &[f64], transpose: Transpose) -> Vec<f64> {
        match transpose {
            Transpose::No => x.iter().zip(&self.column_factors).map(|(x, factor)| factor * x).collect(),
            Transpose::Yes => {
                let mut solution = vec![0.0; x.len()];
                for ((equation, factor), x) in self.rows.iter().zip(&self.row_factors).zip(x) {
                    solution[*equation as usize] = factor * x;
                }
                solution
            }
        }
    }
}

/// The groups of an exchanged matrix: those of cells and facets, and a node's multipliers each.
pub(super) fn groups_after_exchange(groups: &Groups) -> Groups {
    let mut all = groups.where_all(|_| true);
    groups.multipliers().iter().for_each(|node| all.add(RANK, node.unknowns.iter().copied()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_algebra::LuFactor;
    use crate::solve::{LinearSolver, LocalUnknowns, TangentSolver};

    /// Springs u₀ … u₃; multipliers p₀, p₁ with gaps g₀, g₁ act on u₀ and u₁, and on the opposite u₂, u₃. Where a node presses its
    /// condition is that of displacements, else p = 0. A coupling of p₀ with u₁ is rounding of a duality, or more.
    fn system(presses: [bool; 2], coupling: f64) -> (CsrMatrix, Groups) {
        let mut entries: Vec<(usize, usize, f64)> = (0..4)
            .map(|k| (k, k, 2e4))
            .chain((0..3).flat_map(|k| [(k, k + 1, -7e3), (k + 1, k, -8e3)]))
            .collect();
        let mut groups = Groups::default();
        for (k, presses) in presses.into_iter().enumerate() {
            let ([u, opposite], [p, g]) = ([k, 3 - k], [4 + k, 6 + k]);
            entries.extend([(u, p, 0.1), (2, p, -0.04), (opposite, p, -0.06)]);
            entries.extend([(p, p, if presses { -1e-12 } else { -1e-6 })]);
            entries.extend([(p, u, 0.1), (p, opposite, -0.1), (p, g, 0.0)]);
            entries.extend([(g, u, 0.1), (g, opposite, -0.1), (g, g, -0.1)]);
            let (node, balance) = ([p, g].map(|unknown| unknown as u32), u as u32);
            groups.add_multipliers(MultiplierNode { unknowns: node.to_vec(), balances: vec![balance] });
        }
        // Sums over nodes list zeros.
        entries.extend([(1, 4, coupling), (6, 7, 0.0), (7, 6, 0.0)]);
        (CsrMatrix::from_triplets(8, 8, &entries).unwrap(), groups)
    }

    #[test]
    fn solutions_are_those_of_the_whole_system_both_ways() {
        for (presses, coupling, eliminated) in [
            ([true, true], 1e-17, 4),
            ([true, false], -1e-17, 4),
            ([false, false], 0.0, 4),
            ([true, true], 0.02, 2),
        ] {
            let (matrix, groups) = system(presses, coupling);
            let b: Vec<f64> = (0..8).map(|k| (1.0 + 1.7 * k as f64).sin()).collect();
            let mut solver = LocalUnknowns::<TangentSolver>::default();
            solver.set_local_unknowns(groups);
            solver.set_matrix(matrix.clone()).unwrap();
            let counts = solver.report().unwrap().local_unknowns.unwrap();
            assert_eq!((counts.eliminated, counts.coupled), (eliminated, 4 - eliminated));
            for transpose in [Transpose::No, Transpose::Yes] {
                let found = solver.solve_with(&b, 0.0, transpose).unwrap().solution;
                let mut expected = b.clone();
                LuFactor::new(&matrix, None).unwrap().solve_in_place(&mut expected, transpose).unwrap();
                for (found, expected) in found.iter().zip(&expected) {
                    assert!(
                        (found / expected - 1.0).abs() < 1e-9,
                        "{presses:?} {coupling}: {found} {expected}"
                    );
                }
            }
        }
    }
}
