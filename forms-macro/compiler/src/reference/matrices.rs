//! Matrices of dual numbers, row-major: products, and determinants by Laplace's expansion.

use super::number::Number;
use crate::tensor::{LinearMap, Selection};

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
        LinearMap::Curl if shape[0] == 2 => vec![a[2].minus(&a[1])],
        // ε_ijk G_kj
        LinearMap::Curl => vec![a[7].minus(&a[5]), a[2].minus(&a[6]), a[3].minus(&a[1])],
        LinearMap::Perpendicular => vec![a[1].scaled(-1.0), a[0].clone()],
        LinearMap::Diagonal => (0..shape[0]).map(|i| a[i * shape[1] + i].clone()).collect(),
        LinearMap::DiagonalTensor => {
            let unit = identity(shape[0]);
            unit.iter().enumerate().map(|(entry, one)| one.times(&a[entry / shape[0]])).collect()
        }
        // A new map needs its meaning here.
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
        let sign = if column.is_multiple_of(2) { 1.0 } else { -1.0 };
        a[column].times(&determinant(&minor(a, size, 0, column), size - 1)).scaled(sign)
    };
    total(&(0..size).map(term).collect::<Vec<_>>())
}

pub fn cofactor(a: &[Number], size: usize) -> Vec<Number> {
    let entry = |index: usize| {
        let (row, column) = (index / size, index % size);
        let sign = if (row + column).is_multiple_of(2) { 1.0 } else { -1.0 };
        determinant(&minor(a, size, row, column), size - 1).scaled(sign)
    };
    (0..size * size).map(entry).collect()
}

/// a × b, or its last component for vectors in the plane.
pub fn cross(a: &[Number], b: &[Number]) -> Vec<Number> {
    let entry = |i: usize, j: usize| a[i].times(&b[j]).minus(&a[j].times(&b[i]));
    match a.len() {
        2 => vec![entry(0, 1)],
        _ => vec![entry(1, 2), entry(2, 0), entry(0, 1)],
    }
}

/// `straight` δ_ik δ_jl + `crossed` δ_il δ_jk
pub fn identity_of_tensors(size: usize, straight: f64, crossed: f64) -> Vec<Number> {
    let entry = |index: usize| {
        let (i, j) = (index / size.pow(3), index / size.pow(2) % size);
        let (k, l) = (index / size % size, index % size);
        let one = |holds: bool, value: f64| if holds { value } else { 0.0 };
        Number::real(one(i == k && j == l, straight) + one(i == l && j == k, crossed))
    };
    (0..size.pow(4)).map(entry).collect()
}

/// The row-major positions of what is taken of a tensor.
pub fn chosen(shape: &[usize], selections: &[Selection]) -> Vec<usize> {
    let mut positions = vec![0];
    for (extent, selection) in shape.iter().zip(selections) {
        let range = match selection {
            Selection::One(index) => *index..index + 1,
            Selection::Range { start, end } => *start..*end,
        };
        positions = positions
            .iter()
            .flat_map(|position| range.clone().map(move |index| position * extent + index))
            .collect();
    }
    positions
}
