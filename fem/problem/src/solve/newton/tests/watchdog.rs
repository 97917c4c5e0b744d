//! Whole steps that raise the residual under a watchdog: fewer steps where they lead on, and the way back where they do not.

use super::*;

fn searching(line_search: LineSearch) -> NewtonOptions {
    NewtonOptions { line_search, ..NewtonOptions::default() }
}

fn dampings(found: &NewtonSolution) -> Vec<Option<f64>> {
    found.history.iter().map(|step| step.damping).collect()
}

/// A soft spring that is drawn onto a stop: u − 1 + 10⁴ [u − 0.1]₊.
fn stopped(line_search: LineSearch) -> NewtonSolution {
    let force = |u: f64| (u - 1.0 + 1e4 * (u - 0.1).max(0.0), if u > 0.1 { 1.0 + 1e4 } else { 1.0 });
    system(&[0.0], &searching(line_search), |u| (vec![force(u[0]).0], vec![force(u[0]).1])).unwrap()
}

#[test]
fn forces_that_appear_with_a_step_do_not_shorten_it() {
    let (shortened, watched) = (stopped(LineSearch::OnResidual), stopped(LineSearch::Watchdog));
    let expected = (1.0 + 1e3) / (1.0 + 1e4);
    assert!([&shortened, &watched].iter().all(|found| (found.u[0] - expected).abs() < 1e-14));
    // To the other side, where the residual is 9000 times as large, and from there to the solution.
    assert_eq!(dampings(&watched)[1..3], [Some(1.0); 2], "{:?}", watched.history);
    assert!(watched.history[1].residual > 1e3 * watched.history[0].residual);
    assert!(watched.iterations() <= 3 && shortened.iterations() > 3, "{:?}", shortened.history);
}

#[test]
fn steps_that_lead_away_are_taken_back() {
    // Whole steps from 3 overshoot more and more.
    let found = system(&[3.0], &searching(LineSearch::Watchdog), |u| {
        (vec![u[0].atan()], vec![1.0 / (1.0 + u[0] * u[0])])
    });
    let found = found.unwrap();
    assert!(found.u[0].abs() < 1e-9);
    let parts = dampings(&found);
    // The third one after the first is tried, and not taken.
    assert_eq!(parts[1..4], [Some(1.0); 3], "{:?}", found.history);
    // Back to the start, and a part of the first step from there.
    assert_eq!(parts[4], Some(0.25), "{:?}", found.history);
    assert!((1..4).all(|k| found.history[k].residual > found.history[0].residual));
    assert!(found.history[4].residual < found.history[0].residual);
    let (back, first) = (found.history[4].step.unwrap(), found.history[1].step.unwrap());
    assert!((back - 0.25 * first).abs() < 1e-14 * first);
}

#[test]
fn a_cycle_of_whole_steps_is_left() {
    // Whole steps from 0 go to 1 and back; the root is −1.769….
    let cubic = |u: &[f64]| (vec![u[0].powi(3) - 2.0 * u[0] + 2.0], vec![3.0 * u[0] * u[0] - 2.0]);
    let why = system(&[0.0], &NewtonOptions::default(), cubic).unwrap_err().why;
    assert!(matches!(why, NewtonFailure::Cycling { .. }), "{why}");
    let found = system(&[0.0], &searching(LineSearch::Watchdog), cubic).unwrap();
    assert!((found.u[0] + 1.769_292_354_238_631_4).abs() < 1e-12, "{:?}", found.history);
    // A cycle with no root is named.
    let mirror = |u: &[f64]| (vec![if u[0] > 0.0 { u[0] + 1.0 } else { u[0] - 1.0 }], vec![1.0]);
    let error = system(&[1.0], &searching(LineSearch::Watchdog), mirror).unwrap_err();
    assert!(!matches!(error.why, NewtonFailure::NotFinite), "{error}");
    assert!(error.history.iter().all(|step| step.residual.is_finite()));
}

/// Two springs with stops, coupled. Unknowns and rows have units of their own.
fn coupled(unit: [f64; 2], row: [f64; 2]) -> NewtonSolution {
    let found = system(&[0.0; 2], &searching(LineSearch::Watchdog), |scaled| {
        let [u, p] = [scaled[0] * unit[0], scaled[1] * unit[1]];
        let on = [u > 0.1, p > 0.2].map(|on| if on { 1e3 } else { 0.0 });
        let residual = [u - 1.0 + 0.3 * p + on[0] * (u - 0.1), (p - 0.5) + 0.2 * u + on[1] * (p - 0.2)];
        let rates = [[1.0 + on[0], 0.3], [0.2, 1.0 + on[1]]];
        let entries = (0..4).map(|k| row[k / 2] * rates[k / 2][k % 2] * unit[k % 2]);
        (vec![row[0] * residual[0], row[1] * residual[1]], entries.collect())
    });
    found.unwrap()
}

#[test]
fn a_watchdog_knows_no_units() {
    let expected = coupled([1.0; 2], [1.0; 2]);
    assert!(expected.history[1].residual > expected.history[0].residual);
    for (unit, row) in [([1.0, 1e6], [1e6, 1.0]), ([1e-6, 1.0], [1.0, 1e-6]), ([1e3, 1e-3], [1.0, 1e6])] {
        let found = coupled(unit, row);
        assert_eq!(dampings(&found), dampings(&expected), "{unit:?} {row:?}");
        let scaled = found.u.iter().zip(unit).map(|(u, unit)| u * unit);
        assert!(scaled.zip(&expected.u).all(|(u, u0)| (u / u0 - 1.0).abs() < 1e-12), "{:?}", found.u);
    }
}

#[test]
fn infeasible_whole_steps_are_shortened_at_once() {
    // ln u has no value where whole steps from 5 lead.
    let found = system(&[5.0], &searching(LineSearch::Watchdog), |u| (vec![u[0].ln()], vec![1.0 / u[0]]));
    let found = found.unwrap();
    assert!((found.u[0] - 1.0).abs() < 1e-12 && found.history[1].damping < Some(1.0), "{:?}", found.history);
}
