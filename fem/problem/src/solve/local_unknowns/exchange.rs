//! Multipliers as local unknowns: the equation of what they act on is exchanged with their own, so that each stands by the equation that determines it.
//!
//! Where a multiplier acts, its own equation does not have it, so that its block is singular: a displacement follows from the condition, and the
//! multiplier from the balance of the displacement. With dual functions this balance has one multiplier, and the exchanged
//! matrix R P A C a regular block per node, with a permutation P of equations and powers of two R, C, which give a condition the size of a balance.

use super::Transpose;
use crate::linear_algebra::{CsrMatrix, Groups, LinearAlgebraError, MultiplierNode, SparsityPattern};

/// An entry below this part of its column's largest is rounding of a duality.
const ROUNDING: f64 = 1e-13;
/// A rank above those of cells and facets, which are eliminated before.
const RANK: u8 = 2;

/// The exchange of equations for a matrix.
#[derive(Debug, PartialEq)]
pub(super) struct Exchange {
    /// The equation in each row.
    rows: Vec<u32>,
    row_factors: Vec<f64>,
    column_factors: Vec<f64>,
    /// Of each multiplier, the largest entry in the balances of its node; zero of other unknowns.
    largest: Vec<f64>,
    /// The equations that were exchanged with those of multipliers.
    is_balance: Vec<bool>,
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
            is_balance: vec![false; size],
        };
        groups.multipliers().iter().for_each(|node| exchange.add(matrix, node));
        exchange.is_balance.contains(&true).then_some(exchange)
    }

    fn add(&mut self, matrix: &CsrMatrix, node: &MultiplierNode) {
        let mut left: Vec<u32> =
            node.balances.iter().copied().filter(|row| !self.is_balance[*row as usize]).collect();
        let size = |row: u32, column: u32| matrix.get(row as usize, column as usize).abs();
        let largest = |column: u32| left.iter().map(|row| size(*row, column)).fold(0.0, f64::max);
        let acting: Vec<(u32, f64)> =
            node.unknowns.iter().map(|column| (*column, largest(*column))).filter(|(_, most)| *most > 0.0).collect();
        if acting.len() > left.len() {
            return;
        }
        for (column, most) in acting {
            let Some(place) = (0..left.len()).max_by(|a, b| {
                size(left[*a], column).total_cmp(&size(left[*b], column))
            }) else {
                return;
            };
            let balance = left.swap_remove(place);
            let [row, column] = [balance, column].map(|number| number as usize);
            self.rows.swap(row, column);
            self.is_balance[row] = true;
            self.largest[column] = most;
            let ratio = (matrix.get(row, row).abs() / most).log2().round().exp2();
            if ratio.is_finite() && ratio > 0.0 {
                // The condition, which has come to the row of the balance, and the multiplier.
                (self.row_factors[row], self.column_factors[column]) = (ratio, ratio);
            }
        }
    }

    /// The exchanged matrix, without entries that are rounding of a duality.
    pub fn matrix(&self, matrix: &CsrMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        let size = matrix.rows();
        let (mut pointers, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for (row, equation) in self.rows.iter().enumerate() {
            let equation = *equation as usize;
            let (own, entries) = matrix.row(equation);
            for (column, value) in own.iter().zip(entries) {
                let place = *column as usize;
                let is_rounding = self.is_balance[equation] && value.abs() <= ROUNDING * self.largest[place];
                // The largest of others is zero.
                if !(is_rounding && self.largest[place] > 0.0) {
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
