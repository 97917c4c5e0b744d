//! Eigenpairs of diagonal pencils and small chains, whose eigenvalues are known.

use super::*;
use crate::CsrMatrix;

fn diagonal(values: &[f64]) -> CsrMatrix {
    let entries: Vec<_> = values.iter().enumerate().map(|(row, value)| (row, row, *value)).collect();
    CsrMatrix::from_triplets(values.len(), values.len(), &entries).unwrap()
}

/// Second differences on m nodes, and the mass of linear elements, both with the step 1.
fn chain(m: usize, [middle, beside]: [f64; 2]) -> CsrMatrix {
    let mut triplets = vec![];
    for node in 0..m {
        triplets.push((node, node, middle));
        if node + 1 < m {
            triplets.extend([(node, node + 1, beside), (node + 1, node, beside)]);
        }
    }
    CsrMatrix::from_triplets(m, m, &triplets).unwrap()
}

/// 6 (1 − cos θ) / (2 + cos θ), θ = kπ/(m + 1), by linear elements.
#[test]
fn a_string_of_linear_elements_has_the_eigenvalues_of_its_difference_equation() {
    let m = 199;
    let exact = |k: usize| {
        let cosine = (k as f64 * std::f64::consts::PI / (m as f64 + 1.0)).cos();
        6.0 * (1.0 - cosine) / (2.0 + cosine)
    };
    let (stiffness, mass) = (chain(m, [2.0, -1.0]), chain(m, [2.0 / 3.0, 1.0 / 6.0]));
    let pencil = SymmetricPencil::new(&stiffness, &mass, Positive::Second).unwrap();
    for (shift, first) in [(0.0, 1), (-3.0, 1), (0.5 * (exact(40) + exact(41)), 41)] {
        let pairs = pencil.eigenpairs_above(shift, 9).unwrap();
        for (k, pair) in (first..).zip(&pairs) {
            let error = (pair.value - exact(k)).abs();
            assert!(
                error < 1e-11 * (1.0 + shift.abs()) && pair.residual < 1e-11,
                "{shift}: {k} {} {error:e} {:e}",
                pair.value,
                pair.residual
            );
            assert!(error <= pair.error_bound + 1e-13 * (1.0 + shift.abs()), "{shift}: {k} {error:e}");
        }
    }
    // All that are above the shift, and one more.
    let all = pencil.eigenpairs_above(exact(190) + 1e-6, 9).unwrap();
    assert!((all[8].value - exact(199)).abs() < 1e-9);
    let more = pencil.eigenpairs_above(exact(190) + 1e-6, 10);
    assert!(matches!(more, Err(EigenError::TooFew { asked: 10, found: 9, .. })), "{more:?}");
}

/// Seven equal eigenvalues, more than vectors at the start: the count sees what is missing.
#[test]
fn equal_eigenvalues_are_all_found() {
    let values: Vec<f64> =
        [vec![2.0; 7], vec![5.0; 3], (0..60).map(|k| 7.0 + f64::from(k)).collect()].concat();
    let pencil = SymmetricPencil::new(&diagonal(&values), &diagonal(&[1.0; 70]), Positive::Second).unwrap();
    for count in [1, 4, 7, 8, 12] {
        let pairs = pencil.eigenpairs_above(0.0, count).unwrap();
        for (pair, exact) in pairs.iter().zip(&values) {
            assert!((pair.value - exact).abs() < 1e-11, "{count}: {}", pair.value);
        }
        for (i, one) in pairs.iter().enumerate() {
            for (j, other) in pairs.iter().enumerate() {
                let product = crate::vector::dot(&one.vector, &other.vector);
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9, "{i} {j} {product:e}");
            }
        }
    }
}

/// λ = a/b with b of both signs and zero: the smallest positive ones, from zero, from between, and from below zero.
#[test]
fn loads_in_both_directions() {
    let a: Vec<f64> = (1..=40).map(f64::from).collect();
    let b: Vec<f64> = (1..=40).map(|k| [0.0, 1.0, -2.0][k % 3] / (1.0 + k as f64)).collect();
    let mut exact: Vec<f64> = a.iter().zip(&b).filter(|(_, b)| **b != 0.0).map(|(a, b)| a / b).collect();
    exact.sort_by(f64::total_cmp);
    let pencil = SymmetricPencil::new(&diagonal(&a), &diagonal(&b), Positive::First).unwrap();
    for shift in [0.0, 100.0, -40.0] {
        let above: Vec<f64> = exact.iter().copied().filter(|value| *value > shift).take(5).collect();
        let pairs = pencil.eigenpairs_above(shift, 5).unwrap();
        for (pair, exact) in pairs.iter().zip(&above) {
            assert!((pair.value - exact).abs() < 1e-9 * exact.abs(), "{shift}: {} {exact}", pair.value);
        }
    }
}

#[test]
fn what_does_not_fit_is_named() {
    let ones = diagonal(&[1.0; 6]);
    let at_zero = SymmetricPencil::new(&diagonal(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), &ones, Positive::Second);
    let found = at_zero.unwrap().eigenpairs_above(0.0, 2).unwrap_err();
    assert!(matches!(found, EigenError::ShiftIsEigenvalue { shift: 0.0, .. }), "{found}");
    let skew = CsrMatrix::from_triplets(2, 2, &[(0, 0, 1.0), (0, 1, 1.0), (1, 1, 1.0), (1, 0, 0.0)]).unwrap();
    let found = SymmetricPencil::new(&skew, &diagonal(&[1.0; 2]), Positive::Second).unwrap_err();
    assert!(matches!(found, EigenError::NotSymmetric { which: "first", .. }), "{found}");
    let negative = SymmetricPencil::new(&ones, &diagonal(&[-1.0; 6]), Positive::Second).unwrap();
    let found = negative.eigenpairs_above(0.0, 2).unwrap_err();
    assert!(matches!(found, EigenError::NotPositive { which: "second", .. }), "{found}");
}
