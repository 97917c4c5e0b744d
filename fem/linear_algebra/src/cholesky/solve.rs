//! Solution with a symmetric factor, with iterative refinement or without.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::supernodal::SupernodalIntranodeLbltRef;
use faer::{Conj, MatMut, Par};

use super::{Kind, SymmetricFactor};
use crate::backward_error::{Refinement, Residual, Rule, refine_each};
use crate::csr::CsrMatrix;
use crate::equations::Side;
use crate::error::{LinearAlgebraError, check_finite, check_size};
use crate::operator::{OperatorError, Preconditioner};
use crate::threads::Threads;
use crate::vector::{largest, norm};
use crate::wide_registers::cleared;

/// Backward error at which refinement has nothing left to gain.
const ROUNDING: f64 = 2e-16;

/// A solution after iterative refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// The solution x.
    pub solution: Vec<f64>,
    /// ‖b − A x‖₂ / ‖b‖₂ (0 if b = 0).
    pub relative_residual: f64,
    /// Largest |b − A x|_i / (|A| |x| + |b|)_i: about 1e-16 when x is as good as rounding allows.
    pub backward_error: f64,
    /// Steps of refinement of the whole solution that improved it; single equations may have taken further ones.
    pub steps: usize,
}

impl SymmetricFactor {
    /// A⁻¹ b in place of b, without refinement.
    ///
    /// # Errors
    /// If the size is wrong or an entry of b or of the solution is not finite.
    pub fn solve_in_place(&self, b: &mut [f64]) -> Result<(), LinearAlgebraError> {
        let analysis = &*self.analysis;
        let size = analysis.size();
        check_size("the right-hand side", size, b.len())?;
        check_finite("the right-hand side", b)?;
        let supernodes = &analysis.supernodes;
        let mut x = vec![0.0; size];
        match &self.kind {
            Kind::Positive | Kind::Signed { .. } => {
                for (target, &unknown) in x.iter_mut().zip(&analysis.order) {
                    *target = b[unknown as usize];
                }
                self.solve_with_lower(&mut [&mut x]);
                self.apply_signs(&mut x);
                self.solve_with_upper(&mut [&mut x]);
                for (value, &unknown) in x.iter().zip(&analysis.order) {
                    b[unknown as usize] = *value;
                }
            }
            Kind::Pivoted(pivoting) => {
                let mut memory = MemBuffer::try_new(supernodes.solve_in_place_scratch::<f64>(1, Par::Seq))
                    .map_err(|_| LinearAlgebraError::OutOfMemory { what: "a triangular solve" })?;
                let stack = MemStack::new(&mut memory);
                let unknown_at = |place: &u32| analysis.order[*place as usize] as usize;
                for (target, place) in x.iter_mut().zip(&pivoting.forward) {
                    *target = b[unknown_at(place)];
                }
                let column = MatMut::from_column_major_slice_mut(&mut x, size, 1);
                let permutation = PermRef::new_checked(&pivoting.forward, &pivoting.backward, size);
                let below = &pivoting.below_diagonal;
                let factor = SupernodalIntranodeLbltRef::new(supernodes, &self.values, below, permutation);
                cleared(|| {
                    factor.solve_in_place_no_numeric_permute_with_conj(Conj::No, column, Par::Seq, stack);
                });
                for (value, place) in x.iter().zip(&pivoting.forward) {
                    b[unknown_at(place)] = *value;
                }
            }
        }
        check_finite("the solution", b)
    }

    /// A⁻¹ b in place of each of several right-hand sides, without refinement. LLᵀ and LSLᵀ are read once for all of them. Each solution
    /// has the bits of [`SymmetricFactor::solve_in_place`].
    ///
    /// # Errors
    /// As [`SymmetricFactor::solve_in_place`].
    pub fn solve_each_in_place(&self, sides: &mut [Vec<f64>]) -> Result<(), LinearAlgebraError> {
        if let Kind::Pivoted(_) = &self.kind {
            return sides.iter_mut().try_for_each(|b| self.solve_in_place(b));
        }
        sides.iter().try_for_each(|b| check_finite("the right-hand side", b))?;
        let loads: Vec<&[f64]> = sides.iter().map(Vec::as_slice).collect();
        let mut found = self.solve_lower_each(&loads)?;
        found.iter_mut().for_each(|y| self.apply_signs(y));
        for (b, x) in sides.iter_mut().zip(self.solve_upper_each(found)?) {
            *b = x;
            check_finite("the solution", b)?;
        }
        Ok(())
    }

    /// Solution of A x = b with iterative refinement, at most `max_steps` of it, until the residual is at the rounding
    /// level of the whole system or no longer halves; and further, as long as an equation is off by more than 1e-12
    /// of its own terms. `matrix` may differ slightly from the one that was factored.
    ///
    /// # Errors
    /// As [`SymmetricFactor::solve_in_place`], and [`LinearAlgebraError::Inaccurate`] if an equation
    /// stays off by more than 1e-10 of its terms.
    pub fn solve_refined(
        &self,
        matrix: &CsrMatrix,
        b: &[f64],
        max_steps: usize,
    ) -> Result<Refined, LinearAlgebraError> {
        self.solve_side_refined(&Side::plain(matrix), Threads::ONE, matrix.row_sum_norm(), b, max_steps)
    }

    /// A refined solution for a matrix, or its transposed, whose ‖A‖∞ is known.
    ///
    /// # Errors
    /// Those of [`SymmetricFactor::solve_refined`].
    #[doc(hidden)]
    pub fn solve_side_refined(
        &self,
        side: &Side<'_>,
        threads: Threads,
        matrix_norm: f64,
        b: &[f64],
        max_steps: usize,
    ) -> Result<Refined, LinearAlgebraError> {
        self.solve_sides_refined(&[(side, b)], threads, matrix_norm, max_steps)?.swap_remove(0)
    }

    /// Refined solutions of several systems whose matrices have a known ‖A‖∞: with LLᵀ and LSLᵀ each step reads the factor once for all that still
    /// need it. Each has the bits of [`SymmetricFactor::solve_side_refined`].
    ///
    /// # Errors
    /// Those of the first solve, for all systems; of each system those of [`SymmetricFactor::solve_refined`].
    #[doc(hidden)]
    pub fn solve_sides_refined(
        &self,
        systems: &[(&Side<'_>, &[f64])],
        threads: Threads,
        matrix_norm: f64,
        max_steps: usize,
    ) -> Result<Vec<Result<Refined, LinearAlgebraError>>, LinearAlgebraError> {
        let largest_loads: Vec<f64> = systems.iter().map(|(_, b)| largest(b)).collect();
        let backward = |k: usize, x: &[f64], residual: &Residual| {
            let scale = matrix_norm * largest(x) + largest_loads[k];
            if scale == 0.0 { 0.0 } else { largest(&residual.rest) / scale }
        };
        let is_enough = |_: usize, whole: f64| whole <= ROUNDING;
        let rule = Rule { steps: max_steps, error: &backward, is_enough: &is_enough };
        let refined = refine_each(threads, systems, &rule, |_, mut sides| {
            self.solve_each_in_place(&mut sides)?;
            Ok::<_, LinearAlgebraError>(sides)
        })?;
        let finish = |(k, (mut found, steps)): (usize, (Refinement<'_, Side<'_>>, usize))| -> Result<_, LinearAlgebraError> {
            found.finish(|change| self.solve_in_place(change))?;
            let Refinement { x, residual, .. } = found;
            let b_norm = norm(systems[k].1);
            let relative_residual = if b_norm == 0.0 { 0.0 } else { norm(&residual.rest) / b_norm };
            let backward_error = residual.worst().error;
            Ok(Refined { solution: x, relative_residual, backward_error, steps })
        };
        Ok(refined.into_iter().enumerate().map(finish).collect())
    }
}

impl Preconditioner for &SymmetricFactor {
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
        z.copy_from_slice(r);
        Ok(self.solve_in_place(z)?)
    }
}
