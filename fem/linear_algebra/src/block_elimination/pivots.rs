//! The scales of the groups' unknowns, by which pivots of their blocks are judged.

use super::groups::NONE;
use crate::csr::CsrMatrix;

/// The scale of each unknown of a group: its diagonal, or what others would leave on it if they were eliminated before. Zero for others.
pub(super) fn scales(matrix: &CsrMatrix, owner: &[u32]) -> Vec<f64> {
    let diagonal = matrix.diagonal();
    let mut scales: Vec<f64> = diagonal.iter().map(|value| value.abs()).collect();
    for row in (0..scales.len()).filter(|row| owner[*row] != NONE) {
        let (columns, values) = matrix.row(row);
        for (column, value) in columns.iter().zip(values) {
            let other = diagonal[*column as usize].abs();
            if other > 0.0 {
                scales[row] = scales[row].max(value * value / other);
            }
        }
    }
    scales
}
