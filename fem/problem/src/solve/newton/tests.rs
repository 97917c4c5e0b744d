//! Newton on membranes above an elastic bed.

mod bounds;
mod failures;
mod few_unknowns;
mod related_unknowns;
mod watchdog;

use super::convergence::Fields;
use super::*;
use crate::assemble::AssemblyError;
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError};
use crate::solve::{SolverError, TangentSolver, TangentSolverOptions};

/// −u'' = f on (0, 1) with an elastic bed below ψ. With p_i = [u_i − ψ]₋,
/// R_i = (2 u_i − u_{i−1} − u_{i+1}) / h − h f − h k p_i + h c p_{i−1}; the drag c makes it unsymmetric.
struct Membrane {
    n: usize,
    f: f64,
    stiffness: f64,
    drag: f64,
    obstacle: f64,
}

impl Membrane {
    fn h(&self) -> f64 {
        1.0 / self.n as f64
    }

    fn contact(&self, u: &[f64]) -> Vec<f64> {
        u.iter().map(|value| (self.obstacle - value).max(0.0)).collect()
    }
}

impl NonlinearProblem for Membrane {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let (h, contact) = (self.h(), self.contact(u));
        Ok((0..=self.n)
            .map(|i| {
                if i == 0 || i == self.n {
                    return 12345.0; // prescribed rows must not matter
                }
                (2.0 * u[i] - u[i - 1] - u[i + 1]) / h - h * self.f - h * self.stiffness * contact[i]
                    + h * self.drag * contact[i - 1]
            })
            .collect())
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let (h, contact) = (self.h(), self.contact(u));
        let active = |i: usize| if contact[i] > 0.0 { h } else { 0.0 };
        let mut triplets = vec![(0, 0, 1.0), (self.n, self.n, 1.0)];
        for i in 1..self.n {
            triplets.push((i, i, 2.0 / h + self.stiffness * active(i)));
            triplets.push((i, i - 1, -1.0 / h - self.drag * active(i - 1)));
            triplets.push((i, i + 1, -1.0 / h));
        }
        triplets.extend([(0, 1, 0.0), (self.n, self.n - 1, 0.0)]);
        Ok(CsrMatrix::from_triplets(self.n + 1, self.n + 1, &triplets).unwrap().into())
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        let contact = self.contact(u);
        Ok(Some(ActivePoints::from_numbers((0..=self.n).filter(|&i| contact[i] > 0.0))))
    }
}

fn ends(n: usize) -> BTreeMap<usize, f64> {
    BTreeMap::from([(0, 0.0), (n, 0.0)])
}

#[test]
fn an_obstacle_problem_meets_its_closed_form() {
    // −u'' = −8 above ψ = −1/4: u touches at distance a = √(2 · ¼ / 8) = ¼ from the ends, and outside
    // the contact zone u = 4 (x − a)² − ¼. Quadratics are exact in finite differences.
    let n = 64;
    let mut problem = Membrane { n, f: -8.0, stiffness: 1e6, drag: 0.0, obstacle: -0.25 };
    let mut solver = TangentSolver::default();
    let mut seen = Vec::new();
    let solution = newton(
        &mut problem,
        &ends(n),
        vec![0.0; n + 1],
        &mut solver,
        &NewtonOptions::default(),
        &mut |step| seen.push(step.clone()),
    )
    .unwrap();
    for (i, value) in solution.u.iter().enumerate() {
        let x = i as f64 / n as f64;
        let from_end = x.min(1.0 - x);
        let exact = if from_end < 0.25 { 4.0 * (from_end - 0.25).powi(2) - 0.25 } else { -0.25 };
        // The bed yields by f / stiffness.
        assert!((value - exact).abs() < 1.01 * 8e-6, "u({x}) = {value}, expected {exact}");
    }
    assert_eq!(seen, solution.history);
    assert_eq!(seen[0].step, None);
    let last = seen.last().unwrap();
    assert!(last.relative_residual <= 1e-10 && last.active_set_changed == Some(false));
    assert_eq!(last.linear_iterations, Some(0));
    // Contact on [¼, ¾]: 33 nodes; those on the rim carry half a node's load or none.
    assert!((31..=33).contains(&last.active_points.unwrap()));
    assert!(solution.iterations() <= 15, "{} iterations", solution.iterations());
    // A stiffer bed makes the tolerance unreachable: h k ε is 1e-9 of the load. What is left is found to be rounding of the
    // forces that balance, at once.
    problem.stiffness = 1e9;
    let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
    let stiff = newton(&mut problem, &ends(n), vec![0.0; n + 1], &mut solver, &options, &mut |_| ()).unwrap();
    let last = stiff.history.last().unwrap();
    assert!(stiff.iterations() <= 17 && (1e-12..1e-8).contains(&last.relative_residual), "{last}");
    assert!(stiff.u[16..=48].iter().all(|value| (value + 0.25).abs() < 1.01 * 8e-9));
}

#[test]
fn an_unsymmetric_problem_is_solved_to_rounding_with_few_factorisations() {
    let n = 64;
    let mut problem = Membrane { n, f: -8.0, stiffness: 2000.0, drag: 500.0, obstacle: -0.25 };
    let mut solver = TangentSolver::new(TangentSolverOptions::default());
    let run = |problem: &mut Membrane, solver: &mut TangentSolver| {
        newton(problem, &ends(n), vec![0.0; n + 1], solver, &NewtonOptions::default(), &mut |_| ()).unwrap()
    };
    let solution = run(&mut problem, &mut solver);
    let residual = problem.residual(&solution.u).unwrap();
    assert!(norm(&residual[1..n]) < 1e-11 * solution.history[0].residual);
    assert!(solution.history.iter().any(|step| step.linear_iterations > Some(0)));
    assert!(solver.report().factorisations <= solution.iterations());
    // An affine problem takes one step: the same obstacle far away.
    problem.obstacle = -100.0;
    let straight = run(&mut problem, &mut solver);
    assert_eq!(straight.iterations(), 1);
    for (i, value) in straight.u.iter().enumerate() {
        let x = i as f64 / n as f64;
        assert!((value + 4.0 * x * (1.0 - x)).abs() < 1e-12);
    }
}

/// Back to u = 0 each step leaves the rounding of the one before. The residual falls faster than u: stiff directions, which it
/// weighs, are solved more exactly than soft ones.
#[test]
fn a_step_back_to_zero_ends() {
    let n = 4096;
    let mut problem = Membrane { n, f: 0.0, stiffness: 1.0, drag: 1.0, obstacle: -100.0 };
    let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
    let rough = |i: usize| (7.0 * i as f64).sin() + (3.0 * i as f64 / n as f64).sin();
    for start in [vec![1.0; n + 1], (0..=n).map(rough).collect()] {
        let mut solver = TangentSolver::default();
        let found = newton(&mut problem, &ends(n), start, &mut solver, &options, &mut |_| ()).unwrap();
        assert!(norm(&found.u) < 1e-14 && found.iterations() <= 8, "{} steps", found.iterations());
    }
}

#[test]
fn prescribed_values_are_imposed_and_reactions_returned() {
    let mut problem = Membrane { n: 4, f: 0.0, stiffness: 1.0, drag: 0.0, obstacle: -100.0 };
    let prescribed = BTreeMap::from([(0, 1.0), (4, 3.0)]);
    let mut solver = TangentSolver::default();
    let options = NewtonOptions::default();
    let run = |problem: &mut Membrane, solver: &mut TangentSolver, start: Vec<f64>| {
        newton(problem, &prescribed, start, solver, &options, &mut |_| ())
    };
    let solution = run(&mut problem, &mut solver, vec![0.0; 5]).unwrap();
    assert_eq!(solution.iterations(), 1);
    for (value, exact) in solution.u.iter().zip([1.0, 1.5, 2.0, 2.5, 3.0]) {
        assert!((value - exact).abs() < 1e-14);
    }
    assert_eq!(solution.residual[0], 12345.0);
    // Start at the solution: no step. A start of the wrong size is an error.
    let again = run(&mut problem, &mut solver, vec![1.0, 1.5, 2.0, 2.5, 3.0]).unwrap();
    assert_eq!(again.iterations(), 0);
    let error = run(&mut problem, &mut solver, vec![0.0; 3]).unwrap_err();
    assert!(matches!(error.why, NewtonFailure::Mismatch(_)));
}

/// A scalar function, given as (value, slope); active where u > 0.
struct Scalar<F: FnMut(f64) -> (f64, f64)>(F);

impl<F: FnMut(f64) -> (f64, f64)> NonlinearProblem for Scalar<F> {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        Ok(vec![(self.0)(u[0]).0])
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let matrix = CsrMatrix::from_triplets(1, 1, &[(0, 0, (self.0)(u[0]).1)]);
        Ok(matrix.map_err(AssemblyError::other)?.into())
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        Ok(Some(ActivePoints::from_numbers((u[0] > 0.0).then_some(0))))
    }
}

fn scalar(f: impl FnMut(f64) -> (f64, f64), start: f64) -> Result<NewtonSolution, NewtonError> {
    let mut solver = TangentSolver::default();
    let options = NewtonOptions { max_iterations: 8, ..NewtonOptions::default() };
    newton(&mut Scalar(f), &BTreeMap::new(), vec![start], &mut solver, &options, &mut |_| ())
}

#[test]
fn a_cycle_is_recognised() {
    // R(u) = u + 1 for u > 0 (root −1) and u − 1 for u ≤ 0 (root 1): Newton goes 1 → −1 → 1.
    let error = scalar(|u| if u > 0.0 { (u + 1.0, 1.0) } else { (u - 1.0, 1.0) }, 1.0).unwrap_err();
    assert!(matches!(error.why, NewtonFailure::Cycling { first: 0, period: 2 }), "{error}");
    assert_eq!(error.history.len(), 3);
    assert_eq!(error.u, [1.0]);
    // A curved law may come by the set of its start again, with a larger residual, and converge after all.
    let found = scalar(|u| (u.powi(3) - 2.0 * u + 2.0, 3.0 * u * u - 2.0), -0.39).unwrap();
    assert!((found.u[0] + 1.769_292_354_238_631).abs() < 1e-11, "{}", found.u[0]);
    assert!(found.history[3].residual > found.history[0].residual);
}

#[test]
fn failures_are_told_apart() {
    // R = arctan u diverges from |u| > 1.39; from 1.2 it converges.
    assert!(scalar(|u| (u.atan(), 1.0 / (1.0 + u * u)), 1.2).unwrap().u[0].abs() < 1e-10);
    let error = scalar(|u| (u * u, 2.0 * u), 1.0).unwrap_err(); // a double root: halving only
    assert!(matches!(error.why, NewtonFailure::NotConverged { iterations: 8 }));
    assert_eq!(error.history.len(), 9);
    let error = scalar(|u| (1.0 / u, 1.0), 0.0).unwrap_err();
    assert!(matches!(error.why, NewtonFailure::NotFinite));
    let error = scalar(|_| (1.0, 0.0), 0.0).unwrap_err();
    assert!(matches!(
        error.why,
        NewtonFailure::LinearSolver(SolverError::LinearAlgebra(LinearAlgebraError::Singular {
            unknown: 0,
            ..
        }))
    ));
}

#[test]
fn a_line_search_makes_a_hard_start_converge() {
    // R = arctan u has the convex potential u arctan u − ½ ln(1 + u²); whole steps from 3 overshoot more and more.
    let arctan = |u: f64| (u.atan(), 1.0 / (1.0 + u * u));
    assert!(scalar(arctan, 3.0).is_err());
    let searching = |line_search| NewtonOptions { line_search, ..NewtonOptions::default() };
    let mut solver = TangentSolver::default();
    let (none, options) = (BTreeMap::new(), searching(LineSearch::OnPotential));
    let mut seen = |_: &NewtonStep| ();
    let found = newton(&mut Scalar(arctan), &none, vec![3.0], &mut solver, &options, &mut seen).unwrap();
    assert!(found.u[0].abs() < 1e-9);
    assert!(found.history[1].damping.unwrap() < 1.0);
    assert_eq!(found.history[found.iterations()].damping, Some(1.0));
    let options_on_residual = searching(LineSearch::OnResidual);
    let found =
        newton(&mut Scalar(arctan), &none, vec![3.0], &mut solver, &options_on_residual, &mut seen).unwrap();
    assert!(found.u[0].abs() < 1e-9 && found.history[1].damping == Some(0.25));
    // Where whole steps serve, nothing changes.
    let n = 64;
    let mut membrane = Membrane { n, f: -8.0, stiffness: 1e6, drag: 0.0, obstacle: -0.25 };
    let runs = [LineSearch::Off, LineSearch::OnPotential].map(|line_search| {
        let options = searching(line_search);
        newton(&mut membrane, &ends(n), vec![0.0; n + 1], &mut solver, &options, &mut seen).unwrap()
    });
    assert!(runs[0].u.iter().zip(&runs[1].u).all(|(a, b)| (a - b).abs() < 1e-11));
    // Drag has no potential.
    membrane.drag = 1e3;
    let error =
        newton(&mut membrane, &ends(n), vec![-1.0; n + 1], &mut solver, &options, &mut seen).unwrap_err();
    assert!(matches!(error.why, NewtonFailure::NoPotential { .. }), "{error}");
    assert!(error.to_string().contains("OnResidual needs none"), "{error}");
    let options = searching(LineSearch::OnResidual);
    let found = newton(&mut membrane, &ends(n), vec![-1.0; n + 1], &mut solver, &options, &mut seen).unwrap();
    assert!(norm(&membrane.residual(&found.u).unwrap()[1..n]) < 1e-10 * found.history[0].residual);
}

/// Several unknowns, each a field of its own, given as residuals and a full matrix.
struct System<F: FnMut(&[f64]) -> (Vec<f64>, Vec<f64>)>(usize, F);

impl<F: FnMut(&[f64]) -> (Vec<f64>, Vec<f64>)> NonlinearProblem for System<F> {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        Ok((self.1)(u).0)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let (n, matrix) = (self.0, (self.1)(u).1);
        let triplets: Vec<_> = matrix.iter().enumerate().map(|(k, value)| (k / n, k % n, *value)).collect();
        Ok(CsrMatrix::from_triplets(n, n, &triplets).map_err(AssemblyError::other)?.into())
    }

    fn fields(&self) -> Vec<FieldUnknowns> {
        vec![FieldUnknowns { unknowns: 1, components: 1 }; self.0]
    }
}

fn system(
    start: &[f64],
    options: &NewtonOptions,
    f: impl FnMut(&[f64]) -> (Vec<f64>, Vec<f64>),
) -> Result<NewtonSolution, NewtonError> {
    let (mut problem, mut solver) = (System(start.len(), f), crate::solve::LuSolver::default());
    newton(&mut problem, &BTreeMap::new(), start.to_vec(), &mut solver, options, &mut |_| ())
}

#[test]
fn each_field_has_a_scale_of_its_own() {
    let options = NewtonOptions::default();
    // A stiff spring next to a soft nonlinear one, whose root is 0.682….
    let root = 0.682_327_803_828_019_3;
    for (stiff, soft) in [(1.0, 1.0), (1e6, 1e-6), (1e12, 1e-12), (1e-12, 1e12)] {
        let found = system(&[0.0; 2], &options, |u| {
            let w = u[1];
            let residual = vec![stiff * (u[0] - 1.0), soft * (w * w * w + w - 1.0)];
            (residual, vec![stiff, 0.0, 0.0, soft * (3.0 * w * w + 1.0)])
        })
        .unwrap();
        assert!((found.u[1] - root).abs() < 1e-12, "{stiff:e}, {soft:e}: {}", found.u[1]);
        assert_eq!(found.iterations(), 6);
        assert_eq!(found.history[0].field_residuals, [stiff, soft]);
    }
    // A field without a load, which the other drives, is done as soon as its residual is rounding of its forces.
    for (stiff, soft) in [(1.0, 1.0), (1e6, 1e-6), (1e-12, 1e12)] {
        let driven = system(&[0.0; 2], &options, |u| {
            (vec![stiff * (u[0] - u[1] / 3.0), soft * (u[1] - 0.1)], vec![stiff, -stiff / 3.0, 0.0, soft])
        })
        .unwrap();
        assert_eq!((driven.iterations(), driven.history[0].field_residuals[0]), (1, 0.0));
    }
    // An unnamed rest is a field as well.
    let elimination = Elimination::new(7, &BTreeMap::from([(1, 0.0), (5, 0.0)])).unwrap();
    let of = |unknowns, components| FieldUnknowns { unknowns, components };
    let fields = Fields::new(&[of(3, 1), of(2, 2)], &elimination, &Together::default());
    let components: Vec<Vec<usize>> = fields.components.iter().map(|one| one.unknowns().collect()).collect();
    assert_eq!(components, [vec![0, 1, 2], vec![3], vec![4], vec![5, 6]]);
    assert_eq!(fields.norms(&[3.0, 4.0, 1.0, 2.0, 7.0]), [5.0, 5.0_f64.sqrt(), 7.0]);
    assert_eq!(fields.norms_over(&[0, 1, 4], |place| place as f64 + 1.0), [5.0_f64.sqrt(), 0.0, 5.0]);
}

/// A pressed body whose gap bends with the pressure: arctan u + λ = f, u + 0.05 (λ − 0.1)² = 0.2. Unknowns and rows have units of their own.
fn pressed(start: [f64; 2], unit: [f64; 2], row: [f64; 2]) -> NewtonSolution {
    let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
    let start = [start[0] / unit[0], start[1] / unit[1]];
    let found = system(&start, &options, |scaled| {
        let [u, p] = [scaled[0] * unit[0], scaled[1] * unit[1]];
        let bend = p - 0.1;
        let residual = vec![row[0] * (u.atan() + p - 0.5), row[1] * (u - 0.2 + 0.05 * bend * bend)];
        let rates = [[1.0 / (1.0 + u * u), 1.0], [1.0, 0.1 * bend]];
        let entries = (0..4).map(|k| row[k / 2] * rates[k / 2][k % 2] * unit[k % 2]);
        (residual, entries.collect())
    });
    found.unwrap()
}

#[test]
fn a_line_search_knows_no_units_and_no_rounding() {
    let dampings = |found: &NewtonSolution| found.history.iter().map(|step| step.damping).collect::<Vec<_>>();
    // The gap is closed but for rounding, and opens as the pressure rises.
    let found = pressed([0.2 + 1e-12, 0.1], [1.0; 2], [1.0; 2]);
    assert!(dampings(&found)[1..].iter().all(|part| *part == Some(1.0)), "{:?}", found.history);
    for start in [[0.2 + 1e-12, 0.1], [30.0, -40.0]] {
        let expected = pressed(start, [1.0; 2], [1.0; 2]);
        assert!(start[0] < 1.0 || dampings(&expected)[1..].iter().any(|part| *part < Some(1.0)));
        for (unit, row) in [([1.0, 1e6], [1e6, 1.0]), ([1e-6, 1.0], [1.0, 1e-6]), ([1e3, 1e-3], [1.0, 1e6])] {
            let found = pressed(start, unit, row);
            assert_eq!(dampings(&found), dampings(&expected), "{start:?} {unit:?} {row:?}");
            let scaled = found.u.iter().zip(unit).map(|(u, unit)| u * unit);
            assert!(scaled.zip(&expected.u).all(|(u, u0)| (u / u0 - 1.0).abs() < 1e-12), "{:?}", found.u);
        }
    }
}

#[test]
fn a_bad_start_does_not_decide_when_to_stop() {
    let options = NewtonOptions { max_iterations: 100, ..NewtonOptions::default() };
    for start in [10.0, 1e3, 1e6, 1e10, 1e15] {
        let cubic = system(&[start], &options, |u| (vec![u[0].powi(3) - 1.0], vec![3.0 * u[0] * u[0]]));
        let found = cubic.unwrap();
        assert!((found.u[0] - 1.0).abs() < 1e-8, "from {start:e}: {}", found.u[0]);
    }
    // One step of a linear problem leaves the rounding of the start.
    for start in [1e6, 1e12, 1e20, 1e30] {
        let found = system(&[start], &options, |u| (vec![3.0 * u[0] - 1.0], vec![3.0])).unwrap();
        assert!((found.u[0] - 1.0 / 3.0).abs() < 1e-8, "from {start:e}: {}", found.u[0]);
        assert!(found.iterations() <= 3);
    }
    // A solution that is zero is no scale either.
    let arctan = |u: &[f64]| (vec![u[0].atan()], vec![1.0 / (1.0 + u[0] * u[0])]);
    // The last step is the one that makes it zero.
    let found = system(&[1.2], &options, arctan).unwrap();
    assert_eq!((found.u[0], found.iterations()), (0.0, 6));
    let square = |u: &[f64]| (vec![u[0] + u[0] * u[0]], vec![1.0 + 2.0 * u[0]]);
    assert!(system(&[0.5], &options, square).unwrap().iterations() <= 5);
}

#[test]
fn what_repeats_itself_is_named_without_an_active_set() {
    let options = NewtonOptions::default();
    let ended = |start: f64, f: fn(f64) -> (f64, f64)| {
        let error = system(&[start], &options, |u| (vec![f(u[0]).0], vec![f(u[0]).1])).unwrap_err();
        (error.why, error.history.len())
    };
    // From 1 to −1 and back, with one residual.
    let mirror = |u: f64| if u > 0.0 { (u + 1.0, 1.0) } else { (u - 1.0, 1.0) };
    assert!(matches!(ended(1.0, mirror), (NewtonFailure::Cycling { first: 1, period: 2 }, 4)));
    // Between 0 and 1 with residuals 2 and 1.
    let cubic = |u: f64| (u.powi(3) - 2.0 * u + 2.0, 3.0 * u * u - 2.0);
    assert!(matches!(ended(0.0, cubic), (NewtonFailure::Cycling { first: 1, period: 2 }, 4)));
    // For ever on, with one residual.
    let (why, count) = ended(0.0, |_| (1.0, 1.0));
    assert!(matches!(why, NewtonFailure::Cycling { period: 1, .. }) && count <= 7, "{why}, {count}");
    // A residual that is known to eight digits.
    let coarse = |u: f64| ((u + 1e8) - 1e8 - 1.0 / 3.0, 1.0);
    let (why, count) = ended(0.0, coarse);
    assert!(matches!(why, NewtonFailure::Stagnated) && count <= 12, "{why}, {count}");
    // Slow convergence is none of these.
    assert!(matches!(ended(1.0, |u| (u.powi(9), 9.0 * u.powi(8))).0, NewtonFailure::NotConverged { .. }));
}
