//! The largest eigenvalue of S v = λ A v for two positive semidefinite matrices of one cell, S of low rank.

use forms_fem::linear_algebra::SymmetricEigen;

/// Pivots below this part of the largest diagonal entry belong to the kernel: rigid motions, and what no stress sees.
const KERNEL: f64 = 1e-12;

/// A = L Lᵀ up to rounding: the columns of L, and the row that each of them was made from.
struct Factor {
    columns: Vec<Vec<f64>>,
    pivots: Vec<usize>,
}

/// The Cholesky factor of a positive semidefinite matrix with its largest pivots first, as far as its rank. None if an entry is not
/// finite, or a pivot is negative beyond rounding.
fn factor(size: usize, matrix: &[f64]) -> Option<Factor> {
    let mut diagonal: Vec<f64> = (0..size).map(|k| matrix[k * size + k]).collect();
    let top = diagonal.iter().copied().fold(0.0, f64::max);
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let (mut columns, mut pivots): (Vec<Vec<f64>>, Vec<usize>) = (vec![], vec![]);
    while pivots.len() < size {
        let left = (0..size).filter(|row| !pivots.contains(row));
        let Some(pivot) = left.max_by(|a, b| diagonal[*a].total_cmp(&diagonal[*b])) else { break };
        if diagonal[pivot] <= KERNEL * top {
            break;
        }
        let root = diagonal[pivot].sqrt();
        let mut column = matrix[pivot * size..(pivot + 1) * size].to_vec();
        for earlier in &columns {
            let factor = earlier[pivot];
            column.iter_mut().zip(earlier).for_each(|(entry, earlier)| *entry -= factor * earlier);
        }
        column.iter_mut().for_each(|entry| *entry /= root);
        diagonal.iter_mut().zip(&column).for_each(|(diagonal, entry)| *diagonal -= entry * entry);
        columns.push(column);
        pivots.push(pivot);
    }
    let negative = (0..size).any(|row| !pivots.contains(&row) && diagonal[row] < -1e3 * KERNEL * top);
    (!negative).then_some(Factor { columns, pivots })
}

/// The largest λ of S v = λ A v over the complement of A's kernel, on which S vanishes too; infinite where it cannot be found, as of an A that
/// is not positive semidefinite. Both matrices have `size` rows, and are given row by row.
///
/// With S = B Bᵀ it is the largest eigenvalue of Bᵀ A⁺ B, a matrix as large as the rank of S: the number of a facet's stresses and points.
pub fn largest_eigenvalue(size: usize, s: &[f64], a: &[f64]) -> f64 {
    let (Some(of_s), Some(of_a)) = (factor(size, s), factor(size, a)) else { return f64::INFINITY };
    // L⁻¹B on A's pivots, column by column: b lies in the range of A, so that its other rows follow.
    let reduced: Vec<Vec<f64>> = of_s
        .columns
        .into_iter()
        .map(|mut rest| {
            let mut reduced = vec![];
            for (column, &pivot) in of_a.columns.iter().zip(&of_a.pivots) {
                let value = rest[pivot] / column[pivot];
                rest.iter_mut().zip(column).for_each(|(rest, entry)| *rest -= value * entry);
                reduced.push(value);
            }
            reduced
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let products: Vec<f64> = reduced.iter().flat_map(|a| reduced.iter().map(|b| dot(a, b))).collect();
    let found = SymmetricEigen::of(reduced.len(), &products);
    found.map_or(f64::INFINITY, |found| found.values.last().copied().unwrap_or(0.0))
}
