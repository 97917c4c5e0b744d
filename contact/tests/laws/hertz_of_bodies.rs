//! Two elastic bodies pressed together, compared with Hertz's closed forms: cylinders, and a ball on a half-space.

use forms_contact::ContactProblem;
use forms_contact::half_spaces::{HalfSpaces, Tractions, balls, cylinders};
use forms_contact::hertz::{Hertz, RADIUS};
use forms_contact::laws::two_bodies as law;
use forms_fem::prelude::*;

use crate::setting::close;

/// P \[N, in the plane N/mm\].
const FORCE: f64 = 10.0;

/// Presses the bodies; the force that comes out, and the profile.
fn press<const D: usize>(
    bodies: &HalfSpaces<D>,
    problem: &ContactProblem<D, law::Model<D>>,
) -> (f64, Hertz, f64)
where
    Dim: Dimension<D>,
{
    let mut solver = CondensedSolver::default();
    let solved = problem.direct().unwrap().solver(&mut solver).solve().unwrap();
    let tractions = Tractions::of(problem, solved.field()).unwrap();
    let force = tractions.force() / bodies.part();
    let error = tractions.profile_error(&bodies.hertz);
    println!("{} unknowns, {} steps, profile {error:.2e}", bodies.space.unknowns(), solved.iterations());
    (force, tractions.fitted(), error)
}

/// P, a and p0 within a tolerance; the closed form's own numbers first.
fn check(label: &str, exact: [f64; 2], found: (f64, Hertz, f64), tolerance: f64, profile: f64) {
    let (force, fitted, error) = found;
    close(&format!("{label}: P"), force, FORCE, tolerance);
    close(&format!("{label}: a"), fitted.reach, exact[0], tolerance);
    close(&format!("{label}: p0"), fitted.peak, exact[1], tolerance);
    assert!(error < profile, "{label}: the profile is {error:.2e} off in the L² norm");
}

/// Numbers of cells over a; a sweep has more of them.
fn finenesses(usual: &[usize], more: &[usize]) -> Vec<usize> {
    let more = if std::env::var_os("FORMS_SWEEPS").is_some() { more } else { &[] };
    usual.iter().chain(more).copied().collect()
}

/// Both curved, and both integrated over.
#[test]
fn two_cylinders() {
    for cells in finenesses(&[4, 8], &[16]) {
        let bodies = cylinders([RADIUS; 2], FORCE, cells).unwrap();
        let found = press(&bodies, &bodies.pressed().unwrap());
        check(&format!("a/h = {cells}"), [0.68078, 9.3514], found, 0.01, 0.035);
    }
}

#[test]
fn a_cylinder_on_a_half_space() {
    for cells in finenesses(&[4, 8], &[16]) {
        let bodies = cylinders([f64::INFINITY, RADIUS], FORCE, cells).unwrap();
        let found = press(&bodies, &bodies.pressed().unwrap());
        check(&format!("a/h = {cells}"), [0.96277, 6.6124], found, 0.003, 0.08 / cells as f64);
    }
}

/// The bodies approach each other by a²/R; the force follows.
#[test]
fn a_ball_on_a_half_space() {
    for cells in finenesses(&[3], &[4, 6]) {
        let bodies = balls([f64::INFINITY, RADIUS], FORCE, cells).unwrap();
        close("approach", bodies.approach(), 0.08350, 1e-4);
        let found = press(&bodies, &bodies.pressed().unwrap());
        // The way at the force that comes out: the force grows as its power 3/2.
        close(
            "approach under the force",
            bodies.approach() * (found.0 / FORCE).powf(2.0 / 3.0),
            0.08350,
            0.02,
        );
        check(&format!("a/h = {cells}"), [0.81733, 7.1474], found, 0.02, 0.3 / cells as f64);
    }
}
