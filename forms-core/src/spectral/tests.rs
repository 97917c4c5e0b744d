//! Spectral functions against closed forms, and their derivatives against differences, with equal eigenvalues.

use super::*;
use crate::dual::{Dual, Seeded};

type Matrix = [[f64; 3]; 3];

/// A rotation by Rodrigues' formula.
fn rotation() -> Matrix {
    let (axis, angle): ([f64; 3], f64) = ([2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], 0.9);
    let cross = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            f64::from(i == j) * angle.cos()
                + cross[i][j] * angle.sin()
                + axis[i] * axis[j] * (1.0 - angle.cos())
        })
    })
}

/// Q diag Qᵀ.
fn with_eigenvalues(eigenvalues: [f64; 3]) -> Matrix {
    let q = rotation();
    let diagonal = std::array::from_fn(|i| std::array::from_fn(|j| eigenvalues[i] * f64::from(i == j)));
    rotate(&diagonal, &q)
}

fn distance(a: &Matrix, b: &Matrix) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
}

/// Distinct, nearly equal and equal eigenvalues, and a wide range.
const CASES: [[f64; 3]; 7] = [
    [0.5, 1.3, 2.9],
    [1.3, 1.3, 2.9],
    [1.7, 1.7, 1.7],
    [1.0, 1.0 + 1e-9, 1.0 - 1e-5],
    [1.0, 1.05, 1.1],
    [0.9, 1.1, 1.0],
    [1e-3, 1.0, 40.0],
];

type Plain = fn(Matrix) -> Matrix;
type Once = fn([[Dual<f64>; 3]; 3]) -> [[Dual<f64>; 3]; 3];
type Twice = fn([[Dual<Dual<f64>>; 3]; 3]) -> [[Dual<Dual<f64>>; 3]; 3];
type Thrice = fn([[Dual<Dual<Dual<f64>>>; 3]; 3]) -> [[Dual<Dual<Dual<f64>>>; 3]; 3];

/// A scalar function and the tensor function, with the given number of derivatives.
type Function = (fn(f64) -> f64, Plain, Once, Twice, Thrice);

fn functions() -> [Function; 3] {
    [
        (f64::exp, tensor_exp, tensor_exp, tensor_exp, tensor_exp),
        (f64::ln, tensor_ln, tensor_ln, tensor_ln, tensor_ln),
        (f64::sqrt, tensor_sqrt, tensor_sqrt, tensor_sqrt, tensor_sqrt),
    ]
}

const DIRECTIONS: [Matrix; 3] = [
    [[0.3, -0.2, 0.5], [-0.2, 0.7, 0.1], [0.5, 0.1, -0.4]],
    [[-0.1, 0.6, 0.2], [0.6, 0.3, -0.5], [0.2, -0.5, 0.2]],
    [[0.5, 0.1, -0.3], [0.1, -0.2, 0.4], [-0.3, 0.4, 0.6]],
];

/// a + step · direction.
fn moved(a: &Matrix, direction: &Matrix, step: f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + step * direction[i][j]))
}

#[test]
fn values_agree_with_closed_forms() {
    for eigenvalues in CASES {
        let a = with_eigenvalues(eigenvalues);
        for (scalar, tensor, ..) in functions() {
            let expected = with_eigenvalues(eigenvalues.map(scalar));
            let scale = expected.as_flattened().iter().fold(1.0_f64, |scale, entry| scale.max(entry.abs()));
            assert!(distance(&tensor(a), &expected) < 1e-12 * scale, "{eigenvalues:?}");
        }
        let root = tensor_sqrt(a);
        let square: Matrix =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| root[i][k] * root[k][j]).sum()));
        assert!(distance(&square, &a) < 1e-13 * eigenvalues[2].max(1.0));
        assert!(distance(&tensor_exp(tensor_ln(a)), &a) < 1e-12 * eigenvalues[2].max(1.0));
    }
}

/// The first derivative along a direction.
fn first(function: Once, a: &Matrix, e: &Matrix) -> Matrix {
    let dual = std::array::from_fn(|i| std::array::from_fn(|j| Dual { value: a[i][j], derivative: e[i][j] }));
    function(dual).map(|row| row.map(Seeded::highest))
}

/// The second derivative along two directions.
fn second(function: Twice, a: &Matrix, e: &Matrix, f: &Matrix) -> Matrix {
    let dual = std::array::from_fn(|i| {
        std::array::from_fn(|j| Dual {
            value: Dual { value: a[i][j], derivative: f[i][j] },
            derivative: Dual::from(e[i][j]),
        })
    });
    function(dual).map(|row| row.map(Seeded::highest))
}

/// The third.
fn third(function: Thrice, a: &Matrix, [e, f, g]: &[Matrix; 3]) -> Matrix {
    let dual = std::array::from_fn(|i| {
        std::array::from_fn(|j| Dual {
            value: Dual {
                value: Dual { value: a[i][j], derivative: g[i][j] },
                derivative: Dual::from(f[i][j]),
            },
            derivative: Dual::from(e[i][j]),
        })
    });
    function(dual).map(|row| row.map(Seeded::highest))
}

#[test]
fn derivatives_agree_with_central_differences() {
    let [e, f, _] = DIRECTIONS;
    for eigenvalues in &CASES[..6] {
        let a = with_eigenvalues(*eigenvalues);
        for (_, plain, once, twice, thrice) in functions() {
            let h = 1e-5;
            let difference = |ahead: Matrix, behind: Matrix| -> Matrix {
                std::array::from_fn(|i| std::array::from_fn(|j| (ahead[i][j] - behind[i][j]) / (2.0 * h)))
            };
            let slope = difference(plain(moved(&a, &e, h)), plain(moved(&a, &e, -h)));
            assert!(distance(&first(once, &a, &e), &slope) < 1e-8, "{eigenvalues:?}");
            let bend = difference(first(once, &moved(&a, &f, h), &e), first(once, &moved(&a, &f, -h), &e));
            assert!(distance(&second(twice, &a, &e, &f), &bend) < 1e-7, "{eigenvalues:?}");
            let g = &DIRECTIONS[2];
            let twist =
                difference(second(twice, &moved(&a, g, h), &e, &f), second(twice, &moved(&a, g, -h), &e, &f));
            assert!(distance(&third(thrice, &a, &DIRECTIONS), &twist) < 1e-5, "{eigenvalues:?}");
        }
    }
}

/// d(X²) along E is X E + E X for any direction: the square root's derivative solves that equation.
#[test]
fn a_direction_need_not_be_symmetric() {
    let direction = [[0.3, -0.2, 0.5], [0.9, 0.7, 0.1], [-0.5, 0.4, -0.4]];
    for eigenvalues in CASES {
        let a = with_eigenvalues(eigenvalues);
        let (root, slope) = (tensor_sqrt(a), first(tensor_sqrt, &a, &direction));
        let product: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| root[i][k] * slope[k][j] + slope[i][k] * root[k][j]).sum())
        });
        assert!(distance(&product, &direction) < 1e-11, "{eigenvalues:?}");
    }
}

#[test]
fn one_and_two_dimensions_and_bad_tensors() {
    assert_eq!(tensor_exp([[0.5]]), [[0.5_f64.exp()]]);
    // exp of [[a, b], [b, a]] is e^a [[cosh b, sinh b], [sinh b, cosh b]].
    let found = tensor_exp([[0.3, 0.8], [0.8, 0.3]]);
    let expected = [0.8_f64.cosh(), 0.8_f64.sinh()].map(|value| 0.3_f64.exp() * value);
    assert!((found[0][0] - expected[0]).abs() < 1e-15 && (found[0][1] - expected[1]).abs() < 1e-15);
    let is_nan = |value: [[f64; 2]; 2]| value.as_flattened().iter().any(|entry| entry.is_nan());
    assert!(is_nan(tensor_ln([[1.0, 2.0], [2.0, 1.0]])), "an eigenvalue is negative");
    assert!(is_nan(tensor_sqrt([[1.0, 2.0], [2.0, 1.0]])), "an eigenvalue is negative");
    assert!(is_nan(tensor_exp([[1.0, 2.0], [2.1, 1.0]])), "not symmetric");
    assert!(is_nan(tensor_exp([[f64::NAN, 0.0], [0.0, 1.0]])));
    assert_eq!(tensor_exp([[0.0; 3]; 3])[1], [0.0, 1.0, 0.0]);
}
