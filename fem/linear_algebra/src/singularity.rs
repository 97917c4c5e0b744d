//! Singular and ill-conditioned matrices told from others by a factor that was computed all the same: rounding hides a
//! zero pivot.

use super::csr::CsrMatrix;
use super::error::LinearAlgebraError;
use super::lu::scale;
use super::spectrum::irregular;

/// A vector y whose entries |(A y)_i| are all below this part of the largest Σ|a_ij||y_j|, with the largest entries scaled to one,
/// is as good as a null vector: rounding of the entries moves a solution along it by a part in 10⁴. Floating bodies left
/// 1e-16 to 1e-13; a chain of 10⁶ springs, whose condition is 10¹², leaves 1e-9.
const NOTHING: f64 = 1e-12;

/// Below this part y is a null vector up to the rounding of A y.
pub fn singular_ratio(size: usize) -> f64 {
    1e-14 + 2.0 * f64::EPSILON * (size as f64).sqrt()
}

/// Check of a matrix by a solve with an irregular right-hand side, which every null vector has a part in. A solution that is
/// a null vector proves that the matrix is singular, however good or bad the factor is. Each row counts in its own unit.
///
/// # Errors
/// [`LinearAlgebraError::Singular`] with the unknown that the null vector moves most,
/// [`LinearAlgebraError::IllConditioned`] if it is nearly one, or as the solve.
pub fn check_regular(
    matrix: &CsrMatrix,
    solve: impl FnOnce(&mut [f64]) -> Result<(), LinearAlgebraError>,
) -> Result<(), LinearAlgebraError> {
    // The diagonal says nothing of the scale of a row whose largest entries are elsewhere, as in a saddle point.
    let (of_rows, of_columns) = scale(matrix)?;
    let mut y: Vec<f64> =
        irregular(matrix.rows()).zip(&of_rows).map(|(value, scale)| value / scale).collect();
    solve(&mut y)?;
    let (mut product, mut terms) = (0.0_f64, 0.0_f64);
    for (row, scale) in of_rows.iter().enumerate() {
        let (columns, values) = matrix.row(row);
        let (mut sum, mut terms_of_row) = (0.0, 0.0_f64);
        for (&column, value) in columns.iter().zip(values) {
            let term = value * y[column as usize];
            sum += term;
            terms_of_row += term.abs();
        }
        (product, terms) = (product.max(sum.abs() * scale), terms.max(terms_of_row * scale));
    }
    if terms == 0.0 || product > NOTHING * terms {
        return Ok(());
    }
    let motion = |unknown: &usize| y[*unknown].abs() / of_columns[*unknown];
    let most = (0..y.len()).max_by(|a, b| motion(a).total_cmp(&motion(b)));
    let (unknown, ratio) = (most.unwrap_or(0), product / terms);
    if ratio <= singular_ratio(matrix.rows()) {
        return Err(LinearAlgebraError::Singular { unknown, ratio });
    }
    Err(LinearAlgebraError::IllConditioned { unknown, condition: 1.0 / ratio })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LuFactor;
    use crate::Transpose;

    /// Springs in a ring of n masses; the first is held by a spring of its own.
    fn ring(n: usize, held: f64) -> CsrMatrix {
        let mut triplets = vec![(0, 0, held)];
        for i in 0..n {
            let (j, stiffness) = ((i + 1) % n, 1.0 / (3.0 + i as f64));
            triplets.extend([(i, i, stiffness), (j, j, stiffness), (i, j, -stiffness), (j, i, -stiffness)]);
        }
        CsrMatrix::from_triplets(n, n, &triplets).unwrap()
    }

    #[test]
    fn a_ring_that_floats_up_to_rounding_is_told_from_one_that_is_held() {
        for (held, regular) in [(1.0, true), (1e-7, true), (1e-15, false)] {
            let (matrix, exact) = (ring(60, held), LuFactor::new(&ring(60, held.max(1e-13)), None).unwrap());
            let found = check_regular(&matrix, |y| exact.solve_in_place(y, Transpose::No));
            assert_eq!(found.is_ok(), regular || held > 1e-13, "{held}: {found:?}");
        }
    }
}
