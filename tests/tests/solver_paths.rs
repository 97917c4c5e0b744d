//! The ways to solve the direct problem (14), each forced: all reach the same u, and say which way they took.

use forms_contact::ContactProblem;
use forms_contact::hollow_cylinder::{Settings, hollow_cylinder};
use forms_contact::paper_law::Adjoint;
use forms_contact::theta_path::ThetaPath;
use forms_fem::linear_algebra::vector::norm;
use forms_fem::prelude::*;
use forms_fem::solve::{LineSearch, LuSolver, NewtonFailure, SolverPath};

/// Relative difference of two ways.
const SAME: f64 = 1e-10;

fn cylinder(theta: f64, gamma0_over_young: f64) -> ContactProblem<2> {
    hollow_cylinder(&Settings { radial: 6, theta, gamma0_over_young, ..Settings::default() }).unwrap()
}

fn difference(a: &Field<2>, b: &Field<2>) -> f64 {
    let difference: Vec<f64> = a.values().iter().zip(b.values()).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(b.values())
}

fn direct(problem: &ContactProblem<2>, solver: &mut dyn LinearSolver) -> (Field<2>, Vec<NewtonStep>) {
    let solved = problem.direct().unwrap().solver(solver).solve().unwrap();
    (solved.field().clone(), solved.history)
}

/// States and adjoint states by condensation are those of plain Newton with LU of each whole tangent.
#[test]
fn condensed_is_plain() {
    for theta in [-1.0, 0.0, 1.0] {
        let problem = cylinder(theta, 10.0);
        let mut plain = LuSolver::default();
        let (expected, plain_history) = direct(&problem, &mut plain);
        assert!(plain_history.iter().all(|step| step.condensed_unknowns.is_none()));
        let mut condensed = CondensedSolver::default();
        let (found, history) = direct(&problem, &mut condensed);
        assert!(difference(&found, &expected) < SAME, "{:e}", difference(&found, &expected));
        // The same iterates, on a few unknowns, with one factor.
        assert_eq!(history.len(), plain_history.len());
        for (step, plain) in history.iter().zip(&plain_history) {
            assert_eq!(step.active_points, plain.active_points);
            assert!((step.relative_residual - plain.relative_residual).abs() < 1e-9);
        }
        let report = condensed.report();
        let count = report.condensed_unknowns.unwrap();
        assert_eq!((report.path, report.factorisations), (Some(SolverPath::Condensed), 1));
        assert!(count > 0 && 10 * count < problem.space.unknowns());
        assert!(history[1..].iter().all(|step| step.condensed_unknowns == Some(count)));
        for adjoint in [Adjoint::Consistent, Adjoint::Discrete] {
            let one = problem.solve_adjoint(adjoint, &found, &mut condensed).unwrap().into_field();
            let other = problem.solve_adjoint(adjoint, &expected, &mut plain).unwrap().into_field();
            assert!(difference(&one, &other) < SAME, "{adjoint:?}: {:e}", difference(&one, &other));
        }
        assert_eq!(condensed.report().factorisations, 1);
    }
}

#[test]
fn each_way_is_named() {
    let cases = [
        (1.0, usize::MAX, SolverPath::Cholesky),
        (-1.0, usize::MAX, SolverPath::Gmres),
        (-1.0, 0, SolverPath::Lu),
    ];
    for (theta, lu_after, path) in cases {
        let problem = cylinder(theta, 10.0);
        let (expected, _) = direct(&problem, &mut LuSolver::default());
        let options = TangentSolverOptions { lu_after: Some(lu_after), ..Default::default() };
        let mut solver = TangentSolver::new(options);
        let (found, history) = direct(&problem, &mut solver);
        assert_eq!(solver.report().path, Some(path));
        assert!(difference(&found, &expected) < SAME);
        let krylov: Vec<usize> = history.iter().filter_map(|step| step.linear_iterations).collect();
        assert_eq!(krylov.iter().sum::<usize>() > 0, path != SolverPath::Cholesky);
        assert_eq!(krylov.last() == Some(&0), path != SolverPath::Gmres);
    }
    // Below the threshold the linear part is indefinite: condensing gives way to Bunch and Kaufman.
    let problem = cylinder(1.0, 5.0);
    let mut solver = CondensedSolver::default();
    let (found, history) = direct(&problem, &mut solver);
    assert_eq!(solver.report().path, Some(SolverPath::Indefinite));
    assert_eq!(solver.report().condensed_unknowns, None);
    assert!(history.iter().all(|step| step.condensed_unknowns.is_none()));
    assert!(difference(&found, &direct(&problem, &mut LuSolver::default()).0) < SAME);
}

/// A guess that was wrong costs a second factor and nothing else: here the zone of contact is not where the mean of
/// the prescribed values leads, because the start is elsewhere.
#[test]
fn a_growing_zone_is_factored_anew() {
    let problem = cylinder(-1.0, 10.0);
    let (expected, _) = direct(&problem, &mut LuSolver::default());
    let far = Field::interpolate(&problem.space, |x: &[f64; 2]| [0.2 * x[1], -3.0]).unwrap();
    let mut solver = CondensedSolver::default();
    let solved = problem.direct().unwrap().start(&far).solver(&mut solver).solve().unwrap();
    assert!(difference(solved.field(), &expected) < SAME);
}

#[test]
fn a_line_search_and_a_path_through_theta() {
    let options = NewtonOptions { line_search: LineSearch::OnPotential, ..NewtonOptions::default() };
    // θ = 1 has a potential; the search changes nothing where whole steps descend.
    let symmetric = cylinder(1.0, 10.0);
    let (expected, _) = direct(&symmetric, &mut LuSolver::default());
    let mut solver = CondensedSolver::default();
    let found = symmetric.direct().unwrap().solver(&mut solver).options(options.clone()).solve().unwrap();
    assert!(difference(found.field(), &expected) < SAME);
    assert!(found.history[1..].iter().all(|step| step.damping.is_some_and(|part| part > 0.0)));
    // θ = −1 has none.
    let skew = cylinder(-1.0, 10.0);
    let error = skew.direct().unwrap().solver(&mut solver).options(options.clone()).solve().unwrap_err();
    assert!(matches!(error.why, NewtonFailure::NoPotential { .. }), "{error}");
    assert!(!error.history.is_empty());
    // But it is reached from θ = 1.
    let (expected, _) = direct(&skew, &mut LuSolver::default());
    let mut thetas = vec![];
    let path = skew
        .solve_through(
            ThetaPath::default(),
            &mut CondensedSolver::default(),
            &NewtonOptions::default(),
            |theta, step| {
                if step.iteration == 0 {
                    thetas.push(theta);
                }
            },
        )
        .unwrap();
    assert_eq!(thetas, [1.0, 0.0, -1.0]);
    assert!(difference(&path.state, &expected) < SAME);
    // Without Newton steps no θ is reached, and the error says which.
    let none = NewtonOptions { max_iterations: 0, ..NewtonOptions::default() };
    let mut solver = CondensedSolver::default();
    let error = skew.solve_through(ThetaPath::default(), &mut solver, &none, |_, _| ()).unwrap_err();
    assert!(error.to_string().contains("no convergence within 0 iterations"), "{error}");
}
