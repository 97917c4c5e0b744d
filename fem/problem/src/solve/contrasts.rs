//! Tests of all solvers on systems whose rows differ in scale: stiff and soft halves, fields of different units.

mod of_forms;

use super::*;
use crate::linear_algebra::{
    CsrMatrix, Entry, Jacobi, KrylovOptions, LinearAlgebraError, MultigridOptions, cg, minres,
};
use crate::prelude::*;

const N: usize = 40;
const CONTRASTS: [f64; 8] = [1e-16, 1e-12, 1e-8, 1e-4, 1e4, 1e8, 1e12, 1e16];

/// Stiffness and drift of an element of a chain.
type Law = fn(f64, usize) -> (f64, f64);

/// −(k u')' + c u' on elements 0..=N between ends that are held, where the halves differ by a contrast.
fn chain(law: Law, contrast: f64) -> Vec<(usize, usize, f64)> {
    let mut triplets = Vec::new();
    for element in 0..=N {
        let (k, c) = law(contrast, element);
        // Nodes element − 1 and element; −1 and N are held.
        for (row, sign) in [(element.wrapping_sub(1), 1.0), (element, -1.0)] {
            for (column, other) in [(element.wrapping_sub(1), 1.0), (element, -1.0)] {
                if row < N && column < N {
                    triplets.push((row, column, k * sign * other - 0.5 * c * other));
                }
            }
        }
    }
    triplets
}

/// Symmetric where it is stiff, with a drift where it is soft.
fn drifting(contrast: f64, element: usize) -> (f64, f64) {
    if element <= N / 2 { (contrast, 0.0) } else { (1.0, 0.3) }
}

fn symmetric(contrast: f64, element: usize) -> (f64, f64) {
    if element <= N / 2 { (contrast, 0.0) } else { (1.0, 0.0) }
}

fn matrix(size: usize, triplets: &[(usize, usize, f64)]) -> CsrMatrix {
    CsrMatrix::from_triplets(size, size, triplets).unwrap()
}

/// Gaussian elimination without pivoting on three diagonals, which is accurate entry by entry for these matrices,
/// whatever their contrast.
fn thomas(matrix: &CsrMatrix, b: &[f64]) -> Vec<f64> {
    let (mut pivots, mut x) = (matrix.diagonal(), b.to_vec());
    for i in 1..b.len() {
        let factor = matrix.get(i, i - 1) / pivots[i - 1];
        pivots[i] -= factor * matrix.get(i - 1, i);
        x[i] -= factor * x[i - 1];
    }
    for i in (0..b.len()).rev() {
        let after = if i + 1 < b.len() { matrix.get(i, i + 1) * x[i + 1] } else { 0.0 };
        x[i] = (x[i] - after) / pivots[i];
    }
    x
}

/// Largest error of a part relative to the part.
fn error(found: &[f64], exact: &[f64]) -> f64 {
    let largest = exact.iter().fold(0.0_f64, |sum, value| sum.max(value.abs()));
    found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

fn solvers() -> [(&'static str, Box<dyn LinearSolver>); 3] {
    [
        ("tangent", Box::new(TangentSolver::default())),
        ("LU", Box::new(LuSolver::default())),
        ("condensed", Box::new(CondensedSolver::default())),
    ]
}

/// Every half of the solution of the system and of its transposed is right in its own scale.
fn check_halves(name: &str, solver: &mut dyn LinearSolver, matrix: &CsrMatrix, contrast: f64) {
    let size = matrix.rows();
    let b = vec![1.0; size];
    solver.set_matrix(matrix.clone()).unwrap();
    for transpose in [Transpose::No, Transpose::Yes] {
        let exact =
            if transpose == Transpose::Yes { thomas(&matrix.transpose(), &b) } else { thomas(matrix, &b) };
        let found = solver.solve_with(&b, 0.0, transpose).unwrap().solution;
        for half in [0..size / 2, size / 2..size] {
            let error = error(&found[half.clone()], &exact[half.clone()]);
            assert!(error < 1e-9, "{name}, contrast {contrast:e}, {half:?} {transpose:?}: off by {error:e}");
        }
    }
}

#[test]
fn a_drift_in_the_soft_half_is_not_dropped_beside_a_stiff_one() {
    for contrast in CONTRASTS {
        for (name, mut solver) in solvers() {
            check_halves(name, &mut *solver, &matrix(N, &chain(drifting, contrast)), contrast);
            check_halves(name, &mut *solver, &matrix(N, &chain(symmetric, contrast)), contrast);
        }
    }
}

/// Two chains side by side, the second with a drift.
fn two_fields(first: f64, second: f64) -> CsrMatrix {
    let mut triplets = chain(|k, _| (k, 0.0), first);
    let beside = chain(|k, _| (k, 0.3 * k), second);
    triplets.extend(beside.iter().map(|(row, column, value)| (N + row, N + column, *value)));
    matrix(2 * N, &triplets)
}

#[test]
fn fields_of_different_units_are_right_each_in_its_own() {
    let pairs = CONTRASTS.map(|contrast| (1.0, contrast));
    for (first, second) in pairs.into_iter().chain([(2e11, 1e-9), (2e11, 50.0)]) {
        for (name, mut solver) in solvers() {
            check_halves(name, &mut *solver, &two_fields(first, second), second / first);
        }
    }
}

/// D A D with a unit of its own for the second half of the unknowns.
fn in_other_units(matrix: &CsrMatrix, unit: f64) -> CsrMatrix {
    let scale = |unknown: usize| if unknown < matrix.rows() / 2 { 1.0 } else { unit };
    let mut scaled = matrix.clone();
    for row in 0..matrix.rows() {
        let range = matrix.row_pointers()[row]..matrix.row_pointers()[row + 1];
        for place in range {
            scaled.values_mut()[place] *= scale(row) * scale(matrix.column_indices()[place] as usize);
        }
    }
    scaled
}

#[test]
fn coupled_fields_are_the_same_in_all_units() {
    // Each unknown of a field is tied to its partner: unsymmetric, symmetric, and as a saddle point.
    let tied = |there: f64, back: f64, own: f64| {
        let mut triplets = chain(|k, _| (k, 0.0), 1.0);
        triplets.extend(chain(|k, _| (k, 0.0), own).iter().map(|(i, j, value)| (N + i, N + j, *value)));
        triplets.extend((0..N).flat_map(|i| [(i, N + i, there), (N + i, i, back)]));
        matrix(2 * N, &triplets)
    };
    for plain in [tied(0.3, -0.2, 1.0), tied(0.1, 0.1, 1.0), tied(0.4, 0.4, -1.0), tied(1.0, 1.0, 0.0)] {
        let b: Vec<f64> = (0..2 * N).map(|i| 1.0 + 0.3 * (i as f64).sin()).collect();
        let mut direct = LuSolver::default();
        direct.set_matrix(plain.clone()).unwrap();
        let exact = direct.solve(&b, 0.0).unwrap().solution;
        for unit in CONTRASTS {
            let scaled: Vec<f64> = (0..2 * N).map(|i| if i < N { b[i] } else { b[i] * unit }).collect();
            for (name, mut solver) in solvers() {
                solver.set_matrix(in_other_units(&plain, unit)).unwrap();
                let mut found = solver.solve(&scaled, 0.0).unwrap().solution;
                found[N..].iter_mut().for_each(|value| *value *= unit);
                for half in [0..N, N..2 * N] {
                    let error = error(&found[half.clone()], &exact[half.clone()]);
                    assert!(error < 1e-9, "{name}, unit {unit:e}, {half:?}: off by {error:e}");
                }
            }
        }
    }
}

#[test]
fn changes_in_the_soft_half_are_no_rounding_of_the_stiff_one() {
    for contrast in CONTRASTS {
        let base = chain(symmetric, contrast);
        // Contact on three unknowns of each half.
        let changes =
            [5, 6, 7, N - 9, N - 8, N - 7].map(|i| (i, i - 1, if i < N / 2 { 0.4 * contrast } else { 0.4 }));
        let linear_part = Arc::new(matrix(N, &base));
        let whole = matrix(N, &[&base[..], &changes[..]].concat());
        let entry = |&(row, column, _): &(usize, usize, f64)| Entry {
            row: row as u32,
            column: column as u32,
            value: whole.get(row, column),
        };
        let entries: Vec<Entry> = changes.iter().map(entry).collect();
        let (b, mut solver) = (vec![1.0; N], CondensedSolver::default());
        solver.set_linear_part(&linear_part).unwrap();
        solver.set_changed(&linear_part, &entries).unwrap();
        for transpose in [Transpose::No, Transpose::Yes] {
            let exact =
                thomas(&if transpose == Transpose::Yes { whole.transpose() } else { whole.clone() }, &b);
            let found = solver.solve_with(&b, 0.0, transpose).unwrap().solution;
            for half in [0..N / 2, N / 2..N] {
                let error = error(&found[half.clone()], &exact[half.clone()]);
                assert!(error < 1e-9, "contrast {contrast:e}, {half:?}: off by {error:e}");
            }
        }
    }
}

#[test]
fn conjugate_gradients_and_minres_are_right_in_each_half_or_refuse() {
    let options = KrylovOptions { tolerance: 1e-13, ..KrylovOptions::default() };
    for contrast in CONTRASTS {
        let fields = two_fields_symmetric(contrast);
        for matrix in [matrix(N, &chain(symmetric, contrast)), fields] {
            let (b, size) = (vec![1.0; matrix.rows()], matrix.rows());
            let exact = thomas(&matrix, &b);
            let jacobi = Jacobi::of(&matrix).unwrap();
            for method in ["cg", "minres"] {
                let mut x = vec![0.0; size];
                let found = match method {
                    "cg" => cg(&matrix, &mut &jacobi, &b, &mut x, &options),
                    _ => minres(&matrix, &mut &jacobi, &b, &mut x, &options),
                };
                if let Err(refused) = found {
                    println!("{method}, contrast {contrast:e}: {refused}");
                    assert!(!(1e-4..=1e4).contains(&contrast), "{method} refuses a contrast of {contrast:e}");
                    continue;
                }
                for half in [0..size / 2, size / 2..size] {
                    let error = error(&x[half.clone()], &exact[half.clone()]);
                    assert!(error < 1e-9, "{method}, contrast {contrast:e}, {half:?}: off by {error:e}");
                }
            }
        }
    }
}

fn two_fields_symmetric(second: f64) -> CsrMatrix {
    let mut triplets = chain(|k, _| (k, 0.0), 1.0);
    let beside = chain(|k, _| (k, 0.0), second);
    triplets.extend(beside.iter().map(|(row, column, value)| (N + row, N + column, *value)));
    matrix(2 * N, &triplets)
}

#[test]
fn a_tolerance_of_the_norm_leaves_no_field_aside() {
    let matrix = two_fields(1.0, 1.0);
    let b: Vec<f64> = (0..2 * N).map(|i| if i < N { 1.0 } else { 1e-6 }).collect();
    let exact = thomas(&matrix, &b);
    for (name, mut solver) in solvers() {
        solver.set_matrix(matrix.clone()).unwrap();
        let found = solver.solve(&b, 1e-3).unwrap().solution;
        let error = error(&found[N..], &exact[N..]);
        assert!(error < 0.1, "{name}: off by {error:e}");
    }
}

#[test]
fn a_stiff_part_that_a_soft_one_holds_is_right_or_refused() {
    // The condition is the contrast times N²: in between, rounding of the entries moves the solution by more than 1e-9.
    for (contrast, right) in [(1e2, true), (1e16, false)] {
        let floating = |contrast, element| match element {
            0 => (0.0, 0.0),
            1..=20 => (contrast, 0.0),
            _ => (1.0, 0.3),
        };
        let matrix = matrix(N, &chain(floating, contrast));
        for (name, mut solver) in solvers() {
            let found = solver.set_matrix(matrix.clone()).and_then(|()| solver.solve(&[1.0; N], 0.0));
            match found {
                Ok(found) => {
                    let error = error(&found.solution, &thomas(&matrix, &[1.0; N]));
                    assert!(right && error < 1e-9, "{name}, contrast {contrast:e}: off by {error:e}");
                }
                Err(error) => {
                    assert!(!right, "{name}: {error}");
                    let said = error.to_string();
                    assert!(said.contains("singular") || said.contains("ill-conditioned"), "{name}: {said}");
                }
            }
        }
    }
}

#[test]
fn an_ill_conditioned_matrix_is_not_called_singular() {
    let hilbert = |n: usize| {
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        matrix(n, &pairs.map(|(i, j)| (i, j, 1.0 / (i + j + 1) as f64)).collect::<Vec<_>>())
    };
    for n in [6, 8] {
        let (hilbert, mut solver) = (hilbert(n), TangentSolver::default());
        let b = hilbert.multiply(&vec![1.0; n]).unwrap();
        solver.set_matrix(hilbert).unwrap();
        // The condition of order 8 is 1.5e10.
        assert!(error(&solver.solve(&b, 0.0).unwrap().solution, &vec![1.0; n]) < 1e-5);
    }
    let nearly = |more: f64| matrix(2, &[(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0 + more)]);
    for matrix in [nearly(1e-13), nearly(-1e-13)] {
        let mut solver = TangentSolver::default();
        let found = solver.set_matrix(matrix).and_then(|()| solver.solve(&[1.0, 2.0], 0.0)).unwrap_err();
        let SolverError::LinearAlgebra(LinearAlgebraError::IllConditioned { condition, .. }) = found else {
            panic!("{found}");
        };
        assert!((1e12..1e15).contains(&condition), "{condition:e}");
    }
}
