//! Factorisations against closed forms and by their residuals.

use std::f64::consts::PI;

use super::*;
use crate::equations::Side;
use crate::partial_solves::lower_times_transposed;
use crate::vector::norm;
use crate::{Ordering, PartialBackSubstitution, SharedWork};

/// The block matrix (five-point Laplacian on an m × m grid) ⊗ B, and one of its closed-form solutions:
/// B w at the nodes times the eigenvector sin(kπx) sin(lπy), whose eigenvalue is known.
pub(super) fn grid(m: usize, block: [[f64; 2]; 2], shift: f64) -> CsrMatrix {
    let mut triplets = Vec::new();
    let mut couple = |a: usize, b: usize, value: f64| {
        for (i, row) in block.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let shifted = if a == b && i == j { shift } else { 0.0 };
                triplets.push((2 * a + i, 2 * b + j, value * entry - shifted));
            }
        }
    };
    for y in 0..m {
        for x in 0..m {
            let node = y * m + x;
            couple(node, node, 4.0);
            if x + 1 < m {
                couple(node, node + 1, -1.0);
                couple(node + 1, node, -1.0);
            }
            if y + 1 < m {
                couple(node, node + m, -1.0);
                couple(node + m, node, -1.0);
            }
        }
    }
    CsrMatrix::from_triplets(2 * m * m, 2 * m * m, &triplets).unwrap()
}

pub(super) fn mode(m: usize, k: usize, l: usize, w: [f64; 2]) -> (Vec<f64>, f64) {
    let angle = PI / (m as f64 + 1.0);
    let values = (0..m * m)
        .flat_map(|node| {
            let s = ((k * (node % m + 1)) as f64 * angle).sin() * ((l * (node / m + 1)) as f64 * angle).sin();
            [s * w[0], s * w[1]]
        })
        .collect();
    (values, 4.0 - 2.0 * (k as f64 * angle).cos() - 2.0 * (l as f64 * angle).cos())
}

pub(super) fn error(found: &[f64], expected: &[f64]) -> f64 {
    let difference: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(expected)
}

fn analysed(matrix: &CsrMatrix) -> Arc<Analysis> {
    Arc::new(Analysis::new(matrix.pattern(), &Ordering::MinimumDegree).unwrap())
}

#[test]
fn the_block_laplacian_is_solved_against_its_closed_form() {
    let (m, block, w) = (30, [[3.0, 1.0], [1.0, 2.0]], [0.7, -0.4]);
    let matrix = grid(m, block, 0.0);
    let analysis = analysed(&matrix);
    let factor = SymmetricFactor::cholesky(&analysis, &matrix, Vec::new()).unwrap();
    assert!(factor.is_positive_definite());
    let (x, eigenvalue) = mode(m, 3, 2, w);
    let bw = [block[0][0] * w[0] + block[0][1] * w[1], block[1][0] * w[0] + block[1][1] * w[1]];
    let b: Vec<f64> = mode(m, 3, 2, bw).0.iter().map(|value| eigenvalue * value).collect();
    let refined = factor.solve_refined(&matrix, &b, 3).unwrap();
    assert!(error(&refined.solution, &x) < 1e-12, "{}", error(&refined.solution, &x));
    assert!(refined.relative_residual < 1e-12 && refined.backward_error < 1e-15);
    let mut plain = b.clone();
    factor.solve_in_place(&mut plain).unwrap();
    assert!(error(&plain, &x) < 1e-11);
}

#[test]
fn all_orderings_give_the_same_solution() {
    let matrix = grid(20, [[3.0, 1.0], [1.0, 2.0]], 0.0);
    let b: Vec<f64> = (0..800).map(|k| f64::from(k % 17) - 8.0).collect();
    let solve = |ordering| {
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
        let factor = SymmetricFactor::cholesky(&analysis, &matrix, Vec::new()).unwrap();
        factor.solve_refined(&matrix, &b, 3).unwrap().solution
    };
    let reference = solve(Ordering::MinimumDegree);
    let backwards = Ordering::Given((0..800).rev().collect());
    for ordering in [Ordering::NestedDissection, Ordering::LeastFill, backwards] {
        assert!(error(&solve(ordering), &reference) < 1e-13);
    }
}

#[test]
fn the_factor_is_of_the_new_matrix_when_analysis_and_storage_are_reused() {
    let (m, block, w) = (12, [[2.0, 0.0], [0.0, 2.0]], [1.0, 2.0]);
    let mut matrix = grid(m, block, 0.0);
    let analysis = analysed(&matrix);
    let storage = SymmetricFactor::cholesky(&analysis, &matrix, Vec::new()).unwrap().into_storage();
    let copy = matrix.clone();
    matrix.add_scaled(1.0, &copy).unwrap(); // twice the matrix
    let factor = SymmetricFactor::cholesky(&analysis, &matrix, storage).unwrap();
    let (mut b, eigenvalue) = mode(m, 1, 5, w);
    let x: Vec<f64> = b.iter().map(|value| value / (4.0 * eigenvalue)).collect();
    factor.solve_in_place(&mut b).unwrap();
    assert!(error(&b, &x) < 1e-13);
}

#[test]
fn an_indefinite_matrix_is_refused_by_llt_and_solved_by_lblt() {
    // The shift lies between eigenvalues, so some are negative.
    let (m, w, shift) = (25, [1.0, -3.0], 1.2345);
    let matrix = grid(m, [[1.0, 0.0], [0.0, 1.0]], shift);
    let analysis = analysed(&matrix);
    let refused = SymmetricFactor::cholesky(&analysis, &matrix, Vec::new());
    assert!(matches!(refused, Err(LinearAlgebraError::NotPositiveDefinite { unknown }) if unknown < 1250));
    let factor = SymmetricFactor::cholesky_or_indefinite(&analysis, &matrix, Vec::new()).unwrap();
    assert!(!factor.is_positive_definite());
    let (x, eigenvalue) = mode(m, 2, 1, w);
    assert!(eigenvalue < shift);
    let b: Vec<f64> = x.iter().map(|value| (eigenvalue - shift) * value).collect();
    let refined = factor.solve_refined(&matrix, &b, 5).unwrap();
    assert!(refined.backward_error < 1e-15);
    assert!(error(&refined.solution, &x) < 1e-12);
}

#[test]
fn two_by_two_pivots_of_a_saddle_point() {
    // [0 1; 1 0] has no nonzero diagonal pivot.
    let swap = CsrMatrix::from_triplets(2, 2, &[(0, 0, 0.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.0)]).unwrap();
    let factor = SymmetricFactor::indefinite(&analysed(&swap), &swap, Vec::new()).unwrap();
    assert_eq!(factor.solve_refined(&swap, &[3.0, 5.0], 2).unwrap().solution, [5.0, 3.0]);
}

#[test]
fn the_unknown_of_a_negative_pivot_is_named() {
    for bad in [0, 4, 9] {
        let triplets: Vec<_> = (0..10).map(|i| (i, i, if i == bad { -1.0 } else { 1.0 })).collect();
        let matrix = CsrMatrix::from_triplets(10, 10, &triplets).unwrap();
        let error = SymmetricFactor::cholesky(&analysed(&matrix), &matrix, Vec::new()).unwrap_err();
        assert_eq!(error, LinearAlgebraError::NotPositiveDefinite { unknown: bad });
    }
}

#[test]
fn a_singular_matrix_is_named() {
    // The Laplacian of a closed ring: constants are its null space. Scaled so that rounding enters.
    let n = 50;
    let mut triplets = Vec::new();
    for i in 0..n {
        let (j, weight) = ((i + 1) % n, 1.0 / (3.0 + i as f64));
        triplets.extend([(i, i, weight), (j, j, weight), (i, j, -weight), (j, i, -weight)]);
    }
    let ring = CsrMatrix::from_triplets(n, n, &triplets).unwrap();
    let analysis = analysed(&ring);
    let cholesky = SymmetricFactor::cholesky(&analysis, &ring, Vec::new()).unwrap_err();
    assert!(matches!(
        cholesky,
        LinearAlgebraError::Singular { .. } | LinearAlgebraError::NotPositiveDefinite { .. }
    ));
    let either = SymmetricFactor::cholesky_or_indefinite(&analysis, &ring, Vec::new()).unwrap_err();
    assert!(matches!(either, LinearAlgebraError::Singular { .. }), "{either}");
    // A row of zeros.
    let zero_row = CsrMatrix::from_triplets(3, 3, &[(0, 0, 1.0), (2, 2, 1.0)]).unwrap();
    let error = SymmetricFactor::indefinite(&analysed(&zero_row), &zero_row, Vec::new()).unwrap_err();
    assert!(matches!(error, LinearAlgebraError::Singular { unknown: 1, .. }), "{error}");
}

#[test]
fn nan_and_wrong_sizes_are_named() {
    let mut matrix = grid(3, [[1.0, 0.0], [0.0, 1.0]], 0.0);
    let analysis = analysed(&matrix);
    let factor = SymmetricFactor::cholesky(&analysis, &matrix, Vec::new()).unwrap();
    assert!(matches!(factor.solve_in_place(&mut [1.0; 3]), Err(LinearAlgebraError::SizeMismatch { .. })));
    let mut b = [1.0; 18];
    b[7] = f64::NAN;
    assert!(matches!(
        factor.solve_in_place(&mut b),
        Err(LinearAlgebraError::VectorNotFinite { index: 7, .. })
    ));
    matrix.values_mut()[0] = f64::NAN;
    assert!(matches!(
        SymmetricFactor::cholesky(&analysis, &matrix, Vec::new()),
        Err(LinearAlgebraError::EntryNotFinite { row: 0, column: 0, .. })
    ));
    let other = grid(2, [[1.0, 0.0], [0.0, 1.0]], 0.0);
    assert!(matches!(
        SymmetricFactor::cholesky(&analysis, &other, Vec::new()),
        Err(LinearAlgebraError::PatternMismatch { .. })
    ));
}

#[test]
fn an_empty_matrix_is_solved() {
    let empty = CsrMatrix::from_triplets(0, 0, &[]).unwrap();
    let factor = SymmetricFactor::cholesky(&analysed(&empty), &empty, Vec::new()).unwrap();
    assert!(factor.solve_refined(&empty, &[], 1).unwrap().solution.is_empty());
}

/// A positive definite matrix of dense groups of unknowns, each coupled with those before it that are named, with an entry of the
/// diagonal changed.
fn of_groups(size: usize, coupled: &[&[usize]], change: Option<(usize, f64)>) -> CsrMatrix {
    let mut triplets = Vec::new();
    for (group, others) in coupled.iter().enumerate() {
        for other in others.iter().chain([&group]) {
            for (i, j) in (0..size * size).map(|k| (group * size + k / size, other * size + k % size)) {
                if i > j {
                    let value = ((i * 7 + j * 3) as f64).sin();
                    triplets.extend([(i, j, value), (j, i, value)]);
                }
            }
        }
    }
    let unknowns = size * coupled.len();
    triplets.extend((0..unknowns).map(|i| (i, i, (1.5 * unknowns as f64) + (i as f64).cos())));
    triplets.extend(change.map(|(place, value)| (place, place, value)));
    CsrMatrix::from_triplets(unknowns, unknowns, &triplets).unwrap()
}

/// Matrices with narrow and with wide supernodes, with products of rows of all sizes, deep trees and those with many branches, and
/// orderings for them.
pub(super) fn of_all_shapes() -> Vec<(CsrMatrix, Ordering)> {
    let block = [[3.0, 1.0], [1.0, 2.0]];
    let backwards = |size: u32| Ordering::Given((0..size).rev().collect());
    let forwards = |size: u32| Ordering::Given((0..size).collect());
    vec![
        (grid(1, block, 0.0), Ordering::MinimumDegree),
        (grid(9, block, 0.0), backwards(162)),
        (grid(22, block, 0.0), Ordering::MinimumDegree),
        (grid(22, block, 0.0), Ordering::NestedDissection),
        (of_groups(331, &[&[]], None), forwards(331)),
        (of_groups(70, &[&[], &[], &[0, 1], &[], &[], &[3, 4], &[2, 5]], None), forwards(490)),
        (of_groups(30, &[&[], &[0], &[1], &[0, 2], &[], &[4, 3]], None), forwards(180)),
        (of_groups(7, &[&[][..]; 40], None), forwards(280)),
    ]
}

#[test]
fn a_factor_times_its_transposed_is_the_matrix() {
    for (matrix, ordering) in of_all_shapes() {
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
        // Storage that is reused need not be zero.
        let storage = vec![f64::NAN; analysis.factor_entries()];
        let factor = SymmetricFactor::cholesky(&analysis, &matrix, storage).unwrap();
        let size = matrix.rows();
        let signs = vec![1.0; size];
        let block = factor.trailing_block(size);
        let times = |threads| lower_times_transposed(Threads::new(threads), &block, &signs);
        let product = times(1);
        assert!([2, 3, 7, 16].into_iter().all(|threads| times(threads) == product), "{size}");
        for i in 0..size {
            for j in 0..=i {
                let (a, b) = (analysis.order[i] as usize, analysis.order[j] as usize);
                let difference = product[(i, j)] - matrix.get(a, b);
                let scale = (matrix.get(a, a) * matrix.get(b, b)).sqrt();
                assert!(difference.abs() < 1e-14 * scale, "{size}: ({i}, {j}) is off by {difference}");
            }
        }
    }
}

#[test]
fn a_factor_has_the_same_bits_on_any_number_of_threads() {
    for (matrix, ordering) in of_all_shapes() {
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
        let bits = |threads| {
            let factor =
                SymmetricFactor::cholesky_on(Threads::new(threads), &analysis, &matrix, vec![]).unwrap();
            factor.into_storage().into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        let one = bits(1);
        for threads in [2, 3, 7, 16] {
            assert!(bits(threads) == one, "{} unknowns, {threads} threads", matrix.rows());
        }
    }
}

#[test]
fn many_units_are_factored_and_solved_with_the_same_bits_on_any_number_of_threads() {
    let (m, block) = (160, [[3.0, 1.0], [1.0, 2.0]]);
    let matrix = grid(m, block, 0.0);
    let (wanted, _) = mode(m, 3, 2, [0.7, -0.4]);
    let load = matrix.multiply(&wanted).unwrap();
    let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::NestedDissection).unwrap());
    let units = &analysis.elimination().units;
    assert!(units.len() > 30, "{} units", units.len());
    assert!(units.iter().any(|unit| unit.panels > 1), "wide supernodes are cut into panels");
    let found = |threads| {
        let factor = SymmetricFactor::cholesky_on(Threads::new(threads), &analysis, &matrix, vec![]).unwrap();
        let mut x = load.clone();
        factor.solve_in_place(&mut x).unwrap();
        assert!(error(&x, &wanted) < 1e-11, "{threads} threads: {}", error(&x, &wanted));
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        // One of them is zero but for a few unknowns.
        let mut local = vec![0.0; load.len()];
        local[40..50].copy_from_slice(&wanted[40..50]);
        let lower = factor.solve_lower_each(&[&load, &local, &wanted]).unwrap();
        let upper = factor.solve_upper_each(lower.clone()).unwrap();
        for ((b, y), x) in [&load, &local, &wanted].into_iter().zip(&lower).zip(&upper) {
            let alone = factor.solve_lower(b).unwrap();
            assert!(bits(&alone) == bits(y), "{threads} threads");
            assert!(bits(&factor.solve_upper(alone).unwrap()) == bits(x), "{threads} threads");
        }
        let few = [7, 8, 3200, 50_000];
        let mut partial = PartialBackSubstitution::new(&factor, &few).unwrap();
        let of_few = bits(&few.map(|unknown| x[unknown as usize]));
        assert!(bits(&partial.solve(&factor, &lower[0]).unwrap()) == of_few, "{threads} threads");
        let mut in_place = [load.clone(), local];
        factor.solve_each_in_place(&mut in_place).unwrap();
        assert!(bits(&in_place.concat()) == bits(&upper[..2].concat()), "{threads} threads");
        assert!(bits(&upper[0]) == bits(&x), "{threads} threads");
        // Refined for a matrix that differs a little from the one that was factored: each as by itself, whatever the others need.
        let mut nearby = matrix.clone();
        nearby.values_mut().iter_mut().for_each(|value| *value *= 1.0 + 1e-9);
        let side = Side::plain(&nearby);
        let systems = [(&side, &load[..]), (&side, &vec![0.0; load.len()]), (&side, &wanted)];
        let refine = |systems: &[(&Side<'_>, &[f64])]| {
            let found = factor.solve_sides_refined(systems, Threads::new(threads), 1e3, 3).unwrap();
            found.into_iter().collect::<Result<Vec<_>, _>>().unwrap()
        };
        let refined = refine(&systems);
        assert!(refined[0].steps > 0 && refined[1].steps == 0 && refined[0].backward_error < 1e-14);
        for (system, found) in systems.iter().zip(&refined) {
            assert!(refine(&[*system])[0] == *found, "{threads} threads");
        }
        assert!(refine(&systems[1..])[..] == refined[1..], "{threads} threads");
        (bits(&factor.values), bits(&x), bits(&upper.concat()))
    };
    let one = found(1);
    for threads in [2, 3, 7, 16] {
        assert!(found(threads) == one, "{threads} threads");
    }
    let (factorisation, solve) = (analysis.factorisation_work(), analysis.solve_work());
    for counted in [&factorisation, &solve] {
        let speed_ups = SharedWork::THREADS.map(|threads| counted.speed_up(threads).unwrap());
        assert!(speed_ups[0] > 1.9 && speed_ups[3] > 5.0, "{speed_ups:?}");
        assert!(speed_ups.iter().all(|found| *found <= 1.000_001 * counted.work / counted.critical_path));
    }
    let entries = analysis.factor_entries() as f64;
    assert!(solve.work > 0.5 * entries && solve.work < 2.0 * entries, "{} of {entries}", solve.work);
    assert!(factorisation.work > 0.8 * analysis.multiplications());
}

#[test]
fn a_dense_matrix_is_shared_by_panels() {
    let size = 800;
    let entry = |i: usize, j: usize| if i == j { 900.0 } else { ((i * j) as f64).cos() };
    let triplets: Vec<_> =
        (0..size * size).map(|k| (k / size, k % size, entry(k / size, k % size))).collect();
    let matrix = CsrMatrix::from_triplets(size, size, &triplets).unwrap();
    let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::MinimumDegree).unwrap());
    assert!(analysis.factorisation_work().speed_up(4).unwrap() > 1.8);
    let values = |threads| {
        SymmetricFactor::cholesky_on(Threads::new(threads), &analysis, &matrix, vec![])
            .unwrap()
            .into_storage()
    };
    assert!(values(1) == values(7));
}

#[test]
fn the_first_pivot_that_is_not_positive_is_named_on_any_number_of_threads() {
    // In a leaf, where later ones fail too; in the second panel of a wide group.
    let leaves: &[&[usize]] = &[&[], &[], &[0, 1], &[], &[], &[3, 4], &[2, 5]];
    let bad = of_groups(20, leaves, Some((93, -1e3)));
    let worse = bad.plus(&[crate::Entry { row: 31, column: 31, value: -1e3 }]).unwrap();
    let wide = of_groups(150, &[&[], &[0]], Some((267, -1e4)));
    for (matrix, unknown) in [(bad, 93), (worse, 31), (wide, 267)] {
        let order = (0..matrix.rows() as u32).collect();
        let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::Given(order)).unwrap());
        for threads in [1, 2, 3, 7, 16] {
            let threads = Threads::new(threads);
            let error = SymmetricFactor::cholesky_on(threads, &analysis, &matrix, vec![]).unwrap_err();
            assert_eq!(error, LinearAlgebraError::NotPositiveDefinite { unknown });
        }
    }
}
