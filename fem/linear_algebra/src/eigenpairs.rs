//! A few eigenpairs of symmetric pencils A x = λ B x above a shift, with a count that proves that none is missing.
//!
//! Lanczos' method for (A − σ B)⁻¹ B from a few irregular vectors, with full reorthogonalisation in the inner product of the pencil's
//! positive matrix and thick restarts (Wu and Simon 2000, SIAM J. Matrix Anal. Appl. 22; buckling: Grimes, Lewis and Simon 1994, ibid.
//! 15). The count is Sylvester's law of inertia: the signs of the pivots of A − τ B tell how many eigenvalues are below τ.

mod krylov_space;
mod pencil;

use self::krylov_space::{KrylovSpace, Ritz};
#[doc(hidden)]
pub use self::pencil::{FactoredPencil, Pencil, amounts_of, check_symmetric, on_one_pattern};
pub use self::pencil::{Positive, SymmetricPencil};
use super::error::LinearAlgebraError;
use super::vector::{add_scaled, largest};
use pencil::Shifted;

/// An eigenvalue with a vector of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenpair {
    /// λ.
    pub value: f64,
    /// x, of length one in the norm of the pencil's positive matrix.
    pub vector: Vec<f64>,
    /// |λ − λ*| is at most this for an exact eigenvalue λ* \[λ\], except for the rounding of solutions with A − σ B.
    pub error_bound: f64,
    /// ‖A x − λ B x‖ relative to the norm of its terms, |A| |x| + |λ| |B| |x|.
    pub residual: f64,
}

/// Errors of eigenproblems.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum EigenError {
    /// A matrix that is not symmetric.
    #[error(
        "the {which} matrix of the eigenproblem is not symmetric: two entries differ by {asymmetry:e} of their size"
    )]
    NotSymmetric {
        /// "first" or "second".
        which: &'static str,
        /// The largest difference relative to the size of the entries.
        asymmetry: f64,
    },
    /// The matrix that measures lengths is not positive.
    #[error("the {which} matrix of the eigenproblem is not positive: a vector has the square {square:e}")]
    NotPositive {
        /// "first" or "second".
        which: &'static str,
        /// xᵀ B x, or xᵀ A x.
        square: f64,
    },
    /// The shift is an eigenvalue.
    #[error("the shift {shift:e} is an eigenvalue, up to rounding ({source}): take one below it")]
    ShiftIsEigenvalue { shift: f64, source: LinearAlgebraError },
    /// Fewer eigenvalues than requested.
    #[error("{asked} eigenvalues above {shift:e} were asked for, and there are {found}")]
    TooFew {
        /// The number asked for.
        asked: usize,
        found: usize,
        shift: f64,
    },
    /// A pair that did not converge.
    #[error(
        "eigenpair {pair} (counted from 0, value {value:e}) did not converge: its residual is {residual:e} of its terms"
    )]
    NotConverged {
        /// Its number.
        pair: usize,
        value: f64,
        /// Its residual relative to its terms.
        residual: f64,
    },
    /// The count of eigenvalues and those that were found differ.
    #[error("{counted} eigenvalues are between {shift:e} and {end:e}, and {found} of them were found")]
    Missed {
        counted: usize,
        found: usize,
        shift: f64,
        /// The end of the count.
        end: f64,
    },
    /// A matrix is unfit, or could not be factored.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
}

/// Vectors from which the Krylov space grows side by side: as many equal eigenvalues are seen at once.
const BLOCK: usize = 3;
/// Residual of a Ritz pair relative to its value at which it counts as found.
const FOUND: f64 = 1e-12;
/// The same of the pair behind those asked for, next to which the count ends.
const GUESSED: f64 = 1e-3;
/// Residual of an eigenpair relative to its terms above which it is not one.
const HOLDS: f64 = 1e-9;
/// Residual of a solution with A − σ B relative to the terms of that matrix, at which the shift is an eigenvalue.
const SINGULAR: f64 = 2e-14;
/// Part of their distance from the shift by which two eigenvalues differ, so that a count may end between them.
const APART: f64 = 1e-6;
/// Restarts, and counts of the same eigenvalues.
const MOST_RESTARTS: usize = 300;
const MOST_COUNTS: usize = 6;
/// Restarts with new vectors after which no further eigenvalue above the shift is expected.
const MOST_BARREN: usize = 8;

impl SymmetricPencil {
    /// The next `count` eigenvalues above a shift in ascending order, with their vectors, which are orthonormal in the positive matrix.
    /// Multiple eigenvalues are returned with their multiplicity.
    ///
    /// # Errors
    /// [`EigenError`].
    pub fn eigenpairs_above(&self, shift: f64, count: usize) -> Result<Vec<Eigenpair>, EigenError> {
        eigenpairs_above(self, shift, count)
    }
}

/// Eigenpairs of any pencil, as [`SymmetricPencil::eigenpairs_above`] has them.
///
/// # Errors
/// Those of the pencil, and [`EigenError`].
#[doc(hidden)]
pub fn eigenpairs_above<P: Pencil>(pencil: &P, shift: f64, count: usize) -> Result<Vec<Eigenpair>, P::Error> {
    if count == 0 {
        return Ok(vec![]);
    }
    let shifted = Shifted::of(pencil, shift)?;
    let mut space = KrylovSpace::new(pencil, &shifted);
    space.add_irregular(BLOCK)?;
    check_shift(pencil, shift, space.first())?;
    let (mut wanted, mut counts, mut barren) = (count + 1, 0, 0);
    let mut latest = None;
    for _ in 0..MOST_RESTARTS {
        space.grow_to((2 * wanted + 4 * BLOCK).max(24))?;
        let ritz = space.ritz_values()?;
        let converged = ritz.iter().take_while(|pair| pair.residual <= FOUND * pair.value + pair.rounding);
        let converged = converged.count();
        // All that are positive have converged, and new vectors bring no other.
        barren = if converged == ritz.len() { barren + 1 } else { 0 };
        let complete = space.is_exhausted() || barren >= MOST_BARREN;
        if complete && ritz.len() < count {
            return Err(EigenError::TooFew { asked: count, found: ritz.len(), shift }.into());
        }
        match end_of_count(&ritz, count, converged, shift, complete) {
            Some((found, end)) => {
                let counted = shifted.count_up_to(pencil, end)?;
                if counted == found {
                    return finished(pencil, &shifted, space.vectors(&ritz[..count]));
                }
                counts += 1;
                if counted < found || counts == MOST_COUNTS {
                    return Err(EigenError::Missed { counted, found, shift, end }.into());
                }
                space.restart(&ritz, wanted);
                space.add_irregular(BLOCK)?;
            }
            None => {
                // Equal eigenvalues at the end: all of them.
                wanted = wanted.max(converged + 1);
                space.restart(&ritz, wanted);
                if barren > 0 {
                    space.add_irregular(BLOCK)?;
                }
            }
        }
        latest = ritz.get(converged).map(|pair| (converged, *pair));
    }
    let (pair, ritz) = latest.unwrap_or_default();
    let value = shift + 1.0 / ritz.value;
    Err(EigenError::NotConverged { pair, value, residual: ritz.residual / ritz.value }.into())
}

/// A singular matrix may have a factor in rounded numbers. What is solved with it is then a vector that it takes to zero.
fn check_shift<P: Pencil>(pencil: &P, shift: f64, solved: &[f64]) -> Result<(), P::Error> {
    let ratio = residual(pencil, shift, solved)?;
    if ratio > SINGULAR {
        return Ok(());
    }
    let largest = largest(solved);
    let unknown = solved.iter().position(|entry| entry.abs() == largest).unwrap_or(0);
    Err(EigenError::ShiftIsEigenvalue { shift, source: LinearAlgebraError::Singular { unknown, ratio } }
        .into())
}

/// Makes eigenpairs of Ritz vectors, each judged by itself.
fn finished<P: Pencil>(
    pencil: &P,
    shifted: &Shifted<P>,
    vectors: Vec<Vec<f64>>,
) -> Result<Vec<Eigenpair>, P::Error> {
    let mut pairs = vec![];
    for (pair, vector) in vectors.into_iter().enumerate() {
        // Once more through the operator: what does not belong to the vector shrinks.
        let mut vector = shifted.apply(pencil, &vector)?;
        let length = pencil.length(&vector)?;
        vector.iter_mut().for_each(|entry| *entry /= length);
        let mut image = shifted.apply(pencil, &vector)?;
        let inverse = pencil.product(&vector, &image)?;
        add_scaled(&mut image, -inverse, &vector);
        let off = pencil.length(&image)? / inverse;
        let value = shifted.shift + 1.0 / inverse;
        let residual = residual(pencil, value, &vector)?;
        // A value that is no number is not small.
        if !(residual <= HOLDS && off < 1.0 && inverse > 0.0) {
            return Err(EigenError::NotConverged { pair, value, residual: residual.max(off) }.into());
        }
        let error_bound = off / (1.0 - off) / inverse;
        pairs.push(Eigenpair { value, vector, error_bound, residual });
    }
    pairs.sort_by(|one, other| one.value.total_cmp(&other.value));
    Ok(pairs)
}

/// ‖A x − λ B x‖ relative to ‖|A| |x| + |λ| |B| |x|‖.
fn residual<P: Pencil>(pencil: &P, value: f64, x: &[f64]) -> Result<f64, P::Error> {
    let (first, second) = (pencil.first(x)?, pencil.second(x)?);
    let rest: Vec<f64> = first.iter().zip(&second).map(|(first, second)| first - value * second).collect();
    let [rest, terms] = pencil.norms([&rest, &pencil.amounts(value, x)?])?;
    Ok(if rest == 0.0 { 0.0 } else { rest / terms })
}

/// Number of the eigenvalues found that a count shall confirm, and where it ends: behind those asked for, in a gap before the
/// next. None where that is not known yet.
fn end_of_count(
    ritz: &[Ritz],
    count: usize,
    converged: usize,
    shift: f64,
    complete: bool,
) -> Option<(usize, f64)> {
    let distance = |pair: &Ritz| 1.0 / pair.value;
    (count..=converged).find_map(|found| {
        let last = distance(&ritz[found - 1]);
        match ritz.get(found) {
            None if complete => Some((found, shift + 2.0 * last)),
            Some(next) if next.residual <= GUESSED * next.value && distance(next) > last * (1.0 + APART) => {
                Some((found, shift + 0.5 * (last + distance(next))))
            }
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests;
