//! Bounded problems against all active sets, one after the other.

use super::*;
use crate::bounds::Side;

/// R(u) = A u + c u³ − f: the gradient of a convex potential where A is symmetric.
#[derive(Clone)]
struct Small {
    a: Vec<Vec<f64>>,
    cubes: f64,
    f: Vec<f64>,
}

impl NonlinearProblem for Small {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let row = |i: usize| self.a[i].iter().zip(u).map(|(a, u)| a * u).sum::<f64>();
        Ok((0..u.len()).map(|i| row(i) + self.cubes * u[i].powi(3) - self.f[i]).collect())
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let n = u.len();
        let entry =
            |i: usize, j: usize| self.a[i][j] + if i == j { 3.0 * self.cubes * u[i].powi(2) } else { 0.0 };
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let triplets: Vec<_> = all.map(|(i, j)| (i, j, entry(i, j))).collect();
        Ok(CsrMatrix::from_triplets(n, n, &triplets).unwrap().into())
    }
}

/// Numbers in [−1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn numbers(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// B Bᵀ + shift, which is symmetric and positive definite, with entries of both signs.
fn definite(random: &mut Random, n: usize, shift: f64) -> Vec<Vec<f64>> {
    let b: Vec<Vec<f64>> = (0..n).map(|_| random.numbers(n)).collect();
    let product = |i: usize, j: usize| b[i].iter().zip(&b[j]).map(|(x, y)| x * y).sum::<f64>();
    let entry = |i: usize, j: usize| product(i, j) + if i == j { shift } else { 0.0 };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

fn random_bounds(random: &mut Random, n: usize) -> UnknownBounds {
    let (mut lower, mut upper) = (vec![], vec![]);
    for _ in 0..n {
        let (middle, half) = (0.5 * random.next(), 0.3 * random.next().abs());
        let (no_lower, no_upper) = (random.next() > 0.6, random.next() > 0.6);
        lower.push(if no_lower { f64::NEG_INFINITY } else { middle - half });
        upper.push(if no_upper { f64::INFINITY } else { middle + half });
    }
    UnknownBounds { lower, upper }
}

/// Solves a dense system by elimination with pivots.
fn dense(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let above = a[k].clone();
            (k..n).for_each(|j| a[i][j] -= factor * above[j]);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - rest) / a[k][k];
    }
    b
}

/// All solutions of a linear problem, by the solution of one system per active set.
fn by_enumeration(problem: &Small, bounds: &UnknownBounds) -> Vec<Vec<f64>> {
    let n = problem.f.len();
    let mut found = vec![];
    for number in 0..3_usize.pow(n as u32) {
        let side = |i: usize| (number / 3_usize.pow(i as u32)) % 3;
        let (mut a, mut b) = (problem.a.clone(), problem.f.clone());
        for i in (0..n).filter(|i| side(*i) > 0) {
            a[i] = vec![0.0; n];
            (a[i][i], b[i]) = (1.0, if side(i) == 1 { bounds.lower[i] } else { bounds.upper[i] });
        }
        if b.iter().any(|value| !value.is_finite()) {
            continue;
        }
        let u = dense(a, b);
        let residual = problem.clone().residual(&u).unwrap();
        let holds = |i: usize| match side(i) {
            0 => u[i] >= bounds.lower[i] && u[i] <= bounds.upper[i],
            1 => residual[i] >= 0.0,
            _ => residual[i] <= 0.0,
        };
        if (0..n).all(holds) {
            found.push(u);
        }
    }
    found
}

fn solve(
    problem: &Small,
    bounds: &UnknownBounds,
    line_search: LineSearch,
) -> Result<NewtonSolution, NewtonError> {
    let n = problem.f.len();
    let elimination = Elimination::new(n, &BTreeMap::new()).unwrap();
    let options = NewtonOptions { line_search, relative_tolerance: 1e-12, ..NewtonOptions::default() };
    let (start, mut solver) = (Start::at(vec![0.0; n]), TangentSolver::default());
    newton_bounded(&mut problem.clone(), elimination, Some(bounds), start, &mut solver, &options, &mut |_| ())
}

/// The largest violation of the Karush-Kuhn-Tucker conditions.
fn violation(problem: &Small, bounds: &UnknownBounds, u: &[f64]) -> f64 {
    let residual = problem.clone().residual(u).unwrap();
    let of = |i: usize| {
        let (low, high) = (bounds.lower[i], bounds.upper[i]);
        // The projection of a step down the residual leaves the unknown in its place.
        ((u[i] - residual[i]).max(low).min(high) - u[i]).abs()
    };
    (0..u.len()).map(of).fold(0.0, f64::max)
}

#[test]
fn random_convex_problems_have_the_solution_of_all_active_sets() {
    let mut random = Random(7);
    let mut most = 0;
    for case in 0..400 {
        let n = 2 + case % 5;
        // Nearly singular ones make whole steps cycle.
        let shift = [1.0, 0.1, 1e-2, 1e-3][case % 4];
        let problem = Small { a: definite(&mut random, n, shift), cubes: 0.0, f: random.numbers(n) };
        let bounds = random_bounds(&mut random, n);
        let expected = by_enumeration(&problem, &bounds);
        assert!(!expected.is_empty());
        for line_search in [LineSearch::Off, LineSearch::OnPotential] {
            let solution =
                solve(&problem, &bounds, line_search).unwrap_or_else(|error| panic!("{case}: {error:?}"));
            most = most.max(solution.iterations());
            let distance =
                |u: &Vec<f64>| u.iter().zip(&solution.u).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(expected.iter().map(distance).fold(f64::INFINITY, f64::min) < 1e-9 / shift, "{case}");
            assert!(violation(&problem, &bounds, &solution.u) < 1e-11, "{case}");
            for held in &solution.held {
                let is_lower = held.side == Side::Lower;
                assert!(if is_lower { held.reaction > 0.0 } else { held.reaction < 0.0 } || held.is_weak);
                let bound = if is_lower { &bounds.lower } else { &bounds.upper }[held.unknown];
                assert_eq!(solution.u[held.unknown], bound, "{case}");
            }
        }
    }
    assert!(most < 40, "{most}");
}

#[test]
fn whole_steps_that_cycle_go_on_along_the_potential() {
    // Of Curtis, Han and Robinson 2015 (Comput. Optim. Appl. 60), Section 2: symmetric, positive definite, and whole steps from 0 hold {3}, {2}, {1, 2, 3}
    // in turn, for ever.
    let a = vec![vec![4.0, 5.0, -5.0], vec![5.0, 9.0, -5.0], vec![-5.0, -5.0, 7.0]];
    let problem = Small { a, cubes: 0.0, f: vec![-2.0, -1.0, 3.0] };
    let bounds = UnknownBounds { lower: vec![f64::NEG_INFINITY; 3], upper: vec![0.0; 3] };
    let expected = by_enumeration(&problem, &bounds);
    let solution = solve(&problem, &bounds, LineSearch::Off).unwrap();
    assert!(violation(&problem, &bounds, &solution.u) < 1e-13);
    let difference = solution.u.iter().zip(&expected[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-13);
    let held: Vec<usize> = solution.history.iter().filter_map(|step| step.held_unknowns).collect();
    assert_eq!(held[..3], [1, 1, 3], "{held:?}");
}

#[test]
fn random_nonlinear_convex_problems_meet_the_conditions_in_every_way() {
    let mut random = Random(3);
    let mut by_residual = 0;
    for case in 0..300 {
        let n = 2 + case % 6;
        let shift = [1.0, 0.1, 1e-2][case % 3];
        let f = random.numbers(n).iter().map(|f| 10.0 * f).collect();
        let problem = Small { a: definite(&mut random, n, shift), cubes: 1.0, f };
        let bounds = random_bounds(&mut random, n);
        for line_search in [LineSearch::Off, LineSearch::OnPotential] {
            let solution = solve(&problem, &bounds, line_search)
                .unwrap_or_else(|error| panic!("{case} {line_search:?}: {error:?}"));
            let off = violation(&problem, &bounds, &solution.u);
            assert!(off < 1e-10, "{case} {line_search:?}: {off:e}");
        }
        // A search on the residual may end where it finds no step, but not at a wrong place.
        if let Ok(solution) = solve(&problem, &bounds, LineSearch::OnResidual) {
            let off = violation(&problem, &bounds, &solution.u);
            assert!(off < 1e-10, "{case} on the residual: {off:e}");
            by_residual += 1;
        }
    }
    assert!(by_residual > 250, "{by_residual}");
}

#[test]
fn an_unsymmetric_cycle_is_named() {
    // Ben Gharbia and Gilbert 2012: Newton-min cycles through {1}, {2}, {3} for 1 < c: M = [1 0 c; c 1 0; 0 c 1], M u − 1 ⟂ u ≥ 0.
    let c = 1.5;
    let a = vec![vec![1.0, 0.0, c], vec![c, 1.0, 0.0], vec![0.0, c, 1.0]];
    let problem = Small { a, cubes: 0.0, f: vec![1.0; 3] };
    let bounds = UnknownBounds { lower: vec![0.0; 3], upper: vec![f64::INFINITY; 3] };
    let elimination = Elimination::new(3, &BTreeMap::new()).unwrap();
    let start = Start::at(vec![1.0, 0.0, 0.0]);
    let (options, mut solver) = (NewtonOptions::default(), TangentSolver::default());
    let found = newton_bounded(
        &mut problem.clone(),
        elimination,
        Some(&bounds),
        start,
        &mut solver,
        &options,
        &mut |_| (),
    );
    let why = found.map(|solution| solution.u).map_err(|error| error.why);
    assert!(
        matches!(&why, Err(NewtonFailure::BoundsCycle { period: 3, unknowns, .. }) if !unknowns.is_empty()),
        "{why:?}"
    );
}

#[test]
fn bounds_that_cannot_be_kept_are_refused() {
    let problem = Small { a: vec![vec![1.0, 0.0], vec![0.0, 1.0]], cubes: 0.0, f: vec![1.0; 2] };
    let refused = |lower: [f64; 2], upper: [f64; 2], prescribed: &[(usize, f64)]| {
        let elimination = Elimination::new(2, &prescribed.iter().copied().collect()).unwrap();
        let bounds = UnknownBounds { lower: lower.to_vec(), upper: upper.to_vec() };
        let (options, mut solver) = (NewtonOptions::default(), TangentSolver::default());
        let start = Start::at(vec![0.0; 2]);
        let mut problem = problem.clone();
        let told = &mut |_: &NewtonStep| ();
        match newton_bounded(&mut problem, elimination, Some(&bounds), start, &mut solver, &options, told) {
            Err(NewtonError { why: NewtonFailure::Bounds { unknown, why }, .. }) => Some((unknown, why)),
            _ => None,
        }
    };
    let inf = f64::INFINITY;
    assert_eq!(
        refused([0.0, 2.0], [1.0, 1.0], &[]),
        Some((1, BoundFailure::Empty { lower: 2.0, upper: 1.0 }))
    );
    let prescribed = BoundFailure::Prescribed { value: 3.0, lower: 0.0, upper: 1.0 };
    assert_eq!(refused([0.0; 2], [1.0; 2], &[(1, 3.0)]), Some((1, prescribed)));
    assert!(matches!(refused([0.0, f64::NAN], [1.0; 2], &[]), Some((1, BoundFailure::NotANumber { .. }))));
    assert!(matches!(refused([inf, 0.0], [inf; 2], &[]), Some((0, BoundFailure::NotANumber { .. }))));
    assert_eq!(refused([0.5; 2], [0.5; 2], &[]), None);
    assert_eq!(refused([0.0; 2], [1.0; 2], &[(1, 1.0)]), None);
    // A formula for the bound that rounds, as sin π.
    assert_eq!(refused([-1.0, 1.2e-16], [1.0; 2], &[(1, 0.0)]), None);
}
