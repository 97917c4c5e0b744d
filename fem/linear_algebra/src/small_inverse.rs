//! Inverses of small dense matrices, with pivots that are judged by the scales of their unknowns.

/// A pivot below this part of its scale is none.
const VANISHING: f64 = 1e-10;

/// The inverse of a matrix that is stored row by row, by Gauss and Jordan's method on its scaled rows and columns, with partial
/// pivoting; none if a pivot vanishes or is not finite.
pub fn small_inverse(mut matrix: Vec<f64>, scales: &[f64]) -> Option<Vec<f64>> {
    let size = scales.len();
    // Powers of two round nothing.
    let factors: Vec<f64> = scales.iter().map(|scale| (-0.5 * scale.log2()).round().exp2()).collect();
    if factors.iter().any(|factor| !factor.is_finite() || *factor == 0.0) {
        return None;
    }
    let mut inverse = vec![0.0; size * size];
    for i in 0..size {
        inverse[i * size + i] = 1.0;
        for j in 0..size {
            matrix[i * size + j] *= factors[i] * factors[j];
        }
    }
    for k in 0..size {
        let size_at = |row: &usize| matrix[row * size + k].abs();
        let pivot_row = (k..size).max_by(|a, b| size_at(a).total_cmp(&size_at(b)))?;
        let pivot = matrix[pivot_row * size + k];
        if !(pivot.abs() > VANISHING && pivot.is_finite()) {
            return None;
        }
        for values in [&mut matrix, &mut inverse] {
            for j in 0..size {
                values.swap(k * size + j, pivot_row * size + j);
                values[k * size + j] /= pivot;
            }
        }
        for row in (0..size).filter(|row| *row != k) {
            let factor = matrix[row * size + k];
            if factor == 0.0 {
                continue;
            }
            for values in [&mut matrix, &mut inverse] {
                for j in 0..size {
                    values[row * size + j] -= factor * values[k * size + j];
                }
            }
        }
    }
    for i in 0..size {
        for j in 0..size {
            inverse[i * size + j] *= factors[i] * factors[j];
        }
    }
    Some(inverse)
}
