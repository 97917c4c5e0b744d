//! Condensation: a factor K = L Lᵀ with some unknowns c last, and the Schur complement S = L_c L_cᵀ on them, dense.
//!
//! T = K + B, where B couples unknowns of c alone, is solved with the factor of K and a dense one of S + B.

use faer::linalg::solvers::PartialPivLu;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::Solve;
use faer::{Mat, Par};

use crate::cholesky::SymmetricFactor;
use crate::error::LinearAlgebraError;
use crate::partial_solves::lower_times_transposed;
use crate::restriction::Entry;
use crate::transpose::Transpose;

/// The factor of K and its Schur complement.
#[derive(Debug)]
pub struct Condensation {
    factor: SymmetricFactor,
    /// c, in elimination order.
    unknowns: Vec<u32>,
    /// Place of each unknown among them.
    places: Vec<Option<u32>>,
    lower: Mat<f64>,
    schur: Mat<f64>,
}

/// The dense factor LU of S + B.
#[derive(Debug)]
pub struct DenseFactor(PartialPivLu<f64>);

impl Condensation {
    /// Of a factor whose last `count` unknowns are c.
    pub fn new(factor: SymmetricFactor, count: usize) -> Self {
        let order = factor.analysis().elimination_order();
        let unknowns = order[order.len() - count..].to_vec();
        let mut places = vec![None; order.len()];
        for (place, unknown) in unknowns.iter().enumerate() {
            places[*unknown as usize] = Some(place as u32);
        }
        let lower = factor.trailing_block(count);
        let schur = lower_times_transposed(&lower);
        Condensation { factor, unknowns, places, lower, schur }
    }

    /// That of K.
    pub fn factor(&self) -> &SymmetricFactor {
        &self.factor
    }

    /// c, in elimination order: that of all vectors and matrices on it.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknowns
    }

    /// Whether all of these are among c.
    pub fn holds(&self, unknowns: &[u32]) -> bool {
        unknowns.iter().all(|unknown| self.places[*unknown as usize].is_some())
    }

    /// The dense factor of S + B; entries outside of c are left out.
    pub fn dense_factor(&self, additions: &[Entry]) -> DenseFactor {
        let mut system = self.schur.clone();
        for Entry { row, column, value } in additions {
            let place = |unknown: u32| self.places[unknown as usize];
            if let (Some(row), Some(column)) = (place(*row), place(*column)) {
                system[(row as usize, column as usize)] += value;
            }
        }
        DenseFactor(system.partial_piv_lu())
    }

    /// S x of condensed unknowns.
    pub fn schur_times(&self, x: &[f64]) -> Vec<f64> {
        column(&(&self.schur * as_column(x)))
    }

    /// L_c y_c of a vector y = L⁻¹ b: the right-hand side of the condensed system.
    pub fn condensed_load(&self, y: &[f64]) -> Vec<f64> {
        column(&(&self.lower * as_column(&y[y.len() - self.unknowns.len()..])))
    }

    /// L_cᵀ x_c: what back-substitution reads in the place of y_c.
    pub fn shifted(&self, x: &[f64]) -> Vec<f64> {
        column(&(self.lower.transpose() * as_column(x)))
    }

    /// (S + B)⁻¹ r with the dense factor of S + B; none where B = 0.
    pub fn dense_solve(&self, r: &[f64], dense: Option<&DenseFactor>) -> Vec<f64> {
        let mut x = as_column(r);
        match dense {
            Some(dense) => x = dense.0.solve(&x),
            None => {
                solve_lower_triangular_in_place(self.lower.as_ref(), x.as_mut(), Par::Seq);
                solve_upper_triangular_in_place(self.lower.transpose(), x.as_mut(), Par::Seq);
            }
        }
        column(&x)
    }

    /// T⁻¹ b, or T⁻ᵀ b, of all unknowns, with the dense factor of S + B; none where B = 0.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn solve(
        &self,
        b: &[f64],
        dense: Option<&DenseFactor>,
        transpose: Transpose,
    ) -> Result<Vec<f64>, LinearAlgebraError> {
        let mut y = self.factor.solve_lower(b)?;
        if let Some(dense) = dense {
            let load = as_column(&self.condensed_load(&y));
            let solution = match transpose {
                Transpose::No => dense.0.solve(&load),
                Transpose::Yes => dense.0.solve_transpose(&load),
            };
            let first = y.len() - self.unknowns.len();
            y[first..].copy_from_slice(&self.shifted(&column(&solution)));
        }
        self.factor.solve_upper(y)
    }
}

fn as_column(x: &[f64]) -> Mat<f64> {
    Mat::from_fn(x.len(), 1, |i, _| x[i])
}

fn column(x: &Mat<f64>) -> Vec<f64> {
    (0..x.nrows()).map(|i| x[(i, 0)]).collect()
}
