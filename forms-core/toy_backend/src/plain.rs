//! Vectors and matrices in plain floating-point code, for evaluations that know nothing of the compiler.

pub type Matrix = Vec<Vec<f64>>;

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
pub fn inner(a: &Matrix, b: &Matrix) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(a, b)).sum()
}
pub fn matrix(d: usize, entry: impl Fn(usize, usize) -> f64) -> Matrix {
    (0..d).map(|i| (0..d).map(|j| entry(i, j)).collect()).collect()
}
pub fn vector(d: usize, entry: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..d).map(entry).collect()
}
pub fn trace(a: &Matrix) -> f64 {
    (0..a.len()).map(|i| a[i][i]).sum()
}

/// A result of an independent evaluation.
pub trait Components {
    fn components(self) -> Vec<f64>;
}
impl Components for f64 {
    fn components(self) -> Vec<f64> {
        vec![self]
    }
}
impl Components for Vec<f64> {
    fn components(self) -> Vec<f64> {
        self
    }
}
impl Components for Matrix {
    fn components(self) -> Vec<f64> {
        self.concat()
    }
}

/// Values at points compared with those of an independent evaluation: each component up to 1e-12 of its size, or of one.
pub fn assert_values<R: Components>(found: &[Vec<f64>], expected: impl ExactSizeIterator<Item = R>) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let expected = expected.components();
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} is not {expected}");
        }
    }
}
