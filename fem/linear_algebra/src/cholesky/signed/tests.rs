//! Factors with signs: products, inertia, bits, and solutions compared with those by LU.

use faer::linalg::solvers::Solve;

use super::*;
use crate::spectrum::irregular_from;
use crate::{LuFactor, Ordering, Transpose};

/// A grid of m × m nodes with two unknowns each, and multipliers.
struct Saddle {
    triplets: Vec<(usize, usize, f64)>,
    size: usize,
    multipliers: usize,
}

impl Saddle {
    /// Stiffness of springs between neighbours, and to the ground where x = 0.
    fn springs(m: usize, ground: f64) -> Self {
        let mut triplets = vec![];
        let unknown = |x: usize, y: usize, c: usize| 2 * (y * m + x) + c;
        for y in 0..m {
            for x in 0..m {
                for c in 0..2 {
                    let a = unknown(x, y, c);
                    triplets.push((a, a, if x == 0 { ground } else { 0.0 }));
                    let near = [
                        (x + 1 < m).then(|| unknown(x + 1, y, c)),
                        (y + 1 < m).then(|| unknown(x, y + 1, c)),
                    ];
                    for b in near.into_iter().flatten() {
                        let k = 1.0 + 0.5 * ((a * 7 + b) as f64).sin();
                        triplets.extend([(a, a, k), (b, b, k), (a, b, -k), (b, a, -k)]);
                    }
                }
            }
        }
        Saddle { triplets, size: 2 * m * m, multipliers: 0 }
    }

    /// One more multiplier, which constrains a sum of unknowns.
    fn constrain(&mut self, terms: impl IntoIterator<Item = (usize, f64)>) {
        for (unknown, factor) in terms {
            self.triplets.extend([(unknown, self.size, factor), (self.size, unknown, factor)]);
        }
        (self.size, self.multipliers) = (self.size + 1, self.multipliers + 1);
    }

    /// Multipliers that make differences over pairs of cells vanish, as pressures of a coarser mesh do.
    fn incompressible(mut self, m: usize) -> Self {
        for y in (0..m - 2).step_by(2) {
            for x in (0..m - 2).step_by(2) {
                let at = |dx: usize, dy: usize, c: usize| 2 * ((y + dy) * m + x + dx) + c;
                let terms =
                    [(at(2, 1, 0), 1.0), (at(0, 1, 0), -1.0), (at(1, 2, 1), 1.0), (at(1, 0, 1), -1.0)];
                self.constrain(terms);
            }
        }
        self
    }

    fn matrix(&self) -> CsrMatrix {
        let matrix = CsrMatrix::from_triplets(self.size, self.size, &self.triplets).unwrap();
        matrix.with_whole_diagonal().unwrap()
    }
}

/// Random saddle points of bodies that meet in an interface: dense blocks of each body and of the interface, with multipliers of one body
/// each, and the number of multipliers. Every third unknown is a multiplier, so that wide supernodes have both signs everywhere.
fn meeting_bodies(bodies: &[usize], interface: usize, seed: u64) -> (CsrMatrix, usize) {
    let sizes: Vec<usize> = bodies.iter().copied().chain([interface]).collect();
    let body_of: Vec<usize> = (0..).zip(&sizes).flat_map(|(body, size)| vec![body; *size]).collect();
    let size = body_of.len();
    let is_multiplier = |unknown: usize| unknown % 3 == 2;
    let mut numbers = irregular_from(seed, size * size);
    let (mut triplets, mut diagonal) = (vec![], vec![1.0; size]);
    for row in 0..size {
        for column in 0..row {
            let meet = body_of[row] == body_of[column] || body_of[row] == bodies.len();
            let value = numbers.next().unwrap();
            let multipliers = usize::from(is_multiplier(row)) + usize::from(is_multiplier(column));
            // Multipliers are of one body, and not coupled with each other.
            if !meet || multipliers == 2 || multipliers == 1 && body_of[row] != body_of[column] {
                continue;
            }
            triplets.extend([(row, column, value), (column, row, value)]);
            if multipliers == 0 {
                for unknown in [row, column] {
                    diagonal[unknown] += value.abs();
                }
            }
        }
    }
    let of_bodies = (0..size).map(|k| (k, k, if is_multiplier(k) { 0.0 } else { diagonal[k] }));
    triplets.extend(of_bodies);
    let matrix = CsrMatrix::from_triplets(size, size, &triplets).unwrap().with_whole_diagonal().unwrap();
    (matrix, (0..size).filter(|unknown| is_multiplier(*unknown)).count())
}

fn shuffled(size: usize, seed: u64) -> Ordering {
    let mut order: Vec<u32> = (0..size as u32).collect();
    let keys: Vec<f64> = irregular_from(seed, size).collect();
    order.sort_by(|a, b| keys[*a as usize].total_cmp(&keys[*b as usize]));
    Ordering::Given(order)
}

fn orderings(size: usize) -> Vec<Ordering> {
    let natural: Vec<u32> = (0..size as u32).collect();
    let backwards = natural.iter().rev().copied().collect();
    vec![
        Ordering::MinimumDegree,
        Ordering::NestedDissection,
        Ordering::Given(natural),
        Ordering::Given(backwards),
        shuffled(size, 3),
        shuffled(size, 77),
    ]
}

fn factor(matrix: &CsrMatrix, ordering: &Ordering, threads: usize) -> SymmetricFactor {
    let analysis = Arc::new(Analysis::new(matrix.pattern(), ordering).unwrap());
    SymmetricFactor::signed_on(Threads::new(threads), &analysis, matrix, vec![]).unwrap()
}

/// Compares a solution with that by LU, and the inertia.
fn check(matrix: &CsrMatrix, ordering: &Ordering, negative: usize, what: &str) -> SymmetricFactor {
    let factor = factor(matrix, ordering, 1);
    let remainder = factor.remainder(matrix).unwrap();
    assert!(remainder.rate < 0.1, "{what}: {remainder:?}");
    let b: Vec<f64> = irregular(matrix.rows()).collect();
    let found = factor.solve_refined(matrix, &b, 20).unwrap();
    assert!(found.backward_error < 1e-12, "{what}: {found:?}");
    let lu = LuFactor::new(matrix, None).unwrap();
    let mut x = b.clone();
    lu.solve_in_place(&mut x, Transpose::No).unwrap();
    let mut rest = matrix.multiply(&x).unwrap();
    rest.iter_mut().zip(&b).for_each(|(rest, b)| *rest = b - *rest);
    lu.solve_in_place(&mut rest, Transpose::No).unwrap();
    x.iter_mut().zip(&rest).for_each(|(x, rest)| *x += rest);
    let difference: Vec<f64> = x.iter().zip(&found.solution).map(|(a, b)| a - b).collect();
    let relative = norm(&difference) / norm(&x);
    assert!(relative < 1e-12, "{what}: {relative:e} after {} steps", found.steps);
    assert_eq!(factor.negative_eigenvalues(), negative, "{what}");
    factor
}

#[test]
fn saddle_points_in_all_orders_agree_with_lu() {
    for m in [5, 12, 25] {
        let saddle = Saddle::springs(m, 2.0).incompressible(m);
        let matrix = saddle.matrix();
        for (number, ordering) in orderings(matrix.rows()).iter().enumerate() {
            check(&matrix, ordering, saddle.multipliers, &format!("{m}, order {number}"));
        }
    }
}

#[test]
fn floating_bodies_held_by_multipliers_agree_with_lu() {
    let m = 13;
    // Two sums over all nodes.
    let mut sums = Saddle::springs(m, 0.0).incompressible(m);
    for c in 0..2 {
        sums.constrain((0..m * m).map(|node| (2 * node + c, 1.0 / (m * m) as f64)));
    }
    // One multiplier for each unknown of a side.
    let mut side = Saddle::springs(m, 0.0);
    for node in 0..m {
        for c in 0..2 {
            side.constrain([(2 * node * m + c, 1.0)]);
        }
    }
    for (saddle, what) in [(sums, "sums"), (side, "side")] {
        let matrix = saddle.matrix();
        for ordering in orderings(matrix.rows()) {
            let factor = check(&matrix, &ordering, saddle.multipliers, what);
            assert!(factor.replaced_pivots() <= 2 + saddle.multipliers, "{what}");
        }
    }
}

/// A random quasi-definite matrix [K Bᵀ; B −C] with rows and columns in random places.
fn quasi_definite(size: usize, seed: u64) -> CsrMatrix {
    let values: Vec<f64> = irregular_from(seed, 20 * size).collect();
    let mut next = values.iter().copied().cycle();
    let mut number = || next.next().unwrap_or(0.0);
    let signs: Vec<f64> = (0..size).map(|_| if number() > 0.3 { -1.0 } else { 1.0 }).collect();
    let mut triplets = vec![];
    for row in 0..size {
        triplets.push((row, row, signs[row] * (4.0 + number())));
        for _ in 0..4 {
            let column = ((number().abs() * size as f64) as usize).min(size - 1);
            let value = number();
            // Blocks of one sign are diagonally dominant; others are arbitrary.
            if signs[row] != signs[column] {
                triplets.extend([(row, column, 3.0 * value), (column, row, 3.0 * value)]);
            } else if row != column {
                triplets.extend([(row, column, value), (column, row, value)]);
                triplets.extend([row, column].map(|k| (k, k, signs[k] * value.abs())));
            }
        }
    }
    CsrMatrix::from_triplets(size, size, &triplets).unwrap()
}

#[test]
fn random_quasi_definite_matrices_have_the_inertia_of_their_diagonals() {
    for seed in 1..25_u64 {
        let matrix = quasi_definite(20 + 7 * seed as usize, seed);
        let negative = matrix.diagonal().iter().filter(|value| **value < 0.0).count();
        for ordering in orderings(matrix.rows()) {
            let factor = check(&matrix, &ordering, negative, "quasi-definite");
            assert_eq!((factor.replaced_pivots(), factor.turned_pivots(&matrix)), (0, 0));
        }
    }
}

/// Below other supernodes there are some of several panels, which are units of their own.
#[test]
fn random_saddle_points_with_wide_supernodes_agree_with_dense_lu_on_any_number_of_threads() {
    for (seed, bodies, interface) in
        [(1, &[260, 70][..], 90), (2, &[200, 210], 150), (3, &[130, 65, 300], 70), (4, &[190], 200)]
    {
        let (matrix, negative) = meeting_bodies(bodies, interface, seed);
        let size = matrix.rows();
        let b: Vec<f64> = irregular(size).collect();
        let dense = faer::Mat::from_fn(size, size, |i, j| matrix.get(i, j)).partial_piv_lu();
        let mut expected = faer::Mat::from_fn(size, 1, |i, _| b[i]);
        dense.solve_in_place(&mut expected);
        let natural = Ordering::Given((0..size as u32).collect());
        for ordering in
            [natural.clone(), Ordering::MinimumDegree, Ordering::NestedDissection, shuffled(size, seed)]
        {
            let found = |threads| {
                let factor = factor(&matrix, &ordering, threads);
                assert_eq!(factor.negative_eigenvalues(), negative, "{seed}, {ordering:?}");
                let units = &factor.analysis().elimination().units;
                let is_wide = units.iter().any(|unit| unit.panels > 1 && unit.parent.is_some());
                assert!(is_wide || ordering != natural, "{seed}: a wide unit below others");
                let relative = |x: &[f64]| {
                    let difference: Vec<f64> =
                        x.iter().enumerate().map(|(i, x)| x - expected[(i, 0)]).collect();
                    norm(&difference) / norm(x)
                };
                let mut x = b.clone();
                factor.solve_in_place(&mut x).unwrap();
                // Of pivots that vanish, substitutes of 1e-8 enlarged by what follows from them.
                let limit = if factor.replaced_pivots() == 0 { 1e-10 } else { 1e-5 };
                assert!(relative(&x) < limit, "{seed}, {ordering:?}: {:e}", relative(&x));
                let refined = factor.solve_refined(&matrix, &b, 20).unwrap().solution;
                assert!(relative(&refined) < 1e-12, "{seed}, {ordering:?}: {:e}", relative(&refined));
                let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
                (bits(factor.values()), bits(&x))
            };
            let one = found(1);
            for threads in [2, 3, 7, 16] {
                assert!(found(threads) == one, "{seed}, {threads} threads");
            }
        }
    }
}

/// L S Lᵀ is the matrix, through all widths of supernodes and tiles.
#[test]
fn a_factor_with_signs_multiplies_to_the_matrix_with_the_same_bits_on_all_threads() {
    let dense = |size: usize| {
        let mut triplets = vec![];
        for row in 0..size {
            let sign = if row % 5 < 2 { -1.0 } else { 1.0 };
            triplets.push((row, row, sign * (size as f64 + (row as f64).cos())));
            for column in 0..row {
                let value = ((row * 7 + column * 3) as f64).sin();
                triplets.extend([(row, column, value), (column, row, value)]);
            }
        }
        CsrMatrix::from_triplets(size, size, &triplets).unwrap()
    };
    let cases = [
        (dense(3), Ordering::MinimumDegree),
        (dense(61), Ordering::MinimumDegree),
        (dense(331), Ordering::MinimumDegree),
        (quasi_definite(700, 5), Ordering::MinimumDegree),
        (quasi_definite(700, 6), Ordering::NestedDissection),
        (Saddle::springs(32, 1.0).incompressible(32).matrix(), Ordering::NestedDissection),
        (Saddle::springs(20, 1.0).incompressible(20).matrix(), shuffled(800 + 81, 9)),
        (meeting_bodies(&[130, 65, 300], 70, 3).0, Ordering::Given((0..565).collect())),
    ];
    for (matrix, ordering) in cases {
        let factor = factor(&matrix, &ordering, 1);
        let size = matrix.rows();
        let lower = factor.trailing_block(size);
        let order = &factor.analysis().order;
        // Rounding is relative to the products, which pivots that were replaced make large.
        // All rows of small matrices, and some of large ones.
        for i in (0..size).step_by(1 + size / 100) {
            for j in 0..=i {
                let (mut sum, mut terms) = (0.0, 0.0);
                for k in 0..=j {
                    let product = lower[(i, k)] * lower[(j, k)];
                    (sum, terms) = (sum + product * 1.0_f64.copysign(lower[(k, k)]), terms + product.abs());
                }
                let entry = matrix.get(order[i] as usize, order[j] as usize);
                let limit = 1e-14 * terms + if i == j { 1e-7 } else { 0.0 };
                assert!((sum - entry).abs() <= limit, "{size} ({i}, {j}): {sum} is not {entry}");
            }
        }
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let one = bits(factor.values());
        for threads in [2, 3, 7, 16] {
            assert!(bits(self::factor(&matrix, &ordering, threads).values()) == one, "{size} {threads}");
        }
    }
}

#[test]
fn singular_saddle_points_have_a_rate_of_one() {
    let m = 9;
    // Two equal constraints; a body that nothing holds in one direction; a multiplier of nothing is a zero row.
    let mut twice = Saddle::springs(m, 1.0).incompressible(m);
    twice.constrain([(7, 1.0), (12, 2.0)]);
    twice.constrain([(7, 1.0), (12, 2.0)]);
    let mut floating = Saddle::springs(m, 0.0).incompressible(m);
    floating.constrain((0..m * m).map(|node| (2 * node, 1.0)));
    for (saddle, what) in [(twice, "twice"), (floating, "floating")] {
        let matrix = saddle.matrix();
        for ordering in orderings(matrix.rows()) {
            let remainder = factor(&matrix, &ordering, 1).remainder(&matrix).unwrap();
            assert!(remainder.rate > 0.9 || remainder.inverse_norm > 1e12, "{what}: {remainder:?}");
        }
    }
    let mut empty = Saddle::springs(3, 1.0);
    empty.constrain([]);
    let matrix = empty.matrix();
    let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::MinimumDegree).unwrap());
    let found = SymmetricFactor::signed_on(Threads::ONE, &analysis, &matrix, vec![]);
    assert!(matches!(found, Err(LinearAlgebraError::Singular { unknown: 18, .. })), "{found:?}");
}

#[test]
fn a_truly_indefinite_matrix_turns_pivots() {
    let matrix =
        CsrMatrix::from_triplets(2, 2, &[(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 1.0)]).unwrap();
    let factor = factor(&matrix, &Ordering::MinimumDegree, 1);
    assert_eq!((factor.negative_eigenvalues(), factor.turned_pivots(&matrix)), (1, 1));
    let found = factor.solve_refined(&matrix, &[5.0, 4.0], 3).unwrap().solution;
    assert!((found[0] - 1.0).abs() < 1e-15 && (found[1] - 2.0).abs() < 1e-15, "{found:?}");
}
