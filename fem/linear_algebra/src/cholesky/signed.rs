//! LSLᵀ with signs S: a Cholesky factor of saddle points.
//!
//! A symmetric matrix [K Bᵀ; B −C] with positive definite K and C is quasi-definite: it has this factor for every order of elimination, with
//! the signs of its diagonal (Vanderbei 1995). In a saddle point C = 0, or K is only semidefinite where multipliers hold a body. A
//! pivot may vanish there, and a small number of its sign replaces it. That is the factor of a matrix nearby, and iterative
//! refinement against the matrix itself takes the difference out (Altman and Gondzio 1999).

use std::sync::Arc;
use std::time::Instant;

use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;

use super::numeric::{Numeric, Signed};
use super::{Kind, SymmetricFactor, room};
use crate::analysis::Analysis;
use crate::csr::CsrMatrix;
use crate::error::{LinearAlgebraError, check_size};
use crate::spectrum::irregular;
use crate::threads::Threads;
use crate::vector::norm;

/// A pivot below this part of its scale is replaced: about the square root of rounding, which balances what it changes with what the
/// large numbers that follow from it round.
const SUBSTITUTE: f64 = 1e-8;
/// Steps of the power method that estimates a remainder.
const STEPS: usize = 2;

/// Quality of a factor of a matrix nearby for refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainder {
    /// Estimate of the part of an error that a step of refinement leaves, ‖I − Ã⁻¹ A‖ for the matrix à that was factored. It is 1 for a
    /// singular A.
    pub rate: f64,
    /// Estimate of ‖Ã⁻¹‖ in the Euclidean norm \[1 / unit of A\].
    pub inverse_norm: f64,
}

impl SymmetricFactor {
    /// LSLᵀ of a symmetric matrix, S a diagonal of signs, on several threads, with the same bits for any number of them. Pivots that vanish
    /// are replaced: by a negative number where the diagonal of the matrix is zero or negative, else by a positive one. Solve
    /// with [`SymmetricFactor::solve_refined`], and ask the [`SymmetricFactor::remainder`] whether that can succeed.
    /// Entries are read as in [`SymmetricFactor::cholesky`], and `storage` is as there.
    ///
    /// # Errors
    /// If a pivot is not finite, or a row is zero (the error names the unknown), an entry is not finite, the pattern is not the
    /// analysed one, or memory is too small.
    pub fn signed_on(
        threads: Threads,
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        matrix.check_finite()?;
        let diagonal = matrix.diagonal_above_rounding();
        let scales = scales_of_pivots(matrix, &diagonal);
        let substitutes: Vec<f64> = analysis
            .order
            .iter()
            .map(|unknown| {
                let unknown = *unknown as usize;
                let size = SUBSTITUTE * scales[unknown];
                if diagonal[unknown] > 0.0 { size } else { -size }
            })
            .collect();
        if let Some(unknown) = scales.iter().position(|scale| *scale == 0.0) {
            return Err(LinearAlgebraError::Singular { unknown, ratio: 0.0 });
        }
        let numeric = Numeric::new(Signed { substitutes: &substitutes }, analysis, matrix)?;
        let mut values = room(analysis.factor_entries(), storage)?;
        numeric.factorise(threads, &mut values).map_err(|place| LinearAlgebraError::Singular {
            unknown: analysis.order[place] as usize,
            ratio: f64::NAN,
        })?;
        let (mut negative, mut replaced, mut smallest) = (vec![], 0, f64::INFINITY);
        let factor = SupernodalLltRef::new(&analysis.supernodes, &values);
        for s in 0..analysis.supernodes.n_supernodes() {
            let node = factor.supernode(s);
            for j in 0..node.val().ncols() {
                let place = node.start() + j;
                let root = node.val()[(j, j)];
                let ratio = root.powi(2) / scales[analysis.order[place] as usize];
                smallest = f64::min(smallest, ratio);
                // Rounding of the root.
                replaced += usize::from(ratio <= SUBSTITUTE * (1.0 + 4.0 * f64::EPSILON));
                if root < 0.0 {
                    negative.push(place as u32);
                }
            }
        }
        Ok(Self {
            analysis: analysis.clone(),
            values,
            negative_eigenvalues: negative.len(),
            kind: Kind::Signed { negative, replaced },
            smallest_pivot_ratio: smallest,
            threads,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Whether this is an LSLᵀ factor.
    pub fn is_signed(&self) -> bool {
        matches!(self.kind, Kind::Signed { .. })
    }

    /// Number of pivots of an LSLᵀ factor that vanished and were replaced. Others need no refinement but for rounding.
    pub fn replaced_pivots(&self) -> usize {
        if let Kind::Signed { replaced, .. } = self.kind { replaced } else { 0 }
    }

    /// Unknowns whose pivots in an LSLᵀ factor do not have the sign of the matrix's diagonal, where that has one: none if
    /// the matrix is quasi-definite.
    pub fn turned_pivots(&self, matrix: &CsrMatrix) -> usize {
        let Kind::Signed { negative, .. } = &self.kind else { return 0 };
        let mut is_negative = vec![false; self.analysis.size()];
        negative.iter().for_each(|place| is_negative[self.analysis.order[*place as usize] as usize] = true);
        let turned = |(value, negative): (&f64, &bool)| *value != 0.0 && (*value < 0.0) != *negative;
        let diagonal = matrix.diagonal_above_rounding();
        diagonal.iter().zip(&is_negative).filter(|pair| turned((pair.0, pair.1))).count()
    }

    /// Estimates by the power method what a step of refinement with this factor leaves of an error. A rate below one proves that
    /// the matrix is regular, and that it has as many negative eigenvalues as the factor.
    ///
    /// # Errors
    /// If the matrix has another size, or a solution is not finite.
    pub fn remainder(&self, matrix: &CsrMatrix) -> Result<Remainder, LinearAlgebraError> {
        let size = self.analysis.size();
        check_size("the matrix", size, matrix.rows())?;
        if size == 0 {
            return Ok(Remainder { rate: 0.0, inverse_norm: 0.0 });
        }
        let mut error: Vec<f64> = irregular(size).collect();
        let load = norm(&error);
        self.solve_in_place(&mut error)?;
        let mut found = Remainder { rate: 0.0, inverse_norm: norm(&error) / load };
        for _ in 0..STEPS {
            let before = norm(&error);
            if before == 0.0 {
                break;
            }
            error.iter_mut().for_each(|value| *value /= before);
            let mut change = matrix.multiply(&error)?;
            self.solve_in_place(&mut change)?;
            error.iter_mut().zip(&change).for_each(|(error, change)| *error -= change);
            found.rate = norm(&error);
        }
        Ok(found)
    }

    /// Multiplies a vector in elimination order by the signs.
    pub(crate) fn apply_signs(&self, x: &mut [f64]) {
        if let Kind::Signed { negative, .. } = &self.kind {
            negative.iter().for_each(|place| x[*place as usize] = -x[*place as usize]);
        }
    }
}

/// The scale of each pivot: the diagonal, or that of the Schur complement of a multiplier, or the largest entry of the row.
fn scales_of_pivots(matrix: &CsrMatrix, diagonal: &[f64]) -> Vec<f64> {
    let largest = |row: usize| matrix.row(row).1.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let sizes = matrix.sizes_by_diagonal(diagonal.to_vec()).into_iter().enumerate();
    sizes.map(|(row, size)| if size > 0.0 { size * size } else { largest(row) }).collect()
}

#[cfg(test)]
mod tests;
