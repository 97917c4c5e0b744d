//! Errors of sparse matrices and factorisations.

use super::vector::first_not_finite;

/// Errors of a sparse matrix or of its factorisation, with their position.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum LinearAlgebraError {
    /// A vector or matrix has the wrong size.
    #[error("{what} has size {found}, expected {expected}")]
    SizeMismatch {
        /// The vector, the matrix or the list.
        what: &'static str,
        /// Size that the operation needs.
        expected: usize,
        /// Size that was given.
        found: usize,
    },
    /// A row or column number lies outside the matrix.
    #[error("{what} {index} lies outside 0..{size}")]
    IndexOutOfRange {
        /// "row" or "column".
        what: &'static str,
        /// The number given.
        index: usize,
        /// Count of rows or columns.
        size: usize,
    },
    /// A list that must be strictly ascending is not.
    #[error("{what} must be strictly ascending, but entry {position} is not larger than its predecessor")]
    NotAscending {
        what: &'static str,
        /// First position that breaks the order.
        position: usize,
    },
    /// Two matrices that must share a sparsity pattern do not.
    #[error("the matrices have different sparsity patterns ({what})")]
    PatternMismatch { what: &'static str },
    /// A matrix entry is NaN or infinite.
    #[error("matrix entry ({row}, {column}) is {value}")]
    EntryNotFinite {
        row: usize,
        column: usize,
        /// NaN or an infinity.
        value: f64,
    },
    /// A vector entry is NaN or infinite.
    #[error("entry {index} of {what} is {value}")]
    VectorNotFinite {
        what: &'static str,
        /// Position in the vector.
        index: usize,
        /// NaN or an infinity.
        value: f64,
    },
    /// The Cholesky factorisation met a pivot that is not positive.
    #[error("the matrix is not positive definite: the pivot of unknown {unknown} is not positive")]
    NotPositiveDefinite {
        /// Unknown (row number of the matrix) whose pivot failed.
        unknown: usize,
    },
    /// A pivot is zero up to rounding.
    #[error("the matrix is singular: the pivot of unknown {unknown} is {ratio:e} of its scale")]
    Singular {
        /// Unknown (row number of the matrix) with that pivot.
        unknown: usize,
        /// Pivot divided by the largest entry of the row before elimination; in an LU factorisation, the
        /// smallest singular value of the scaled matrix.
        ratio: f64,
    },
    /// The matrix is not singular as far as rounding can tell, but too close to a singular one for a solution with
    /// correct digits: the rounding of its entries alone moves the solution by about its condition times 1e-16.
    #[error(
        "the matrix is ill-conditioned: its condition is at least {condition:e}, in the direction of unknown {unknown}"
    )]
    IllConditioned {
        /// Unknown (row number of the matrix) that is determined least.
        unknown: usize,
        /// A lower bound of the condition number of the matrix with its diagonal scaled to one.
        condition: f64,
    },
    /// A solution could not be brought to a small residual.
    #[error(
        "the solution is inaccurate: equation {row} is off by {backward_error:e} of its terms after refinement"
    )]
    Inaccurate {
        /// Row number of the equation with the largest error relative to its own terms.
        row: usize,
        /// |b − A x| / (|A| |x| + |b|) in that row.
        backward_error: f64,
    },
    /// The matrix or its factor has more entries than 32-bit indices can count.
    #[error("{what} has too many entries for 32-bit indices")]
    TooLarge {
        /// The matrix or the factor.
        what: &'static str,
    },
    /// There is not enough memory.
    #[error("not enough memory for {what}")]
    OutOfMemory {
        /// The object to be stored.
        what: &'static str,
    },
}

/// Check that `found` equals `expected`.
///
/// # Errors
/// [`LinearAlgebraError::SizeMismatch`].
#[doc(hidden)]
pub fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), LinearAlgebraError> {
    if expected == found { Ok(()) } else { Err(LinearAlgebraError::SizeMismatch { what, expected, found }) }
}

/// Check for an entry that is NaN or infinite.
///
/// # Errors
/// [`LinearAlgebraError::VectorNotFinite`].
#[doc(hidden)]
pub fn check_finite(what: &'static str, values: &[f64]) -> Result<(), LinearAlgebraError> {
    match first_not_finite(values) {
        None => Ok(()),
        Some(index) => Err(LinearAlgebraError::VectorNotFinite { what, index, value: values[index] }),
    }
}
