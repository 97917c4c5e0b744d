//! Sparse factorisation of symmetric matrices: LLᵀ of a positive definite one, LSLᵀ with signs S of a saddle point, LBLᵀ of any
//! other indefinite one; and LU without exchanges of rows on the same supernodes.

mod numeric;
mod signed;
mod solve;
mod tree_solves;
mod triangular;
mod unpivoted_lu;

use std::sync::Arc;
use std::time::Instant;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::supernodal::{self, SupernodalIntranodeLbltRef, SupernodalLltRef};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Spec};

use self::numeric::{Numeric, Positive};
use super::analysis::{Analysis, LowerTriangle};
use super::csr::CsrMatrix;
use super::error::LinearAlgebraError;
use super::singularity::singular_ratio;
use super::threads::Threads;
use super::vector::largest;
use crate::wide_registers::cleared;
pub use signed::Remainder;
pub use solve::Refined;
pub use unpivoted_lu::UnpivotedLu;

/// A factor of a symmetric matrix, on a shared [`Analysis`].
#[derive(Debug)]
pub struct SymmetricFactor {
    analysis: Arc<Analysis>,
    values: Vec<f64>,
    kind: Kind,
    smallest_pivot_ratio: f64,
    negative_eigenvalues: usize,
    /// Those of the factorisation, which solves use too.
    threads: Threads,
    seconds: f64,
}

/// Middle factor between L and Lᵀ.
#[derive(Debug)]
enum Kind {
    /// Nothing: LLᵀ.
    Positive,
    /// Signs: LSLᵀ.
    Signed {
        /// Places of the negative ones in the order of elimination.
        negative: Vec<u32>,
        /// Number of pivots that were replaced.
        replaced: usize,
    },
    /// Blocks of one or two: LBLᵀ.
    Pivoted(Pivoting),
}

/// The part that Bunch–Kaufman pivoting inside supernodes adds to a factor.
#[derive(Debug)]
struct Pivoting {
    below_diagonal: Vec<f64>,
    forward: Vec<u32>,
    backward: Vec<u32>,
}

impl SymmetricFactor {
    /// LLᵀ of a symmetric positive definite matrix. Of two entries (i, j) and (j, i) that differ by rounding, the one in the row of the
    /// unknown that is eliminated first is read. `storage` is memory to reuse, for example [`SymmetricFactor::into_storage`] of an
    /// earlier factor; it may be empty.
    ///
    /// # Errors
    /// If the matrix is not positive definite or singular (the error names the unknown), an entry is not
    /// finite, the pattern is not the analysed one, or memory is too small.
    pub fn cholesky(
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        Self::cholesky_on(Threads::ONE, analysis, matrix, storage)
    }

    /// The factor LLᵀ on several threads, with the same bits for any number of them. Solves with it use these threads, too.
    ///
    /// # Errors
    /// As [`SymmetricFactor::cholesky`].
    pub fn cholesky_on(
        threads: Threads,
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        matrix.check_finite()?;
        let numeric = Numeric::new(Positive, analysis, matrix)?;
        let mut values = room(analysis.factor_entries(), storage)?;
        let supernodes = &analysis.supernodes;
        numeric.factorise(threads, &mut values).map_err(|place| LinearAlgebraError::NotPositiveDefinite {
            unknown: analysis.order[place] as usize,
        })?;
        let mut smallest = SmallestPivot::new(analysis.size());
        let diagonal = matrix.diagonal();
        let factor = SupernodalLltRef::new(supernodes, &values);
        for s in 0..supernodes.n_supernodes() {
            let node = factor.supernode(s);
            for j in 0..node.val().ncols() {
                let unknown = analysis.order[node.start() + j] as usize;
                smallest.visit(unknown, node.val()[(j, j)].powi(2), diagonal[unknown])?;
            }
        }
        Ok(Self {
            analysis: analysis.clone(),
            values,
            kind: Kind::Positive,
            smallest_pivot_ratio: smallest.ratio,
            negative_eigenvalues: 0,
            threads,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// LBLᵀ of a symmetric indefinite matrix, with Bunch–Kaufman pivoting inside supernodes. Pivoting is
    /// confined to supernodes, so solve with [`SymmetricFactor::solve_refined`], which measures the error.
    /// Only the upper triangle is read; `storage` as in [`SymmetricFactor::cholesky`].
    ///
    /// # Errors
    /// If the matrix is singular (the error names the unknown) or a block on the diagonal of the reordered
    /// matrix is, an entry is not finite, the pattern is not the analysed one, or memory is too small.
    pub fn indefinite(
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        matrix.check_finite()?;
        let lower = analysis.lower(matrix)?;
        let lower_values = lower.values(matrix.values());
        let mut values = room(analysis.factor_entries(), storage)?;
        let supernodes = &analysis.supernodes;
        let size = analysis.size();
        let params = Spec::default();
        let request = supernodal::factorize_supernodal_numeric_intranode_lblt_scratch::<u32, f64>(
            supernodes,
            Par::Seq,
            params,
        );
        let mut memory = MemBuffer::try_new(request).map_err(|_| NO_MEMORY)?;
        let mut pivoting = Pivoting {
            below_diagonal: vec![0.0; size],
            forward: (0..size as u32).collect(),
            backward: (0..size as u32).collect(),
        };
        let factorise = || {
            supernodal::factorize_supernodal_numeric_intranode_lblt(
                &mut values,
                &mut pivoting.below_diagonal,
                &mut pivoting.forward,
                &mut pivoting.backward,
                lower_matrix(size, lower, &lower_values),
                supernodes,
                Par::Seq,
                MemStack::new(&mut memory),
                params,
            )
        };
        cleared(factorise);
        let mut smallest = SmallestPivot::new(analysis.size());
        let permutation = PermRef::new_checked(&pivoting.forward, &pivoting.backward, size);
        let factor =
            SupernodalIntranodeLbltRef::new(supernodes, &values, &pivoting.below_diagonal, permutation);
        let unknown_at = |place: usize| analysis.order[pivoting.forward[place] as usize] as usize;
        let scale = |unknown: usize| largest(matrix.row(unknown).1);
        let mut negative_eigenvalues = 0;
        for s in 0..supernodes.n_supernodes() {
            let node = factor.supernode(s);
            let mut j = 0;
            while j < node.val().ncols() {
                let place = node.start() + j;
                let unknown = unknown_at(place);
                let (a, b) = (node.val()[(j, j)], pivoting.below_diagonal[place]);
                if b == 0.0 {
                    smallest.visit(unknown, a.abs(), scale(unknown))?;
                    negative_eigenvalues += usize::from(a < 0.0);
                    j += 1;
                } else {
                    // A 2 × 2 pivot [a b; b c]: its smaller eigenvalue is about |det| / (largest entry).
                    let c = node.val()[(j + 1, j + 1)];
                    let pivot = (a * c - b * b).abs() / largest(&[a, b, c]);
                    smallest.visit(unknown, pivot, scale(unknown).max(scale(unknown_at(place + 1))))?;
                    // One of two signs where the determinant is negative, else both of one.
                    negative_eigenvalues += match a * c > b * b {
                        false => 1,
                        true => 2 * usize::from(a < 0.0),
                    };
                    j += 2;
                }
            }
        }
        Ok(Self {
            analysis: analysis.clone(),
            values,
            kind: Kind::Pivoted(pivoting),
            smallest_pivot_ratio: smallest.ratio,
            negative_eigenvalues,
            threads: Threads::ONE,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// LLᵀ, or LBLᵀ if the matrix turns out not to be positive definite.
    ///
    /// # Errors
    /// As [`SymmetricFactor::indefinite`].
    pub fn cholesky_or_indefinite(
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        Self::cholesky_or_indefinite_on(Threads::ONE, analysis, matrix, storage)
    }

    /// The factor LLᵀ or LBLᵀ, LLᵀ on several threads and LBLᵀ on one.
    ///
    /// # Errors
    /// As [`SymmetricFactor::indefinite`].
    pub fn cholesky_or_indefinite_on(
        threads: Threads,
        analysis: &Arc<Analysis>,
        matrix: &CsrMatrix,
        storage: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        match Self::cholesky_on(threads, analysis, matrix, storage) {
            Err(LinearAlgebraError::NotPositiveDefinite { .. }) => {
                Self::indefinite(analysis, matrix, Vec::new())
            }
            other => other,
        }
    }

    /// The analysis of the factor.
    pub fn analysis(&self) -> &Arc<Analysis> {
        &self.analysis
    }

    pub(super) fn supernodes(
        &self,
    ) -> &faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky<u32> {
        &self.analysis.supernodes
    }

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether this is an LLᵀ factor, so that the matrix is positive definite.
    pub fn is_positive_definite(&self) -> bool {
        matches!(self.kind, Kind::Positive)
    }

    /// Smallest pivot divided by its diagonal's scale, over all unknowns.
    pub fn smallest_pivot_ratio(&self) -> f64 {
        self.smallest_pivot_ratio
    }

    /// The number of negative eigenvalues of the matrix, by Sylvester's law of inertia: that of its pivots. It is that of a matrix nearby
    /// as far as [`SymmetricFactor::solve_refined`] finds accurate solutions, and for LSLᵀ as far as the [`SymmetricFactor::remainder`] is less
    /// than one.
    pub fn negative_eigenvalues(&self) -> usize {
        self.negative_eigenvalues
    }

    /// Threads that factored it, and that solve with it.
    pub fn threads(&self) -> Threads {
        self.threads
    }

    /// Seconds that the factorisation took.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// This factor without the memory for further factorisations on its analysis, if no other factor shares it.
    pub fn for_solves(self) -> Self {
        let analysis = match Arc::try_unwrap(self.analysis) {
            Ok(own) => Arc::new(own.for_solves()),
            Err(shared) => shared,
        };
        Self { analysis, ..self }
    }

    /// The factor's memory, to be reused.
    pub fn into_storage(self) -> Vec<f64> {
        self.values
    }
}

const NO_MEMORY: LinearAlgebraError = LinearAlgebraError::OutOfMemory { what: "the factor" };

/// Numbers for a factor, as they are in a storage of the same size, else zero.
fn room(count: usize, storage: Vec<f64>) -> Result<Vec<f64>, LinearAlgebraError> {
    if storage.len() == count {
        return Ok(storage);
    }
    drop(storage);
    // Memory that is zero from the start is touched by the threads that need it; whether there is enough is asked before.
    Vec::<f64>::new().try_reserve_exact(count).map_err(|_| NO_MEMORY)?;
    Ok(vec![0.0; count])
}

fn lower_matrix<'a>(
    size: usize,
    lower: &'a LowerTriangle,
    values: &'a [f64],
) -> SparseColMatRef<'a, u32, f64> {
    let LowerTriangle { pointers, rows, .. } = lower;
    let symbolic = SymbolicSparseColMatRef::new_unsorted_checked(size, size, pointers, None, rows);
    SparseColMatRef::new(symbolic, values)
}

/// Follows the smallest ratio of a pivot to its scale, and stops at one that is zero up to rounding.
struct SmallestPivot {
    ratio: f64,
    threshold: f64,
}

impl SmallestPivot {
    fn new(size: usize) -> Self {
        Self { ratio: f64::INFINITY, threshold: singular_ratio(size) }
    }

    fn visit(&mut self, unknown: usize, pivot: f64, scale: f64) -> Result<(), LinearAlgebraError> {
        let ratio = if scale == 0.0 { 0.0 } else { pivot / scale };
        if ratio <= self.threshold || ratio.is_nan() {
            return Err(LinearAlgebraError::Singular { unknown, ratio });
        }
        self.ratio = self.ratio.min(ratio);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
