//! Sparse LU factorisation with partial pivoting, for saddle points and whatever else has no safe Cholesky or
//! LBLᵀ factor.
//!
//! The matrix is scaled first, rows and columns, until its largest entries are about one. A velocity and a
//! pressure, or a displacement and a multiplier, then meet on one scale, and a matrix that is singular can
//! be distinguished from one that is badly scaled.

use std::time::Instant;

use faer::MatMut;
use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, sparse::FaerError};

use super::csr::CsrMatrix;
use super::error::{LinearAlgebraError, check_finite, check_size};
use super::transpose::Transpose;
use super::vector::norm;
use crate::wide_registers::cleared;

/// Rounds of scaling; each takes the square root of what is left.
const SCALINGS: usize = 4;

/// A scaled matrix whose smallest singular value is below this part of its norm is singular up to rounding.
fn singular_ratio(size: usize) -> f64 {
    1e-15 + f64::EPSILON * (size as f64).sqrt()
}

/// P R A C Q = L U, with the scalings R and C.
#[derive(Debug)]
pub struct LuFactor {
    // Compressed rows of A are compressed columns of Aᵀ: it is the transposed matrix that is factored.
    symbolic: SymbolicLu<usize>,
    factor: Lu<usize, f64>,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    smallest_ratio: f64,
    least_determined: usize,
    seconds: f64,
}

impl LuFactor {
    /// Factors of a square matrix. `earlier` is the factor of a matrix with the same pattern, whose column order is used again.
    ///
    /// # Errors
    /// If the matrix is singular (the error names an unknown that it does not determine), is not square, has
    /// an entry that is not finite, or memory is too small.
    pub fn new(matrix: &CsrMatrix, earlier: Option<&LuFactor>) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        let size = matrix.rows();
        check_size("the set of columns of a square matrix", size, matrix.columns())?;
        matrix.check_finite()?;
        let (row_scale, column_scale) = scale(matrix)?;
        let columns: Vec<usize> = matrix.column_indices().iter().map(|&column| column as usize).collect();
        let mut values = matrix.values().to_vec();
        for (range, row_scale) in matrix.row_pointers().windows(2).zip(&row_scale) {
            for position in range[0]..range[1] {
                values[position] *= row_scale * column_scale[columns[position]];
            }
        }
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, matrix.row_pointers(), None, &columns);
        let transposed = SparseColMatRef::new(pattern, &values[..]);
        let symbolic = match earlier {
            Some(earlier) => earlier.symbolic.clone(),
            None => SymbolicLu::try_new(pattern).map_err(memory)?,
        };
        let factor = cleared(|| Lu::try_new_with_symbolic(symbolic.clone(), transposed)).map_err(
            |error| match error {
                LuError::SymbolicSingular { index } => {
                    LinearAlgebraError::Singular { unknown: index.min(size.saturating_sub(1)), ratio: 0.0 }
                }
                LuError::Generic(error) => memory(error),
            },
        )?;
        let mut factored = LuFactor {
            symbolic,
            factor,
            row_scale,
            column_scale,
            smallest_ratio: 1.0,
            least_determined: 0,
            seconds: 0.0,
        };
        factored.check_regular()?;
        factored.seconds = start.elapsed().as_secs_f64();
        Ok(factored)
    }

    /// An estimate of the smallest singular value of the scaled matrix, whose largest entries are about one.
    pub fn smallest_ratio(&self) -> f64 {
        self.smallest_ratio
    }

    /// The largest entry of a solution of A x = b, or of the transposed system, in the scaled system's units: fields of different
    /// units, and parts of different stiffness, count alike.
    pub fn largest_scaled(&self, x: &[f64], transpose: Transpose) -> f64 {
        let scale = if transpose == Transpose::Yes { &self.row_scale } else { &self.column_scale };
        x.iter().zip(scale).fold(0.0, |most, (x, scale)| most.max((x / scale).abs()))
    }

    /// The unknown (row number of the matrix) that the matrix determines least.
    pub fn least_determined(&self) -> usize {
        self.least_determined
    }

    /// Seconds that the factorisation took, its symbolic analysis included.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Two steps of inverse iteration from a vector without structure find the direction that the matrix
    /// determines least.
    fn check_regular(&mut self) -> Result<(), LinearAlgebraError> {
        let size = self.row_scale.len();
        if size == 0 {
            return Ok(());
        }
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 + 0.5
        };
        let mut direction: Vec<f64> = (0..size).map(|_| next()).collect();
        let mut ratio = f64::INFINITY;
        for transpose in [Transpose::Yes, Transpose::No] {
            let before = norm(&direction);
            for value in &mut direction {
                *value /= before;
            }
            self.solve_scaled(&mut direction, transpose);
            let growth = norm(&direction);
            if !growth.is_finite() {
                // A pivot that is exactly zero.
                let unknown = direction.iter().position(|value| !value.is_finite()).unwrap_or(0);
                return Err(LinearAlgebraError::Singular { unknown, ratio: 0.0 });
            }
            ratio = ratio.min(1.0 / growth);
        }
        self.smallest_ratio = ratio;
        let largest =
            |best: usize, k: usize| if direction[k].abs() > direction[best].abs() { k } else { best };
        self.least_determined = (0..size).fold(0, largest);
        if ratio > singular_ratio(size) {
            return Ok(());
        }
        Err(LinearAlgebraError::Singular { unknown: self.least_determined, ratio })
    }

    fn solve_scaled(&self, b: &mut [f64], transpose: Transpose) {
        let size = b.len();
        let column = MatMut::from_column_major_slice_mut(b, size, 1);
        if transpose == Transpose::Yes {
            cleared(|| self.factor.solve_in_place_with_conj(Conj::No, column));
        } else {
            cleared(|| self.factor.solve_transpose_in_place_with_conj(Conj::No, column));
        }
    }

    /// A⁻¹ b or A⁻ᵀ b in place of b, without refinement.
    ///
    /// # Errors
    /// If the size is wrong or an entry of b or of the solution is not finite.
    pub fn solve_in_place(&self, b: &mut [f64], transpose: Transpose) -> Result<(), LinearAlgebraError> {
        check_size("the right-hand side", self.row_scale.len(), b.len())?;
        check_finite("the right-hand side", b)?;
        let (first, last) = match transpose {
            Transpose::No => (&self.row_scale, &self.column_scale),
            Transpose::Yes => (&self.column_scale, &self.row_scale),
        };
        for (value, scale) in b.iter_mut().zip(first) {
            *value *= scale;
        }
        self.solve_scaled(b, transpose);
        for (value, scale) in b.iter_mut().zip(last) {
            *value *= scale;
        }
        check_finite("the solution", b)
    }
}

fn memory(_: FaerError) -> LinearAlgebraError {
    LinearAlgebraError::OutOfMemory { what: "the factor" }
}

/// Scaled diagonals below this say that a matrix with a zero block is dominated by its coupling blocks.
const WEAK_DIAGONAL: f64 = 1e-6;

/// Factors of rows and columns, powers of two, so that scaling rounds nothing.
pub(super) fn scale(matrix: &CsrMatrix) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
    let size = matrix.rows();
    let (rows, columns) = scale_from(matrix, vec![1.0; size])?;
    // In a saddle point [K Bᵀ; B 0] whose unknowns have odd units B may hide K: all rows have largest entries of about one
    // before anything was scaled. There K's own diagonal gives the unit of its unknowns, and B then that of the multipliers.
    let diagonal: Vec<f64> = matrix.diagonal_above_rounding().iter().map(|value| value.abs()).collect();
    let zero_block = diagonal.contains(&0.0);
    let of_row = |row: usize| diagonal[row] * rows[row] * columns[row];
    let largest = (0..size).map(of_row).fold(0.0_f64, f64::max);
    if !zero_block || largest == 0.0 || largest >= WEAK_DIAGONAL {
        return Ok((rows, columns));
    }
    let half = |value: f64| (-0.5 * value.log2()).round().exp2();
    let mut first: Vec<f64> =
        diagonal.iter().map(|value| if *value > 0.0 { half(*value) } else { 1.0 }).collect();
    for row in (0..size).filter(|row| diagonal[*row] == 0.0) {
        let (indices, values) = matrix.row(row);
        let terms = indices.iter().zip(values);
        let largest =
            terms.map(|(column, value)| (value * first[*column as usize]).abs()).fold(0.0, f64::max);
        if largest > 0.0 {
            first[row] = (-largest.log2()).round().exp2();
        }
    }
    scale_from(matrix, first)
}

/// Rounds of scaling from given factors of rows and columns.
fn scale_from(matrix: &CsrMatrix, first: Vec<f64>) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
    let size = matrix.rows();
    let (mut rows, mut columns) = (first.clone(), first);
    for _ in 0..SCALINGS {
        let (mut in_rows, mut in_columns) = (vec![0.0_f64; size], vec![0.0_f64; size]);
        for row in 0..size {
            let (indices, values) = matrix.row(row);
            for (&column, value) in indices.iter().zip(values) {
                let entry = (rows[row] * value * columns[column as usize]).abs();
                in_rows[row] = in_rows[row].max(entry);
                in_columns[column as usize] = in_columns[column as usize].max(entry);
            }
        }
        let mut is_balanced = true;
        for (factors, largest) in [(&mut rows, &in_rows), (&mut columns, &in_columns)] {
            for (unknown, (factor, largest)) in factors.iter_mut().zip(largest).enumerate() {
                if *largest == 0.0 {
                    return Err(LinearAlgebraError::Singular { unknown, ratio: 0.0 });
                }
                let change = (-0.5 * largest.log2()).round().exp2();
                is_balanced &= change == 1.0;
                *factor *= change;
            }
        }
        if is_balanced {
            break;
        }
    }
    Ok((rows, columns))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A saddle point with a zero block: a chain with `n` unknowns, held by `m` multipliers of another scale.
    fn saddle(n: usize, m: usize, scale: f64) -> CsrMatrix {
        let mut triplets = Vec::new();
        for i in 0..n {
            triplets.push((i, i, 2.0 * scale));
            if i > 0 {
                triplets.extend([(i, i - 1, -scale), (i - 1, i, -scale)]);
            }
        }
        for k in 0..m {
            let i = k * n / m;
            triplets.extend([(i, n + k, 1.0), (n + k, i, 1.0)]);
        }
        CsrMatrix::from_triplets(n + m, n + m, &triplets).unwrap()
    }

    #[test]
    fn a_saddle_point_of_two_scales_is_solved_to_rounding() {
        for scale in [1.0, 1e9, 1e-9, 1e-24] {
            let matrix = saddle(400, 40, scale);
            let factor = LuFactor::new(&matrix, None).unwrap();
            let again = LuFactor::new(&matrix, Some(&factor)).unwrap();
            let exact: Vec<f64> = (0..440).map(|i| (f64::from(i) * 0.7).sin()).collect();
            for transpose in [Transpose::No, Transpose::Yes] {
                let mut x = matrix.multiply(&exact).unwrap();
                again.solve_in_place(&mut x, transpose).unwrap();
                // The forward error of the multipliers is of the size of the stiffness.
                let largest = x.iter().zip(&exact).take(400).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(largest < 1e-9, "{scale}: {largest}");
            }
        }
    }

    #[test]
    fn an_unsymmetric_matrix_and_its_transpose() {
        let matrix =
            CsrMatrix::from_triplets(3, 3, &[(0, 1, 2.0), (1, 0, 4.0), (1, 2, 1.0), (2, 2, 8.0)]).unwrap();
        let factor = LuFactor::new(&matrix, None).unwrap();
        let mut x = vec![2.0, 5.0, 8.0];
        factor.solve_in_place(&mut x, Transpose::No).unwrap();
        assert_eq!(x, [1.0, 1.0, 1.0]);
        let mut x = matrix.multiply_transposed(&[3.0, -1.0, 2.0]).unwrap();
        factor.solve_in_place(&mut x, Transpose::Yes).unwrap();
        assert_eq!(x, [3.0, -1.0, 2.0]);
    }

    #[test]
    fn what_is_not_determined_is_named() {
        // Two multipliers for one unknown.
        let mut triplets = vec![(0, 0, 1.0), (1, 1, 1.0)];
        for k in [2, 3] {
            triplets.extend([(0, k, 1.0), (k, 0, 1.0)]);
        }
        let matrix = CsrMatrix::from_triplets(4, 4, &triplets).unwrap();
        let error = LuFactor::new(&matrix, None).unwrap_err();
        assert!(matches!(error, LinearAlgebraError::Singular { unknown: 2 | 3, .. }), "{error}");
        // A row that is empty.
        let matrix = CsrMatrix::from_triplets(2, 2, &[(0, 0, 1.0), (0, 1, 1.0)]).unwrap();
        assert!(matches!(
            LuFactor::new(&matrix, None),
            Err(LinearAlgebraError::Singular { unknown: 1, ratio: 0.0 })
        ));
        // The chain without an end that holds it: rounding hides the zero pivot.
        let mut triplets = Vec::new();
        for i in 0..300 {
            let j = (i + 1) % 300;
            triplets.extend([(i, i, 0.1), (j, j, 0.1), (i, j, -0.1), (j, i, -0.1)]);
        }
        let matrix = CsrMatrix::from_triplets(300, 300, &triplets).unwrap();
        assert!(matches!(LuFactor::new(&matrix, None), Err(LinearAlgebraError::Singular { .. })));
    }
}
