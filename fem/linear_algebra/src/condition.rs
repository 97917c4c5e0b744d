//! Estimates of ‖A⁻¹‖₁ and of the condition number by a few solves (Hager 1984; Higham 1988).

use super::csr::CsrMatrix;
use super::error::LinearAlgebraError;
use super::vector::dot;

/// A lower bound of the condition number, nearly always within a factor of three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionEstimate {
    /// ‖A‖₁ ‖A⁻¹‖₁. A solution loses about as many digits as this number has.
    pub condition: f64,
    /// ‖A⁻¹‖₁ \[1 / unit of A\].
    pub inverse_norm: f64,
    /// Solves that it took.
    pub solves: usize,
}

/// Most steps of the search for a column of A⁻¹ of large norm; it nearly always ends after two.
const STEPS: usize = 5;

/// Estimate of the condition of a matrix in the 1-norm. `solve` replaces b by A⁻¹ b, `solve_transposed` by A⁻ᵀ b.
///
/// # Errors
/// As the solves.
pub fn condition_estimate<E: From<LinearAlgebraError>>(
    matrix: &CsrMatrix,
    mut solve: impl FnMut(&mut Vec<f64>) -> Result<(), E>,
    mut solve_transposed: impl FnMut(&mut Vec<f64>) -> Result<(), E>,
) -> Result<ConditionEstimate, E> {
    let size = matrix.rows();
    if size == 0 {
        return Ok(ConditionEstimate { condition: 1.0, inverse_norm: 0.0, solves: 0 });
    }
    let one_norm = |x: &[f64]| x.iter().map(|value| value.abs()).sum::<f64>();
    let mut x = vec![1.0 / size as f64; size];
    let mut solves = 0;
    let mut inverse_norm = 0.0_f64;
    let mut earlier_column = None;
    for _ in 0..STEPS {
        let start = x.clone();
        solve(&mut x)?;
        solves += 1;
        let found = one_norm(&x);
        if found <= inverse_norm {
            break;
        }
        inverse_norm = found;
        let mut slope: Vec<f64> = x.iter().map(|value| 1.0_f64.copysign(*value)).collect();
        solve_transposed(&mut slope)?;
        solves += 1;
        let steepest = (0..size).max_by(|&a, &b| slope[a].abs().total_cmp(&slope[b].abs())).unwrap_or(0);
        // At a maximum no column promises more than the vector itself.
        if slope[steepest].abs() <= dot(&slope, &start) || earlier_column == Some(steepest) {
            break;
        }
        earlier_column = Some(steepest);
        x.fill(0.0);
        x[steepest] = 1.0;
    }
    // A vector of growing entries with alternating signs finds what cancels in the others.
    let mut x: Vec<f64> = (0..size)
        .map(|i| (1.0 + i as f64 / (size.max(2) - 1) as f64) * if i % 2 == 0 { 1.0 } else { -1.0 })
        .collect();
    solve(&mut x)?;
    solves += 1;
    inverse_norm = inverse_norm.max(2.0 * one_norm(&x) / (3.0 * size as f64));
    Ok(ConditionEstimate { condition: matrix.column_sum_norm() * inverse_norm, inverse_norm, solves })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LuFactor, Transpose};

    fn estimate(matrix: &CsrMatrix) -> ConditionEstimate {
        let factor = LuFactor::new(matrix, None).unwrap();
        let solve = |x: &mut Vec<f64>| factor.solve_in_place(x, Transpose::No);
        condition_estimate(matrix, solve, |x: &mut Vec<f64>| factor.solve_in_place(x, Transpose::Yes))
            .unwrap()
    }

    /// ‖A⁻¹‖₁ by solving for every column.
    fn exact(matrix: &CsrMatrix) -> f64 {
        let factor = LuFactor::new(matrix, None).unwrap();
        let column = |k: usize| {
            let mut x = vec![0.0; matrix.rows()];
            x[k] = 1.0;
            factor.solve_in_place(&mut x, Transpose::No).unwrap();
            x.iter().map(|value| value.abs()).sum::<f64>()
        };
        (0..matrix.rows()).map(column).fold(0.0, f64::max)
    }

    #[test]
    fn the_chain_has_a_known_condition() {
        // The inverse of tridiag(−1, 2, −1) has the column sums k (n + 1 − k) / 2, the largest (n + 1)² / 8.
        for n in [9_usize, 99] {
            let mut triplets = vec![(0, 0, 2.0)];
            for i in 1..n {
                triplets.extend([(i, i, 2.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
            }
            let matrix = CsrMatrix::from_triplets(n, n, &triplets).unwrap();
            let found = estimate(&matrix);
            assert!((found.inverse_norm - ((n + 1) * (n + 1)) as f64 / 8.0).abs() < 1e-8, "{found:?}");
            assert!((found.condition - ((n + 1) * (n + 1)) as f64 / 2.0).abs() < 1e-7);
        }
    }

    #[test]
    fn unsymmetric_matrices_are_estimated_from_below_within_a_factor_of_three() {
        for seed in 1..20_usize {
            let entry = |i: usize, j: usize| ((seed * (i * i + 7 * j + 3 * i * j) + 5 * j) % 19) as f64 - 9.0;
            let triplets: Vec<_> = (0..12)
                .flat_map(|i| (0..12).map(move |j| (i, j)))
                .map(|(i, j)| (i, j, entry(i, j) + if i == j { 0.5 * seed as f64 } else { 0.0 }))
                .collect();
            let matrix = CsrMatrix::from_triplets(12, 12, &triplets).unwrap();
            if LuFactor::new(&matrix, None).is_err() {
                continue;
            }
            let (found, exact) = (estimate(&matrix).inverse_norm, exact(&matrix));
            assert!(found <= exact * (1.0 + 1e-8) && 3.0 * found >= exact, "{seed}: {found} of {exact}");
        }
    }
}
