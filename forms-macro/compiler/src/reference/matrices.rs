//! Matrices of dual numbers, row-major: products, and determinants by Laplace's expansion.

use super::number::Number;
use crate::tensor::LinearMap;

pub fn pairs(a: &[Number], b: &[Number], join: fn(&Number, &Number) -> Number) -> Vec<Number> {
    a.iter().zip(b).map(|(a, b)| join(a, b)).collect()
}

pub fn total(numbers: &[Number]) -> Number {
    numbers.iter().fold(Number::real(0.0), |sum, number| sum.plus(number))
}

pub fn identity(size: usize) -> Vec<Number> {
    let entry = |entry: usize| if entry / size == entry % size { 1.0 } else { 0.0 };
    (0..size * size).map(|index| Number::real(entry(index))).collect()
}

/// Last axis of the first with first axis of the second, of this length.
pub fn matrix_product(a: &[Number], b: &[Number], inner: usize) -> Vec<Number> {
    let columns = b.len() / inner;
    let entry = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        let products = (0..inner).map(|k| a[row * inner + k].times(&b[k * columns + column]));
        total(&products.collect::<Vec<_>>())
    };
    (0..a.len() / inner * columns).map(entry).collect()
}

pub fn transposed(a: &[Number], shape: &[usize]) -> Vec<Number> {
    let (rows, columns) = (shape[0], shape[1]);
    (0..a.len()).map(|entry| a[entry % rows * columns + entry / rows].clone()).collect()
}

fn trace(a: &[Number], size: usize) -> Number {
    total(&(0..size).map(|i| a[i * size + i].clone()).collect::<Vec<_>>())
}

pub fn linear_map(map: LinearMap, a: &[Number], shape: &[usize]) -> Vec<Number> {
    let half = |join: fn(&Number, &Number) -> Number| -> Vec<Number> {
        pairs(a, &transposed(a, shape), join).iter().map(|entry| entry.scaled(0.5)).collect()
    };
    #[allow(unreachable_patterns)]
    match map {
        LinearMap::Transpose => transposed(a, shape),
        LinearMap::Trace => vec![trace(a, shape[0])],
        LinearMap::Symmetric => half(Number::plus),
        LinearMap::Skew => half(Number::minus),
        LinearMap::Deviator => {
            let mean = trace(a, shape[0]).scaled(1.0 / shape[0] as f64);
            let spherical: Vec<_> = identity(shape[0]).iter().map(|entry| entry.times(&mean)).collect();
            pairs(a, &spherical, Number::minus)
        }
        // A map that is new: add its meaning here.
        other => panic!("the reference evaluator has no rule for {other:?}"),
    }
}

/// The matrix without a row and a column.
fn minor(a: &[Number], size: usize, row: usize, column: usize) -> Vec<Number> {
    let kept = |entry: &usize| entry / size != row && entry % size != column;
    (0..a.len()).filter(kept).map(|entry| a[entry].clone()).collect()
}

/// Laplace's expansion along the first row.
pub fn determinant(a: &[Number], size: usize) -> Number {
    if size == 0 {
        return Number::real(1.0);
    }
    let term = |column: usize| {
        let sign = if column % 2 == 0 { 1.0 } else { -1.0 };
        a[column].times(&determinant(&minor(a, size, 0, column), size - 1)).scaled(sign)
    };
    total(&(0..size).map(term).collect::<Vec<_>>())
}

pub fn cofactor(a: &[Number], size: usize) -> Vec<Number> {
    let entry = |index: usize| {
        let (row, column) = (index / size, index % size);
        let sign = if (row + column) % 2 == 0 { 1.0 } else { -1.0 };
        determinant(&minor(a, size, row, column), size - 1).scaled(sign)
    };
    (0..size * size).map(entry).collect()
}
