//! Two symmetric matrices, where one measures lengths, and the factor of their difference at a shift.

use std::sync::Arc;

use super::EigenError;
use crate::analysis::Analysis;
use crate::cholesky::SymmetricFactor;
use crate::csr::CsrMatrix;
use crate::error::{LinearAlgebraError, check_size};
use crate::ordering::Ordering;
use crate::vector::dot;

/// The matrix of a pencil that is positive, in whose inner product its eigenvectors are orthogonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Positive {
    /// A, as the stiffness in A x = λ B x of buckling, where B is minus the geometric stiffness. It is positive definite.
    First,
    /// B, as the mass of a vibration. It may be semidefinite.
    Second,
}

/// A x = λ B x with symmetric matrices, on one pattern and with one analysis.
#[derive(Debug)]
pub struct SymmetricPencil {
    pub(super) first: CsrMatrix,
    pub(super) second: CsrMatrix,
    positive: Positive,
    analysis: Arc<Analysis>,
}

/// Relative difference of an entry and its partner that rounding may leave.
const SYMMETRIC: f64 = 1e-9;
/// Steps of refinement of a solution.
const REFINEMENTS: usize = 3;

impl SymmetricPencil {
    /// The pencil of A and B.
    ///
    /// # Errors
    /// [`EigenError::NotSymmetric`]; sizes that differ, entries that are not finite, a factor too large to be counted.
    pub fn new(first: &CsrMatrix, second: &CsrMatrix, positive: Positive) -> Result<Self, EigenError> {
        check_size("the second matrix of an eigenproblem", first.rows(), second.rows())?;
        for (which, matrix) in [("first", first), ("second", second)] {
            matrix.check_finite()?;
            let asymmetry = matrix.asymmetry()?;
            if asymmetry > SYMMETRIC {
                return Err(EigenError::NotSymmetric { which, asymmetry });
            }
        }
        let (first, second) = on_one_pattern(first, second)?;
        let (analysis, completed) = Analysis::of_symmetric(&first, &Ordering::default())?;
        let (first, second) = match completed {
            Some(first) => (first, second.symmetric_part()?),
            None => (first, second),
        };
        Ok(SymmetricPencil { first, second, positive, analysis: Arc::new(analysis) })
    }

    /// The number of unknowns.
    pub fn size(&self) -> usize {
        self.first.rows()
    }

    fn measure(&self) -> (&'static str, &CsrMatrix) {
        match self.positive {
            Positive::First => ("first", &self.first),
            Positive::Second => ("second", &self.second),
        }
    }

    /// P x with the positive matrix P.
    pub(super) fn measured(&self, x: &[f64]) -> Result<Vec<f64>, EigenError> {
        Ok(self.measure().1.multiply(x)?)
    }

    /// xᵀ P y.
    pub(super) fn product(&self, x: &[f64], y: &[f64]) -> Result<f64, EigenError> {
        Ok(dot(x, &self.measured(y)?))
    }

    /// The length of x in the positive matrix.
    pub(super) fn length(&self, x: &[f64]) -> Result<f64, EigenError> {
        self.length_of(x, &self.measured(x)?)
    }

    /// √(xᵀ P x) of P x that is known.
    pub(super) fn length_of(&self, x: &[f64], measured: &[f64]) -> Result<f64, EigenError> {
        let square = dot(x, measured);
        // Rounding makes zeros slightly negative.
        let rounding = 1e-13 * x.iter().zip(measured).map(|(x, y)| (x * y).abs()).sum::<f64>();
        if square < -rounding || square.is_nan() {
            return Err(EigenError::NotPositive { which: self.measure().0, square });
        }
        Ok(square.max(0.0).sqrt())
    }

    /// A − σ B with its factor.
    pub(super) fn shifted(&self, shift: f64) -> Result<Shifted, EigenError> {
        let mut matrix = self.first.clone();
        matrix.add_scaled(-shift, &self.second)?;
        let factor = SymmetricFactor::cholesky_or_indefinite(&self.analysis, &matrix, vec![]);
        let factor = factor.map_err(|source| match source {
            source @ LinearAlgebraError::Singular { .. } => EigenError::ShiftIsEigenvalue { shift, source },
            source => source.into(),
        })?;
        Ok(Shifted { shift, matrix, factor })
    }

    /// The number of eigenvalues between a shift and an end above it, by the signs of pivots.
    pub(super) fn count_between(&self, from: &Shifted, end: f64) -> Result<usize, EigenError> {
        let to = self.shifted(end)?;
        // A factor that solves its system is one of a matrix nearby.
        let ones = to.matrix.multiply(&vec![1.0; self.size()])?;
        to.factor.solve_refined(&to.matrix, &ones, REFINEMENTS)?;
        let signed = |shifted: &Shifted| {
            let negative = shifted.factor.negative_eigenvalues() as i64;
            match self.positive {
                Positive::Second => negative,
                // A − τ B has as many negative eigenvalues as there are λ between 0 and τ.
                Positive::First if shifted.shift < 0.0 => -negative,
                Positive::First => negative,
            }
        };
        Ok(usize::try_from(signed(&to) - signed(from)).unwrap_or(0))
    }
}

/// A − σ B.
#[derive(Debug)]
pub(super) struct Shifted {
    pub shift: f64,
    matrix: CsrMatrix,
    factor: SymmetricFactor,
}

impl Shifted {
    /// (A − σ B)⁻¹ B x.
    ///
    /// # Errors
    /// A vector of another size, or a solution that is not accurate.
    pub fn apply(&self, pencil: &SymmetricPencil, x: &[f64]) -> Result<Vec<f64>, EigenError> {
        let load = pencil.second.multiply(x)?;
        Ok(self.factor.solve_refined(&self.matrix, &load, REFINEMENTS)?.solution)
    }
}

/// Both matrices with all positions of either.
fn on_one_pattern(one: &CsrMatrix, other: &CsrMatrix) -> Result<(CsrMatrix, CsrMatrix), LinearAlgebraError> {
    if one.same_pattern(other) {
        return Ok((one.clone(), CsrMatrix::from_pattern(one.pattern(), other.values().to_vec())?));
    }
    let all = |matrix: &CsrMatrix, factor: f64| {
        let of_row = |row: usize| {
            let (columns, values) = matrix.row(row);
            let entries =
                columns.iter().zip(values).map(|(column, value)| (row, *column as usize, factor * value));
            entries.collect::<Vec<_>>()
        };
        (0..matrix.rows()).flat_map(of_row).collect::<Vec<_>>()
    };
    let together = |factors: [f64; 2]| {
        let triplets = [all(one, factors[0]), all(other, factors[1])].concat();
        CsrMatrix::from_triplets(one.rows(), one.columns(), &triplets)
    };
    Ok((together([1.0, 0.0])?, together([0.0, 1.0])?))
}
