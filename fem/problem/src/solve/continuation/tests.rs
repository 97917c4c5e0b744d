//! Branches of small algebraic problems whose folds and pitchforks are known exactly.

use super::bordered_solver::BorderedSolver;
use super::branch::{BranchEnd, ContinuationFailure};
use super::events::{EventKind, Located};
use super::family::{Family, Next, Place, Reached, Refusal};
use super::inertia::Inertia;
use super::points::Points;
use super::start::First;
use super::tracing::{Steps, Traced};
use crate::assemble::AssemblyError;
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError, Sign};
use crate::solve::{Elimination, LinearSolver, NewtonOptions, NonlinearProblem, SolverError, Tangent};
use std::collections::BTreeMap;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Residual, rows of the tangent, and rate at (u, λ).
type Law = fn(&[f64], f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>);

struct Algebraic {
    law: Law,
    parameter: f64,
    seen: Vec<(f64, Vec<f64>)>,
}

impl NonlinearProblem for Algebraic {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        Ok((self.law)(u, self.parameter).0)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let rows = (self.law)(u, self.parameter).1;
        let entries = rows.iter().enumerate();
        let entries =
            entries.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, value)| (i, j, *value)));
        let entries: Vec<(usize, usize, f64)> = entries.collect();
        let matrix = CsrMatrix::from_triplets(u.len(), u.len(), &entries).map_err(AssemblyError::other)?;
        Ok(matrix.into())
    }
}

impl Family for Algebraic {
    fn set_parameter(&mut self, parameter: f64) -> Result<(), AssemblyError> {
        self.parameter = parameter;
        Ok(())
    }

    fn equations(&mut self) -> &mut dyn NonlinearProblem {
        self
    }

    fn rate(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        Ok((self.law)(u, self.parameter).2)
    }

    fn reached(&mut self, point: &Reached) -> Result<Next, Refusal> {
        self.seen.push((point.at.parameter, point.at.u.clone()));
        Ok(Next::GoOn)
    }
}

struct Found {
    end: Result<BranchEnd, ContinuationFailure>,
    events: Vec<Located>,
    seen: Vec<(f64, Vec<f64>)>,
    inertias: Vec<Inertia>,
}

fn follow_from(law: Law, first: First, step: f64, steps: &Steps) -> Result<Found, LinearAlgebraError> {
    let (parameter, size) = match &first {
        First::At(place) => (place.parameter, place.u.len()),
        First::Beyond { bifurcation, .. } => (bifurcation.parameter, bifurcation.u.len()),
    };
    let mut family = Algebraic { law, parameter, seen: vec![] };
    let elimination = Elimination::new(size, &BTreeMap::new())?;
    let mut traced = Traced::default();
    let options = NewtonOptions::default();
    let solver = BorderedSolver::default();
    let mut points = Points::new(&mut family, elimination, step, options, solver);
    let end = super::start::follow(&mut traced, &mut points, first, step, steps, "law");
    drop(points);
    let inertias = traced.points.iter().map(|point| point.inertia).collect();
    let events = traced.events.into_iter().map(|(_, event)| event).collect();
    Ok(Found { end, events, seen: family.seen, inertias })
}

fn steps(range: std::ops::RangeInclusive<f64>) -> Steps {
    Steps { smallest: 1.0 / 1024.0, largest: 4.0, points: 400, range }
}

fn at(u: &[f64], parameter: f64) -> First {
    First::At(Place { u: u.to_vec(), parameter })
}

/// λ = u³ − 3u: limit points at λ = 2 and −2.
fn cubic(u: &[f64], parameter: f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    (vec![u[0].powi(3) - 3.0 * u[0] - parameter], vec![vec![3.0 * u[0] * u[0] - 3.0]], vec![-1.0])
}

#[test]
fn both_folds_of_a_cubic() -> Outcome {
    let found = follow_from(cubic, at(&[-2.5], -8.0), 0.5, &steps(-10.0..=5.0))?;
    assert!(matches!(found.end, Ok(BranchEnd::Range)), "{:?}", found.end);
    assert_eq!(found.events.len(), 2);
    for (event, (u, parameter)) in found.events.iter().zip([(-1.0, 2.0), (1.0, -2.0)]) {
        assert_eq!(event.kind, EventKind::LimitPoint);
        assert!((event.at.parameter - parameter).abs() < 1e-12, "{event:?}");
        assert!((event.at.u[0] - u).abs() < 1e-6, "{event:?}");
        assert!(event.uncertainty < 1e-8, "{event:?}");
    }
    let (last, u) = found.seen.last().ok_or("no point")?;
    assert!(*last == 5.0 && (u[0].powi(3) - 3.0 * u[0] - 5.0).abs() < 1e-9, "{last} {u:?}");
    // Unstable between the folds, and only there.
    for ((_, u), inertia) in found.seen.iter().zip(&found.inertias) {
        assert_eq!(*inertia, Inertia::NegativeEigenvalues(usize::from(u[0].abs() < 1.0)), "{u:?}");
    }
    Ok(())
}

/// u³ − λu = 0, and an unknown v = λ that keeps the length of the trivial branch.
fn pitchfork(u: &[f64], parameter: f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    let residual = vec![u[0].powi(3) - parameter * u[0], u[1] - parameter];
    (residual, vec![vec![3.0 * u[0] * u[0] - parameter, 0.0], vec![0.0, 1.0]], vec![-u[0], -1.0])
}

/// The pitchfork, with an unsymmetric coupling.
fn unsymmetric_pitchfork(u: &[f64], parameter: f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    let residual = vec![u[0].powi(3) - parameter * u[0], u[1] - parameter + 0.5 * u[0]];
    (residual, vec![vec![3.0 * u[0] * u[0] - parameter, 0.0], vec![0.5, 1.0]], vec![-u[0], -1.0])
}

#[test]
fn a_pitchfork_and_its_branches() -> Outcome {
    for law in [pitchfork as Law, unsymmetric_pitchfork] {
        let found = follow_from(law, at(&[0.0, -1.0], -1.0), 0.3, &steps(-2.0..=2.0))?;
        assert!(matches!(found.end, Ok(BranchEnd::Range)), "{:?}", found.end);
        let [event] = &found.events[..] else { return Err(format!("{:?}", found.events).into()) };
        assert_eq!(event.kind, EventKind::Bifurcation { eigenvalues: 1 });
        assert!(event.at.parameter.abs() < 1e-9 && event.at.parameter.abs() <= event.uncertainty + 1e-15);
        assert!((event.modes[0][0].abs() - 1.0).abs() < 1e-6 && found.seen.iter().all(|(_, u)| u[0] == 0.0));
        let is_symmetric = matches!(found.inertias[0], Inertia::NegativeEigenvalues(_));
        assert_eq!(is_symmetric, std::ptr::fn_addr_eq(law, pitchfork as Law));
        if !is_symmetric {
            assert_eq!(found.inertias[0], Inertia::Determinant(Sign::Positive));
        }
        for amplitude in [0.1, -0.1] {
            let change = event.modes[0].iter().map(|value| amplitude * value).collect();
            let (bifurcation, direction) = (event.at.clone(), event.direction.clone());
            let first = First::Beyond { bifurcation, direction, change, amplitude };
            let other = follow_from(law, first, 0.1, &steps(-2.0..=2.0))?;
            assert!(matches!(other.end, Ok(BranchEnd::Range)), "{:?}", other.end);
            assert_eq!(other.events.len(), 0);
            for (parameter, u) in &other.seen {
                assert!(
                    (u[0] * u[0] - parameter).abs() < 1e-10 && u[0] * event.modes[0][0] * amplitude > 0.0
                );
            }
            assert!((other.seen[0].1[0].abs() - 0.1).abs() < 1e-2, "{:?}", other.seen[0]);
        }
    }
    Ok(())
}

/// λu − u² = 0: the branches u = 0 and u = λ cross at an angle that the null vector does not have.
fn crossing(u: &[f64], parameter: f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    (vec![u[0] * u[0] - parameter * u[0]], vec![vec![2.0 * u[0] - parameter]], vec![-u[0]])
}

#[test]
fn a_transcritical_bifurcation() -> Outcome {
    let found = follow_from(crossing, at(&[0.0], -1.0), 0.3, &steps(-1.0..=1.0))?;
    let [event] = &found.events[..] else { return Err(format!("{:?}", found.events).into()) };
    assert!(event.at.parameter.abs() < 1e-9, "{event:?}");
    let (bifurcation, direction) = (event.at.clone(), event.direction.clone());
    let first = First::Beyond { bifurcation, direction, change: vec![0.1], amplitude: 0.1 };
    let other = follow_from(crossing, first, 0.1, &steps(-1.0..=1.0))?;
    assert!(matches!(other.end, Ok(BranchEnd::Range)) && other.seen.len() > 2);
    assert!(other.seen.iter().all(|(parameter, u)| (u[0] - parameter).abs() < 1e-10), "{:?}", other.seen);
    Ok(())
}

/// The cubic with a stop of stiffness 50 at u = 0: there the branch turns, in a kink, from falling to rising λ.
fn stopped(u: &[f64], parameter: f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    let (mut residual, mut tangent, rate) = cubic(u, parameter);
    residual[0] += 50.0 * u[0].max(0.0);
    tangent[0][0] += if u[0] > 0.0 { 50.0 } else { 0.0 };
    (residual, tangent, rate)
}

#[test]
fn a_branch_goes_forwards_beyond_a_kink() -> Outcome {
    for step in [0.5, 0.11] {
        let found = follow_from(stopped, at(&[-2.5], -8.0), step, &steps(-10.0..=5.0))?;
        assert!(matches!(found.end, Ok(BranchEnd::Range)), "{:?}", found.end);
        let parameters: Vec<f64> = found.events.iter().map(|event| event.at.parameter).collect();
        assert_eq!(found.events.len(), 2, "{parameters:?}");
        assert!((parameters[0] - 2.0).abs() < 1e-12 && parameters[1].abs() < 1e-8, "{parameters:?}");
        assert!(parameters[1].abs() <= found.events[1].uncertainty + 1e-12, "{:?}", found.events[1]);
        assert!(found.seen.windows(2).all(|pair| pair[1].1[0] > pair[0].1[0]), "{:?}", found.seen);
        assert!(found.seen.last().is_some_and(|(parameter, u)| *parameter == 5.0 && u[0] > 0.0));
    }
    Ok(())
}

/// Two bars from (±1, 0) to (0, 2), of stiffness EA = L³, with Green's strain; u is the apex's place, λ the load on it.
fn truss(u: &[f64], parameter: f64) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    let (mut force, mut tangent) = (vec![0.0, parameter], vec![vec![0.0; 2]; 2]);
    for foot in [-1.0, 1.0] {
        let bar = [u[0] - foot, u[1]];
        // E = L Σ (l² − L²)² / 8 / L, so that ∂E/∂d = (l² − L²) d / 2.
        let strain = (bar[0] * bar[0] + bar[1] * bar[1] - 5.0) / 2.0;
        for i in 0..2 {
            force[i] += strain * bar[i];
            for j in 0..2 {
                tangent[i][j] += bar[i] * bar[j] + if i == j { strain } else { 0.0 };
            }
        }
    }
    (force, tangent, vec![0.0, 1.0])
}

/// On the symmetric branch λ = (4 − y²) y: limit points at y = ±2/√3, bifurcations where y² = 4 − 2.
#[test]
fn von_mises_truss() -> Outcome {
    let found = follow_from(truss, at(&[0.0, 2.0], 0.0), 0.2, &steps(-4.0..=4.0))?;
    assert!(matches!(found.end, Ok(BranchEnd::Range)), "{:?}", found.end);
    let limit = 16.0 / (3.0 * 3.0_f64.sqrt());
    let fork = 2.0 * 2.0_f64.sqrt();
    let bifurcation = EventKind::Bifurcation { eigenvalues: 1 };
    let expected = [
        (bifurcation, fork),
        (EventKind::LimitPoint, limit),
        (EventKind::LimitPoint, -limit),
        (bifurcation, -fork),
    ];
    assert_eq!(found.events.len(), 4, "{:?}", found.events);
    for (event, (kind, parameter)) in found.events.iter().zip(expected) {
        assert_eq!(event.kind, kind);
        assert!((event.at.parameter - parameter).abs() < 1e-9, "{event:?} {parameter}");
    }
    // The sway branch leaves to both sides, and comes back at the other bifurcation.
    let event = &found.events[0];
    let change = event.modes[0].iter().map(|value| 0.05 * value).collect();
    let (bifurcation, direction) = (event.at.clone(), event.direction.clone());
    let first = First::Beyond { bifurcation, direction, change, amplitude: 0.05 };
    let sway = follow_from(truss, first, 0.2, &steps(-4.0..=4.0))?;
    let side = sway.seen[0].1[0].signum();
    let sways = sway.seen.iter().take_while(|(_, u)| u[0] * side > 1e-3).count();
    assert!(sways > 5, "{:?}", sway.seen);
    // The horizontal force vanishes there for x ≠ 0 where x² + y² = 5 − 3.
    for (_, u) in &sway.seen[..sways] {
        assert!((u[0] * u[0] + u[1] * u[1] - 2.0).abs() < 1e-8, "{u:?}");
    }
    Ok(())
}

/// A singular core with a regular border, as at a limit point; and one that is singular with its border, as at a bifurcation.
#[test]
fn a_bordered_matrix_with_a_singular_core() -> Outcome {
    let whole = |corner: [f64; 2]| {
        let mut entries = vec![(0, 0, 2.0), (0, 1, -2.0), (1, 0, -2.0), (1, 1, 2.0)];
        entries.extend([
            (0, 2, corner[0]),
            (1, 2, corner[1]),
            (2, 0, corner[0]),
            (2, 1, corner[1]),
            (2, 2, 0.5),
        ]);
        CsrMatrix::from_triplets(3, 3, &entries)
    };
    let mut solver = BorderedSolver::default();
    solver.set_matrix(whole([1.0, 3.0])?)?;
    let exact = [0.3, -0.2, 0.7];
    let found = solver.solve(&whole([1.0, 3.0])?.multiply(&exact)?, 0.0)?;
    assert!(found.solution.iter().zip(exact).all(|(x, exact)| (x - exact).abs() < 1e-14), "{found:?}");
    assert_eq!(solver.inertia()?, Inertia::Singular);
    let found = solver.solve_transposed(&whole([1.0, 3.0])?.multiply_transposed(&exact)?, 0.0)?;
    assert!(found.solution.iter().zip(exact).all(|(x, exact)| (x - exact).abs() < 1e-14), "{found:?}");
    // The border has no part of the null vector (1, 1).
    let result = solver.set_matrix(whole([1.0, -1.0])?).and_then(|()| solver.solve(&[1.0, 2.0, 3.0], 0.0));
    assert!(matches!(result, Err(SolverError::LinearAlgebra(_))), "{result:?}");
    Ok(())
}
