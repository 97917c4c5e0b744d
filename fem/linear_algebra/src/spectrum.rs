//! Extreme eigenvalues of a preconditioned symmetric operator, by Lanczos' method.

use super::krylov::KrylovError;
use super::operator::{LinearOperator, Preconditioner};
use super::vector::{add_scaled_on, dot_on, in_pieces};
use crate::threads::Threads;

/// Extreme Ritz values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// The smallest; the smallest eigenvalue is not larger.
    pub smallest: f64,
    /// The largest; the largest eigenvalue is not smaller.
    pub largest: f64,
    /// Steps that were made: fewer than asked for when the Krylov space was exhausted.
    pub steps: usize,
}

/// Estimates of the extreme eigenvalues of M⁻¹ A by some steps of Lanczos' method from a fixed irregular vector. Both must
/// be symmetric, the preconditioner M positive definite; A may be indefinite.
///
/// # Errors
/// If the operator or the preconditioner fails, or a value is not finite.
pub fn spectrum(
    operator: &impl LinearOperator,
    preconditioner: &mut impl Preconditioner,
    steps: usize,
    threads: Threads,
) -> Result<Spectrum, KrylovError> {
    let size = operator.size();
    // v is M q, z is q for the M-orthonormal basis vector q.
    let mut v: Vec<f64> = irregular(size).collect();
    let (mut before, mut z, mut image) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
    preconditioner.precondition(&v, &mut z).map_err(KrylovError::Operator)?;
    let mut beta = dot_on(threads, &v, &z).sqrt();
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    while diagonal.len() < steps.min(size) && beta > 0.0 {
        for vector in [&mut v, &mut z] {
            in_pieces(threads, vector, 1, |_, piece| piece.iter_mut().for_each(|value| *value /= beta));
        }
        operator.apply(&z, &mut image).map_err(KrylovError::Operator)?;
        add_scaled_on(threads, &mut image, -beta * f64::from(u8::from(!diagonal.is_empty())), &before);
        let alpha = dot_on(threads, &image, &z);
        add_scaled_on(threads, &mut image, -alpha, &v);
        diagonal.push(alpha);
        std::mem::swap(&mut before, &mut v);
        std::mem::swap(&mut v, &mut image);
        preconditioner.precondition(&v, &mut z).map_err(KrylovError::Operator)?;
        beta = dot_on(threads, &v, &z).max(0.0).sqrt();
        if !alpha.is_finite() || !beta.is_finite() {
            return Err(KrylovError::NotFinite(super::KrylovReport::default()));
        }
        // What is left of an exhausted Krylov space is rounding.
        if beta <= 1e-12 * diagonal.iter().fold(0.0_f64, |sum, value| sum.max(value.abs())) {
            break;
        }
        beside.push(beta);
    }
    beside.truncate(diagonal.len().saturating_sub(1));
    let (smallest, largest) = extremes_of_tridiagonal(&diagonal, &beside);
    Ok(Spectrum { smallest, largest, steps: diagonal.len() })
}

/// Numbers between −1 and 1 without a pattern, the same in every run.
#[doc(hidden)]
pub fn irregular(size: usize) -> impl Iterator<Item = f64> {
    irregular_from(0x9e37_79b9_7f4a_7c15, size)
}

/// Numbers without a pattern, from a seed other than zero.
#[doc(hidden)]
pub fn irregular_from(seed: u64, size: usize) -> impl Iterator<Item = f64> {
    let mut state = seed;
    (0..size).map(move |_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

/// Smallest and largest eigenvalue of a symmetric tridiagonal matrix, by bisection on Sturm's count.
fn extremes_of_tridiagonal(diagonal: &[f64], beside: &[f64]) -> (f64, f64) {
    let size = diagonal.len();
    let radius = |i: usize| {
        let before = i.checked_sub(1).map_or(0.0, |k| beside[k].abs());
        before + beside.get(i).map_or(0.0, |value| value.abs())
    };
    let low = (0..size).map(|i| diagonal[i] - radius(i)).fold(f64::INFINITY, f64::min);
    let high = (0..size).map(|i| diagonal[i] + radius(i)).fold(f64::NEG_INFINITY, f64::max);
    // The number of eigenvalues below a shift.
    let below = |shift: f64| {
        let mut pivot = 1.0_f64;
        let mut count = 0;
        for (i, value) in diagonal.iter().enumerate() {
            let coupling = i.checked_sub(1).map_or(0.0, |k| beside[k] * beside[k]);
            pivot = value - shift - coupling / pivot;
            if pivot == 0.0 {
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    };
    let bisect = |enough: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (low, high);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if enough(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        0.5 * (low + high)
    };
    if size == 0 {
        return (0.0, 0.0);
    }
    (bisect(&|shift| below(shift) >= 1), bisect(&|shift| below(shift) >= size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Identity;
    use crate::{CsrMatrix, LinearOperator};

    /// The five-point Laplacian on m × m nodes; eigenvalues 4 − 2 cos kπ/(m+1) − 2 cos lπ/(m+1).
    fn laplacian(m: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for node in 0..m * m {
            triplets.push((node, node, 4.0));
            for (step, place) in [(1, node % m), (m, node / m)] {
                if place + 1 < m {
                    triplets.extend([(node, node + step, -1.0), (node + step, node, -1.0)]);
                }
            }
        }
        CsrMatrix::from_triplets(m * m, m * m, &triplets).unwrap()
    }

    #[test]
    fn ritz_values_approach_the_extreme_eigenvalues_from_inside() {
        let m = 20;
        let c = 4.0 * (std::f64::consts::PI / (m as f64 + 1.0)).cos();
        let few = spectrum(&laplacian(m), &mut Identity, 10, Threads::ONE).unwrap();
        assert!(few.largest <= 4.0 + c + 1e-12 && few.largest > 0.9 * (4.0 + c), "{few:?}");
        let many = spectrum(&laplacian(m), &mut Identity, 120, Threads::ONE).unwrap();
        assert!((many.largest - 4.0 - c).abs() < 1e-8, "{many:?}");
        assert!((many.smallest - 4.0 + c).abs() < 1e-6, "{many:?}");
    }

    #[test]
    fn an_exhausted_space_ends_the_steps() {
        let matrix = CsrMatrix::from_triplets(3, 3, &[(0, 0, 1.0), (1, 1, -2.0), (2, 2, 5.0)]).unwrap();
        let found = spectrum(&matrix, &mut Identity, 50, Threads::ONE).unwrap();
        assert!(found.steps <= 3);
        assert!((found.smallest + 2.0).abs() < 1e-12 && (found.largest - 5.0).abs() < 1e-12, "{found:?}");
        assert_eq!(LinearOperator::size(&matrix), 3);
        let broken = CsrMatrix::from_triplets(1, 1, &[(0, 0, f64::NAN)]).unwrap();
        assert!(matches!(spectrum(&broken, &mut Identity, 3, Threads::ONE), Err(KrylovError::NotFinite(_))));
    }
}
