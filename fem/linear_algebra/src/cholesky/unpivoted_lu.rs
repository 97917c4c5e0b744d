//! LU of an unsymmetric matrix without exchanges of rows, on the supernodes and tasks of a Cholesky factor.
//!
//! Without exchanges the structure of the factor is known before its values, and each entry is computed by the same operations on any
//! number of threads. The factorisation is stable where the symmetric part of the matrix is positive definite and the rest is not
//! much larger (Golub and Van Loan 1979, Mathias 1992). Tangents of bodies with friction are of this kind, and those of Nitsche's method with
//! θ ≠ 1. Each factor is checked.

use std::sync::Arc;
use std::time::Instant;

use super::numeric::{Numeric, Unpivoted};
use super::room;
use super::tree_solves::Triangle;
use crate::analysis::Analysis;
use crate::backward_error::Residual;
use crate::csr::CsrMatrix;
use crate::equations::Side;
use crate::error::{LinearAlgebraError, check_finite, check_size};
use crate::spectrum::irregular;
use crate::threads::Threads;
use crate::transpose::Transpose;
use crate::vector::{largest, norm};

/// The most by which an equation may be off, in units of the largest of the scaled unknowns and loads. Pivots that are too small leave more.
const STABLE: f64 = 1e-10;
/// The most of an error that a step of refinement may leave. It is one for a singular matrix.
const RATE: f64 = 1e-3;
/// A scaled matrix with a larger inverse is left to partial pivoting, which judges whether it is singular.
const ILL_CONDITIONED: f64 = 1e12;

/// P A Pᵀ = L U for a matrix whose pattern is symmetric, with ones on the diagonal of L.
///
/// ```
/// use std::sync::Arc;
/// use forms_linear_algebra::{Analysis, CsrMatrix, Ordering, Transpose, UnpivotedLu};
/// use forms_linear_algebra::threads::Threads;
///
/// let matrix = CsrMatrix::from_triplets(2, 2, &[(0, 0, 2.0), (0, 1, 1.0), (1, 0, -1.0), (1, 1, 2.0)])?;
/// let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::default())?);
/// let factor = UnpivotedLu::new_on(Threads::all(), &analysis, &matrix, vec![])?;
/// let mut x = vec![5.0, 0.0];
/// factor.solve_in_place(&mut x, Transpose::No)?;
/// assert_eq!(x, [2.0, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct UnpivotedLu {
    analysis: Arc<Analysis>,
    /// Columns of L and of Uᵀ, panel by panel.
    values: Vec<f64>,
    threads: Threads,
    seconds: f64,
}

impl UnpivotedLu {
    /// L and U on several threads, with the same bits for any number of them. Solves use these threads, too. `storage` is memory
    /// to reuse, for example [`UnpivotedLu::into_storage`] of an earlier factor; it may be empty.
    ///
    /// # Errors
    /// [`LinearAlgebraError::Singular`] if a pivot is zero or not finite, and [`LinearAlgebraError::Inaccurate`] or
    /// [`LinearAlgebraError::IllConditioned`] if two solves find the factor not good enough: an
    /// [`LuFactor`](crate::LuFactor) tells then whether the matrix is regular. And if an entry is not finite, the
    /// pattern is not the analysed one, or memory is too small.
    pub fn new_on(
        threads: Threads,
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        matrix.check_finite()?;
        let numeric = Numeric::new(Unpivoted, analysis, matrix)?;
        let mut values = room(2 * analysis.factor_entries(), storage)?;
        numeric.factorise(threads, &mut values).map_err(|place| LinearAlgebraError::Singular {
            unknown: analysis.order[place] as usize,
            ratio: 0.0,
        })?;
        let mut factor = UnpivotedLu { analysis: analysis.clone(), values, threads, seconds: 0.0 };
        factor.check(matrix)?;
        factor.seconds = start.elapsed().as_secs_f64();
        Ok(factor)
    }

    /// Refuses an inaccurate factor. Two steps of inverse iteration, with the matrix scaled by its diagonal, start from a vector without
    /// structure. They estimate the norm of the inverse, and their last solution shows the backward error of the factor.
    fn check(&self, matrix: &CsrMatrix) -> Result<(), LinearAlgebraError> {
        let sizes: Vec<f64> = matrix.diagonal().iter().map(|value| value.abs().sqrt()).collect();
        if let Some(unknown) = sizes.iter().position(|size| *size == 0.0) {
            return Err(LinearAlgebraError::Singular { unknown, ratio: 0.0 });
        }
        let mut direction: Vec<f64> = irregular(sizes.len()).collect();
        let (mut load, mut growth) = (vec![], 0.0_f64);
        for transpose in [Transpose::Yes, Transpose::No] {
            let before = norm(&direction);
            if before == 0.0 {
                return Ok(());
            }
            direction.iter_mut().zip(&sizes).for_each(|(value, size)| *value *= size / before);
            load.clone_from(&direction);
            self.solve_in_place(&mut direction, transpose)?;
            let scaled = direction.iter().zip(&sizes).map(|(value, size)| value * size);
            growth = growth.max(norm(&scaled.collect::<Vec<f64>>()));
            if transpose == Transpose::Yes {
                direction.iter_mut().zip(&sizes).for_each(|(value, size)| *value *= size);
            }
        }
        let residual = Residual::of(&Side::plain(matrix), self.threads, &direction, &load)?;
        let scaled = |values: &[f64]| values.iter().zip(&sizes).map(|(value, size)| value / size).collect();
        let (rest, load): (Vec<f64>, Vec<f64>) = (scaled(&residual.rest), scaled(&load));
        direction.iter_mut().zip(&sizes).for_each(|(value, size)| *value *= size);
        let backward_error = largest(&rest) / (largest(&direction) + largest(&load));
        let most = |values: &[f64]| {
            let size = |row: &usize| values[*row].abs();
            (0..values.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0)
        };
        let is_stable = backward_error <= STABLE && backward_error * growth <= RATE;
        if !is_stable {
            return Err(LinearAlgebraError::Inaccurate { row: most(&rest), backward_error });
        }
        if growth > ILL_CONDITIONED {
            return Err(LinearAlgebraError::IllConditioned { unknown: most(&direction), condition: growth });
        }
        Ok(())
    }

    /// A⁻¹ b or A⁻ᵀ b in place of b, without refinement.
    ///
    /// # Errors
    /// If the size is wrong or an entry of b or of the solution is not finite.
    pub fn solve_in_place(&self, b: &mut [f64], transpose: Transpose) -> Result<(), LinearAlgebraError> {
        let order = &self.analysis.order;
        check_size("the right-hand side", order.len(), b.len())?;
        check_finite("the right-hand side", b)?;
        let mut x: Vec<f64> = order.iter().map(|unknown| b[*unknown as usize]).collect();
        // Aᵀ = Uᵀ Lᵀ.
        let (first, last) = if transpose == Transpose::Yes { (1, 0) } else { (0, 1) };
        self.triangle(first).solve_with_lower(&mut [&mut x]);
        self.triangle(last).solve_with_upper(&mut [&mut x]);
        for (value, unknown) in x.iter().zip(order) {
            b[*unknown as usize] = *value;
        }
        check_finite("the solution", b)
    }

    /// L or Uᵀ.
    fn triangle(&self, number: usize) -> Triangle<'_> {
        let (analysis, values, threads) = (&*self.analysis, &self.values[..], self.threads);
        Triangle { analysis, values, count: 2, number, threads }
    }

    /// The analysis of the factor.
    pub fn analysis(&self) -> &Arc<Analysis> {
        &self.analysis
    }

    /// Seconds that the factorisation took.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The factor's memory, to be reused.
    pub fn into_storage(self) -> Vec<f64> {
        self.values
    }
}

#[cfg(test)]
mod tests;
