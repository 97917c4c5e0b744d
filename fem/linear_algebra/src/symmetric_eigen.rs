//! Eigenvalues and eigenvectors of small dense symmetric matrices.

use crate::wide_registers::cleared;
use faer::{Mat, Side};

/// Eigenvalues, and the eigenvector of each.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricEigen {
    /// The eigenvalues, in ascending order.
    pub values: Vec<f64>,
    /// Orthonormal eigenvectors, in the order of the values.
    pub vectors: Vec<Vec<f64>>,
}

impl SymmetricEigen {
    /// The decomposition of a symmetric matrix of `size` rows, row by row; its lower triangle is read. None if an entry is not
    /// finite or missing, or where the iteration does not converge.
    pub fn of(size: usize, entries: &[f64]) -> Option<Self> {
        if entries.len() != size * size || entries.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        if size == 0 {
            return Some(SymmetricEigen { values: vec![], vectors: vec![] });
        }
        let matrix = Mat::from_fn(size, size, |row, column| entries[row * size + column]);
        let found = cleared(|| matrix.self_adjoint_eigen(Side::Lower)).ok()?;
        Some(SymmetricEigen {
            values: found.S().column_vector().iter().copied().collect(),
            vectors: found.U().col_iter().map(|vector| vector.iter().copied().collect()).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::irregular;

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// A v = λ v and orthonormal vectors, for matrices full, of low rank, with equal eigenvalues, diagonal, of one row and of none.
    #[test]
    fn vectors_belong_to_their_values() {
        let product = |size: usize, rank: usize| {
            let b: Vec<f64> = irregular(size * rank).collect();
            let entry = |i: usize, j: usize| (0..rank).map(|k| b[i * rank + k] * b[j * rank + k]).sum();
            (0..size * size).map(|place| entry(place / size, place % size)).collect::<Vec<f64>>()
        };
        let plus_identity = |size: usize, mut entries: Vec<f64>| {
            (0..size).for_each(|k| entries[k * size + k] += 1.0);
            entries
        };
        let zero = |size: usize| vec![0.0; size * size];
        for (size, entries) in [
            (27, product(27, 27)),
            (54, product(54, 6)),
            (20, plus_identity(20, product(20, 2))),
            (5, plus_identity(5, zero(5))),
            (4, zero(4)),
            (2, vec![1.0, 0.0, 3.0, -1.0]),
            (1, vec![-2.0]),
            (0, vec![]),
        ] {
            let found = SymmetricEigen::of(size, &entries).unwrap();
            assert_eq!((found.values.len(), found.vectors.len()), (size, size));
            let scale = entries.iter().fold(1.0_f64, |scale, entry| scale.max(entry.abs()));
            for (value, vector) in found.values.iter().zip(&found.vectors) {
                for i in 0..size {
                    let lower = |i: usize, j: usize| entries[i.max(j) * size + i.min(j)];
                    let image: f64 = (0..size).map(|j| lower(i, j) * vector[j]).sum();
                    assert!(
                        (image - value * vector[i]).abs() < 1e-13 * scale * size as f64,
                        "{size}: {value}"
                    );
                }
            }
            for (i, a) in found.vectors.iter().enumerate() {
                for (j, b) in found.vectors.iter().enumerate() {
                    assert!((dot(a, b) - f64::from(u8::from(i == j))).abs() < 1e-13);
                }
            }
        }
        assert_eq!(SymmetricEigen::of(1, &[f64::NAN]), None);
        assert_eq!(SymmetricEigen::of(2, &[1.0]), None);
    }

    /// The matrix of second differences has the eigenvalues 2 − 2 cos(kπ/(n+1)).
    #[test]
    fn second_differences() {
        let size = 30;
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        };
        let entries: Vec<f64> = (0..size * size).map(|place| entry(place / size, place % size)).collect();
        let mut values = SymmetricEigen::of(size, &entries).unwrap().values;
        values.sort_by(f64::total_cmp);
        for (k, value) in (1_u8..).zip(values) {
            let exact = 2.0 - 2.0 * (f64::from(k) * std::f64::consts::PI / (size as f64 + 1.0)).cos();
            assert!((value - exact).abs() < 1e-14, "{value} {exact}");
        }
    }
}
