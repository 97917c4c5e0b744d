//! Residuals judged equation by equation, each beside the sizes of its own terms (Oettli and Prager 1964; Arioli,
//! Demmel and Duff 1989): a stiff part of a system then does not hide a soft one, nor one field another.

use super::block_matrix::BlockMatrix;
use super::csr::CsrMatrix;
use super::error::{LinearAlgebraError, check_size};
use super::transpose::Transpose;

/// Refinement goes on as long as an equation is off by more than this part of its terms.
const AIM: f64 = 1e-12;
/// The most by which an equation may be off in a solution that is handed out.
pub(crate) const ACCEPTED: f64 = 1e-10;
/// Most further steps of refinement.
const STEPS: usize = 8;
/// Smaller residuals are underflow of their terms.
const UNDERFLOW: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// A square matrix by what it takes to judge a solution.
pub(crate) trait Equations {
    /// A x, and of each row Σ |a_ij x_j|.
    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError>;

    /// The diagonal.
    fn diagonal(&self) -> Vec<f64>;
}

/// A matrix, or its transposed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Side<'a> {
    /// A x = b.
    Plain(&'a CsrMatrix),
    /// Aᵀ x = b.
    Transposed(&'a CsrMatrix),
}

impl<'a> Side<'a> {
    /// The side that a solve asks for.
    pub(crate) fn of(matrix: &'a CsrMatrix, transpose: Transpose) -> Self {
        match transpose {
            Transpose::No => Side::Plain(matrix),
            Transpose::Yes => Side::Transposed(matrix),
        }
    }
}

impl Equations for Side<'_> {
    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        match self {
            Side::Plain(matrix) => {
                check_size("the vector to multiply", matrix.columns(), x.len())?;
                let of_row = |row: usize| {
                    let (columns, values) = matrix.row(row);
                    sum_and_size(columns.iter().map(|column| *column as usize).zip(values.iter().copied()), x)
                };
                Ok((0..matrix.rows()).map(of_row).unzip())
            }
            Side::Transposed(matrix) => {
                check_size("the vector to multiply", matrix.rows(), x.len())?;
                let (mut sums, mut sizes) = (vec![0.0; matrix.columns()], vec![0.0; matrix.columns()]);
                for (row, factor) in x.iter().enumerate() {
                    let (columns, values) = matrix.row(row);
                    for (&column, value) in columns.iter().zip(values) {
                        let term = value * factor;
                        sums[column as usize] += term;
                        sizes[column as usize] += term.abs();
                    }
                }
                Ok((sums, sizes))
            }
        }
    }

    fn diagonal(&self) -> Vec<f64> {
        match self {
            Side::Plain(matrix) | Side::Transposed(matrix) => matrix.diagonal(),
        }
    }
}

impl Equations for BlockMatrix {
    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        check_size("the vector to multiply", self.columns(), x.len())?;
        Ok((0..self.rows()).map(|row| sum_and_size(self.row(row), x)).unzip())
    }

    fn diagonal(&self) -> Vec<f64> {
        BlockMatrix::diagonal(self)
    }
}

fn sum_and_size(row: impl Iterator<Item = (usize, f64)>, x: &[f64]) -> (f64, f64) {
    row.fold((0.0, 0.0), |(sum, size), (column, value)| {
        let term = value * x[column];
        (sum + term, size + term.abs())
    })
}

/// The equation that holds worst, and |b − A x|_i beside the sizes of its terms; infinite where a number is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WorstRow {
    pub(crate) row: usize,
    pub(crate) error: f64,
}

/// b − A x, with the sizes of the terms of each equation.
#[derive(Clone, Debug)]
pub(crate) struct Residual {
    /// b − A x.
    pub(crate) rest: Vec<f64>,
    /// |A| |x| + |b|.
    sizes: Vec<f64>,
}

impl Residual {
    /// The residual of x.
    pub(crate) fn of(equations: &impl Equations, x: &[f64], b: &[f64]) -> Result<Self, LinearAlgebraError> {
        let (mut rest, mut sizes) = equations.products(x)?;
        check_size("the right-hand side", rest.len(), b.len())?;
        for ((rest, size), b) in rest.iter_mut().zip(&mut sizes).zip(b) {
            *rest = b - *rest;
            *size += b.abs();
        }
        Ok(Residual { rest, sizes })
    }

    /// The equation that holds worst.
    pub(crate) fn worst(&self) -> WorstRow {
        worst(&self.rest, &self.sizes)
    }

    /// Fails unless each equation holds up to a part of its terms. An equation all of whose terms are rounding of other
    /// ones, as that of a flow that rests under a pressure, is judged beside what its neighbours' terms amount to in it.
    pub(crate) fn check(
        &self,
        equations: &impl Equations,
        x: &[f64],
        level: f64,
    ) -> Result<(), LinearAlgebraError> {
        if self.worst().error <= level {
            return Ok(());
        }
        let diagonal = equations.diagonal();
        let amounts: Vec<f64> = diagonal
            .iter()
            .zip(self.sizes.iter().zip(x))
            .map(|(diagonal, (size, x))| if *diagonal == 0.0 { x.abs() } else { size / diagonal.abs() })
            .collect();
        let (_, mut sizes) = equations.products(&amounts)?;
        sizes.iter_mut().zip(&self.sizes).for_each(|(size, own)| *size += own);
        let WorstRow { row, error } = worst(&self.rest, &sizes);
        if error <= level {
            return Ok(());
        }
        Err(LinearAlgebraError::Inaccurate { row, backward_error: error })
    }
}

fn worst(rest: &[f64], sizes: &[f64]) -> WorstRow {
    let mut worst = WorstRow { row: 0, error: 0.0 };
    for (row, (rest, size)) in rest.iter().zip(sizes).enumerate() {
        // Products come first: divisions are slow, and hardly a row is worse than those before it.
        let rest = rest.abs();
        if rest > worst.error * size && rest > UNDERFLOW {
            worst = WorstRow { row, error: rest / size };
        } else if rest.is_nan() || size.is_nan() {
            return WorstRow { row, error: f64::INFINITY };
        }
    }
    worst
}

/// Improves a solution by iterative refinement until each equation holds up to 1e-12 of its terms, or no step helps.
/// `solve` replaces a vector by A⁻¹ times it.
///
/// # Errors
/// [`LinearAlgebraError::Inaccurate`] with the equation that still is off by more than 1e-10, or as the solve.
pub(crate) fn refined<E: From<LinearAlgebraError>>(
    equations: &impl Equations,
    b: &[f64],
    mut x: Vec<f64>,
    mut residual: Residual,
    mut solve: impl FnMut(&mut Vec<f64>) -> Result<(), E>,
) -> Result<(Vec<f64>, Residual), E> {
    let mut error = residual.worst().error;
    for _ in 0..STEPS {
        if error <= AIM {
            return Ok((x, residual));
        }
        let mut candidate = residual.rest.clone();
        solve(&mut candidate)?;
        candidate.iter_mut().zip(&x).for_each(|(change, x)| *change += x);
        let next = Residual::of(equations, &candidate, b)?;
        let next_error = next.worst().error;
        if next_error >= error {
            break;
        }
        let stalled = next_error > 0.5 * error;
        (x, residual, error) = (candidate, next, next_error);
        if stalled {
            break;
        }
    }
    residual.check(equations, &x, ACCEPTED)?;
    Ok((x, residual))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix() -> CsrMatrix {
        CsrMatrix::from_triplets(2, 2, &[(0, 0, 1e12), (0, 1, -2.0), (1, 0, 3.0), (1, 1, 4.0)]).unwrap()
    }

    #[test]
    fn the_row_that_is_off_is_named_whatever_its_scale() {
        let matrix = matrix();
        let (x, b) = ([1.0, 1.0], [1e12 - 2.0, 8.0]);
        let residual = Residual::of(&Side::Plain(&matrix), &x, &b).unwrap();
        assert_eq!(residual.rest, [0.0, 1.0]);
        assert_eq!(residual.worst(), WorstRow { row: 1, error: 1.0 / 15.0 });
        let found = residual.check(&Side::Plain(&matrix), &x, 1e-6);
        assert!(matches!(found, Err(LinearAlgebraError::Inaccurate { row: 1, .. })), "{found:?}");
        let transposed = Residual::of(&Side::Transposed(&matrix), &x, &[1e12 + 3.0, 4.0]).unwrap();
        assert_eq!((&transposed.rest[..], &transposed.sizes[..]), (&[0.0, 2.0][..], &[2e12 + 6.0, 10.0][..]));
    }

    #[test]
    fn what_is_not_finite_is_the_worst() {
        let found = Residual::of(&Side::Plain(&matrix()), &[f64::NAN, 0.0], &[0.0; 2]).unwrap();
        assert_eq!(found.worst().error, f64::INFINITY);
    }

    /// [K Bᵀ; B 0] with a load that the multiplier alone carries: u is rounding, and so is every term of B u = 0.
    #[test]
    fn an_equation_of_rounding_is_judged_beside_its_neighbours() {
        let entries = [(0, 0, 2.0), (1, 1, 2.0), (0, 2, 1.0), (2, 0, 1.0), (1, 2, 1.0), (2, 1, 1.0)];
        let matrix = CsrMatrix::from_triplets(3, 3, &entries).unwrap();
        let (x, b) = ([1e-17, 1e-17, 1.0], [1.0, 1.0, 0.0]);
        let residual = Residual::of(&Side::Plain(&matrix), &x, &b).unwrap();
        assert_eq!(residual.worst(), WorstRow { row: 2, error: 1.0 });
        residual.check(&Side::Plain(&matrix), &x, 1e-15).unwrap();
        // Off by much more than rounding.
        let x = [1e-6, 1e-6, 1.0];
        let residual = Residual::of(&Side::Plain(&matrix), &x, &b).unwrap();
        assert!(residual.check(&Side::Plain(&matrix), &x, 1e-10).is_err());
    }
}
