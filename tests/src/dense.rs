//! Small matrices as dense ones, and their comparison entry by entry.

use forms_fem::linear_algebra::CsrMatrix;
use nalgebra::DMatrix;

/// All entries of a sparse matrix; those that it does not store are zero.
pub fn dense(matrix: &CsrMatrix) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(matrix.rows(), matrix.columns());
    for row in 0..matrix.rows() {
        let (columns, values) = matrix.row(row);
        for (column, value) in columns.iter().zip(values) {
            all[(row, *column as usize)] = *value;
        }
    }
    all
}

/// The largest difference of two entries, relative to the largest entry of the second list.
pub fn deviation(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len(), "lengths");
    assert!(ours.iter().chain(theirs).all(|value| value.is_finite()), "an entry is not finite");
    let scale = theirs.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let difference = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if difference == 0.0 { 0.0 } else { difference / scale }
}

/// Asserts that two lists agree to a part of the second one's largest entry, and gives the deviation.
pub fn assert_close(label: &str, ours: &[f64], theirs: &[f64], tolerance: f64) -> f64 {
    let found = deviation(ours, theirs);
    assert!(found <= tolerance, "{label}: deviation {found:.2e}, allowed {tolerance:.0e}");
    found
}

/// The same for two matrices.
pub fn assert_same_matrix(label: &str, ours: &DMatrix<f64>, theirs: &DMatrix<f64>, tolerance: f64) -> f64 {
    assert_eq!(ours.shape(), theirs.shape(), "{label}: shape");
    assert_close(label, ours.as_slice(), theirs.as_slice(), tolerance)
}
