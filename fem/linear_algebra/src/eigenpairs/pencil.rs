//! Two symmetric matrices, where one measures lengths, and the factor of their difference at a shift.

use std::sync::Arc;

use super::EigenError;
use crate::analysis::Analysis;
use crate::cholesky::SymmetricFactor;
use crate::csr::CsrMatrix;
use crate::error::{LinearAlgebraError, check_size};
use crate::ordering::Ordering;
use crate::spectrum::irregular_from;
use crate::vector::{dot, norm};

/// The matrix of a pencil that is positive, in whose inner product its eigenvectors are orthogonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Positive {
    /// A, as the stiffness in A x = λ B x of buckling, where B is minus the geometric stiffness. It is positive definite.
    First,
    /// B, as the mass of a vibration. It may be semidefinite.
    Second,
}

/// Two symmetric matrices A and B, as far as eigenpairs ask for them. Several processes may have a part of them each, with some entries of
/// every vector: all make the same calls, and get the same numbers.
#[doc(hidden)]
pub trait Pencil {
    /// A − σ B, ready to solve with.
    type Factor;
    type Error: From<EigenError>;

    fn positive(&self) -> Positive;

    /// The number of entries that vectors have here.
    fn size(&self) -> usize;

    /// A x.
    fn first(&self, x: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// B x.
    fn second(&self, x: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// |A| |x| + |λ| |B| |x|.
    fn amounts(&self, value: f64, x: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// The products of some vectors with one.
    fn dots(&self, vectors: &[Vec<f64>], y: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// The Euclidean norms of two vectors.
    fn norms(&self, vectors: [&[f64]; 2]) -> Result<[f64; 2], Self::Error>;

    /// A vector without a pattern.
    fn irregular(&self, seed: u64) -> Result<Vec<f64>, Self::Error>;

    /// A − σ B.
    fn factor(&self, shift: f64) -> Result<Self::Factor, Self::Error>;

    /// The solution x of (A − σ B) x = b.
    fn solve(&self, factor: &Self::Factor, b: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// The number of negative eigenvalues of A − σ B.
    fn negative(&self, factor: &Self::Factor) -> Result<usize, Self::Error>;

    /// P x with the positive matrix P.
    fn measured(&self, x: &[f64]) -> Result<Vec<f64>, Self::Error> {
        match self.positive() {
            Positive::First => self.first(x),
            Positive::Second => self.second(x),
        }
    }

    /// xᵀ P y.
    fn product(&self, x: &[f64], y: &[f64]) -> Result<f64, Self::Error> {
        Ok(self.dots(&[x.to_vec()], &self.measured(y)?)?[0])
    }

    /// The length of x in the positive matrix.
    fn length(&self, x: &[f64]) -> Result<f64, Self::Error> {
        self.length_of(x, &self.measured(x)?)
    }

    /// √(xᵀ P x) of P x that is known.
    fn length_of(&self, x: &[f64], measured: &[f64]) -> Result<f64, Self::Error> {
        let square = self.dots(&[x.to_vec()], measured)?[0];
        if square >= 0.0 {
            return Ok(square.sqrt());
        }
        // Rounding makes zeros slightly negative.
        let amounts = |vector: &[f64]| vector.iter().map(|value| value.abs()).collect::<Vec<_>>();
        let rounding = 1e-13 * self.dots(&[amounts(x)], &amounts(measured))?[0];
        if square < -rounding || square.is_nan() {
            let which = match self.positive() {
                Positive::First => "first",
                Positive::Second => "second",
            };
            return Err(EigenError::NotPositive { which, square }.into());
        }
        Ok(0.0)
    }
}

/// A x = λ B x with symmetric matrices, on one pattern and with one analysis.
#[derive(Debug)]
pub struct SymmetricPencil {
    first: CsrMatrix,
    second: CsrMatrix,
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
            check_symmetric(which, matrix)?;
        }
        let (first, second) = on_one_pattern(first, second)?;
        let (analysis, completed) = Analysis::of_symmetric(&first, &Ordering::default())?;
        let (first, second) = match completed {
            Some(first) => (first, second.symmetric_part()?),
            None => (first, second),
        };
        Ok(SymmetricPencil { first, second, positive, analysis: Arc::new(analysis) })
    }
}

/// A − σ B with its factor.
#[derive(Debug)]
#[doc(hidden)]
pub struct FactoredPencil {
    matrix: CsrMatrix,
    factor: SymmetricFactor,
}

impl Pencil for SymmetricPencil {
    type Factor = FactoredPencil;
    type Error = EigenError;

    fn positive(&self) -> Positive {
        self.positive
    }

    fn size(&self) -> usize {
        self.first.rows()
    }

    fn first(&self, x: &[f64]) -> Result<Vec<f64>, EigenError> {
        Ok(self.first.multiply(x)?)
    }

    fn second(&self, x: &[f64]) -> Result<Vec<f64>, EigenError> {
        Ok(self.second.multiply(x)?)
    }

    fn amounts(&self, value: f64, x: &[f64]) -> Result<Vec<f64>, EigenError> {
        Ok(amounts_of([&self.first, &self.second], value, x))
    }

    fn dots(&self, vectors: &[Vec<f64>], y: &[f64]) -> Result<Vec<f64>, EigenError> {
        Ok(vectors.iter().map(|vector| dot(vector, y)).collect())
    }

    fn norms(&self, vectors: [&[f64]; 2]) -> Result<[f64; 2], EigenError> {
        Ok(vectors.map(norm))
    }

    fn irregular(&self, seed: u64) -> Result<Vec<f64>, EigenError> {
        Ok(irregular_from(seed, self.first.rows()).collect())
    }

    fn factor(&self, shift: f64) -> Result<FactoredPencil, EigenError> {
        let mut matrix = self.first.clone();
        matrix.add_scaled(-shift, &self.second)?;
        let factor = SymmetricFactor::cholesky_or_indefinite(&self.analysis, &matrix, vec![]);
        let factor = factor.map_err(|source| match source {
            source @ LinearAlgebraError::Singular { .. } => EigenError::ShiftIsEigenvalue { shift, source },
            source => source.into(),
        })?;
        Ok(FactoredPencil { matrix, factor })
    }

    fn solve(
        &self,
        FactoredPencil { matrix, factor }: &FactoredPencil,
        b: &[f64],
    ) -> Result<Vec<f64>, EigenError> {
        Ok(factor.solve_refined(matrix, b, REFINEMENTS)?.solution)
    }

    fn negative(&self, known: &FactoredPencil) -> Result<usize, EigenError> {
        // A factor that solves its system is one of a matrix nearby.
        let ones = known.matrix.multiply(&vec![1.0; self.first.rows()])?;
        self.solve(known, &ones)?;
        Ok(known.factor.negative_eigenvalues())
    }
}

/// An error for a matrix of a pencil that is not symmetric, or not finite.
///
/// # Errors
/// [`EigenError::NotSymmetric`], [`LinearAlgebraError::EntryNotFinite`].
#[doc(hidden)]
pub fn check_symmetric(which: &'static str, matrix: &CsrMatrix) -> Result<(), EigenError> {
    matrix.check_finite()?;
    let asymmetry = matrix.asymmetry()?;
    if asymmetry > SYMMETRIC { Err(EigenError::NotSymmetric { which, asymmetry }) } else { Ok(()) }
}

/// |A| |x| + |λ| |B| |x| of two matrices.
#[doc(hidden)]
pub fn amounts_of(matrices: [&CsrMatrix; 2], value: f64, x: &[f64]) -> Vec<f64> {
    let sum = |matrix: &CsrMatrix, row: usize| -> f64 {
        let (columns, entries) = matrix.row(row);
        columns.iter().zip(entries).map(|(column, entry)| (entry * x[*column as usize]).abs()).sum()
    };
    (0..x.len()).map(|row| sum(matrices[0], row) + value.abs() * sum(matrices[1], row)).collect()
}

/// A − σ B with its shift.
pub(super) struct Shifted<P: Pencil> {
    pub shift: f64,
    factor: P::Factor,
}

impl<P: Pencil> Shifted<P> {
    pub fn of(pencil: &P, shift: f64) -> Result<Self, P::Error> {
        Ok(Shifted { shift, factor: pencil.factor(shift)? })
    }

    /// (A − σ B)⁻¹ B x.
    ///
    /// # Errors
    /// A vector of another size, or a solution that is not accurate.
    pub fn apply(&self, pencil: &P, x: &[f64]) -> Result<Vec<f64>, P::Error> {
        pencil.solve(&self.factor, &pencil.second(x)?)
    }

    /// The number of eigenvalues up to an end above, by the signs of pivots.
    ///
    /// # Errors
    /// A matrix at the end that has no factor.
    pub fn count_up_to(&self, pencil: &P, end: f64) -> Result<usize, P::Error> {
        let signed = |shifted: &Self| -> Result<i64, P::Error> {
            let negative = pencil.negative(&shifted.factor)? as i64;
            Ok(match pencil.positive() {
                Positive::Second => negative,
                // A − τ B has as many negative eigenvalues as there are λ between 0 and τ.
                Positive::First if shifted.shift < 0.0 => -negative,
                Positive::First => negative,
            })
        };
        Ok(usize::try_from(signed(&Shifted::of(pencil, end)?)? - signed(self)?).unwrap_or(0))
    }
}

/// Both matrices with all positions of either.
///
/// # Errors
/// Too many entries.
#[doc(hidden)]
pub fn on_one_pattern(
    one: &CsrMatrix,
    other: &CsrMatrix,
) -> Result<(CsrMatrix, CsrMatrix), LinearAlgebraError> {
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
