//! Chebyshev polynomials as smoothers: symmetric, without inner products, as parallel as the matrix-vector product.

use super::super::block_matrix::BlockMatrix;
use super::super::error::LinearAlgebraError;
use super::super::krylov::KrylovError;
use super::super::operator::OnThreads;
use super::super::spectrum::spectrum;
use super::super::vector::add_scaled_on;
use super::diagonal::BlockDiagonal;
use crate::threads::Threads;

/// Lanczos steps that estimate the largest eigenvalue. Ten leave it 5 to 10 % too small.
const STEPS: usize = 12;
/// Products with the matrix that a smoother needs to be made.
pub(super) const PRODUCTS: usize = STEPS;
/// By how much the estimate is enlarged.
const MARGIN: f64 = 1.1;

/// A polynomial in D⁻¹ A that damps the upper part of the spectrum, with D the diagonal blocks.
#[derive(Clone, Debug)]
pub struct Chebyshev {
    degree: usize,
    /// Middle and half width of the interval that is damped.
    centre: f64,
    half_width: f64,
    largest_eigenvalue: f64,
    threads: Threads,
}

impl Chebyshev {
    /// A smoother of a degree ≥ 1 that damps eigenvalues of D⁻¹ A from λ / `range` to λ, the largest.
    ///
    /// # Errors
    /// If the products fail or the matrix has an entry that is not finite.
    pub fn new(
        matrix: &BlockMatrix,
        diagonal: &BlockDiagonal,
        degree: usize,
        range: f64,
        threads: Threads,
    ) -> Result<Self, LinearAlgebraError> {
        let found = spectrum(&OnThreads(matrix, threads), &mut &*diagonal, STEPS, threads);
        let found = found.map_err(|error| match error {
            KrylovError::BadArguments(error) => error,
            _ => matrix
                .to_csr()
                .check_finite()
                .err()
                .unwrap_or(LinearAlgebraError::Inaccurate { row: 0, backward_error: f64::NAN }),
        })?;
        let top = MARGIN * found.largest;
        let bottom = top / range;
        let (centre, half_width) = (0.5 * (top + bottom), 0.5 * (top - bottom));
        Ok(Chebyshev {
            degree: degree.max(1),
            centre,
            half_width,
            largest_eigenvalue: found.largest,
            threads,
        })
    }

    /// The degree of the polynomial.
    pub(super) fn degree(&self) -> usize {
        self.degree
    }

    /// The estimated largest eigenvalue of D⁻¹ A.
    pub fn largest_eigenvalue(&self) -> f64 {
        self.largest_eigenvalue
    }

    /// Improves x, whose residual is r; x = 0 needs r = b. `r` is updated to the residual of the new x if
    /// `with_residual`, which costs one product more. `d` and `image` are room for two vectors.
    pub(super) fn smooth(
        &self,
        (matrix, diagonal): (&BlockMatrix, &BlockDiagonal),
        x: &mut [f64],
        r: &mut [f64],
        (d, image): (&mut [f64], &mut [f64]),
        with_residual: bool,
    ) -> Result<(), LinearAlgebraError> {
        let ratio = self.centre / self.half_width;
        let mut rho = 1.0 / ratio;
        d.fill(0.0);
        diagonal.apply(1.0 / self.centre, r, 0.0, d);
        for step in 1..=self.degree {
            if step == self.degree && !with_residual {
                add_scaled_on(self.threads, x, 1.0, d);
                break;
            }
            matrix.multiply_on(self.threads, d, image)?;
            add_scaled_on(self.threads, x, 1.0, d);
            add_scaled_on(self.threads, r, -1.0, image);
            if step < self.degree {
                let next = 1.0 / (2.0 * ratio - rho);
                diagonal.apply(2.0 * next / self.half_width, r, next * rho, d);
                rho = next;
            }
        }
        Ok(())
    }
}
