//! Hertz's point contact (`forms_contact::hertz`), on a quarter of the body: an elastic ball on a rigid flat, and an elastic
//! block on a rigid ball. a and p0 are taken at the computed force P.

use forms_contact::forms;
use forms_contact::hertz::{Body, CONTACT, CONTACT_CELLS, Hertz, YOUNG, in_space};
use forms_contact::threshold::required_gamma0;
use forms_fem::prelude::*;

struct Contact {
    force: f64,
    radius: f64,
    /// (a_h − a)/a, a_h from the area of contact.
    radius_error: f64,
    /// (p_h(0) − p0)/p0.
    peak_error: f64,
    /// ‖p_h − p‖/‖p‖ in L²(Γ_C).
    profile_error: f64,
}

fn solve(body: Body, divisions: usize, theta: f64) -> Contact {
    let mut problem = in_space(body, divisions).unwrap();
    // 1.5 times what θ = 1 asks for.
    problem.law.data.theta = 1.0;
    problem.law.data.gamma0 = 1.5 * required_gamma0(&problem, CONTACT_CELLS).unwrap();
    problem.law.data.theta = theta;
    let mut solver = CondensedSolver::default();
    let solved = problem.direct().unwrap().solver(&mut solver).solve();
    let solved = solved.unwrap();
    let u = solved.field().clone();
    let (data, gamma_c, assembler) = (&problem.law.data, &problem.law.regions.gamma_c, &problem.assembler);
    let force = 4.0 * assembler.functional(&forms::contact_force(data, gamma_c, &u)).unwrap();
    let area = 4.0 * assembler.functional(&forms::contact_length(data, gamma_c, &u)).unwrap();
    let exact = Hertz::of_point(force);
    let radius = (area / std::f64::consts::PI).sqrt();
    let pressure = forms::contact_pressure(data, &u);
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let samples = assembler.along_facets(&pressure, CONTACT, &corners).unwrap();
    let first = samples.iter().min_by(|a, b| {
        let distance = |x: &[f64; 3]| x[0].hypot(x[1]);
        distance(&a.position).total_cmp(&distance(&b.position))
    });
    let contact = Contact {
        force,
        radius: exact.reach,
        radius_error: (radius - exact.reach) / exact.reach,
        peak_error: (first.unwrap().value[0] - exact.peak) / exact.peak,
        profile_error: exact.profile_error(&problem, &u).unwrap(),
    };
    println!(
        "{body:?} n={divisions} γ₀={:.1} E θ={theta}: P {force:.3} a {:.4} {radius:.4} ({:+.2e}) p0 {:.3} ({:+.2e}) \
         profile {:.2e}; {} steps, {} unknowns, {:?} {:?}",
        problem.law.data.gamma0 / YOUNG,
        exact.reach,
        contact.radius_error,
        exact.peak,
        contact.peak_error,
        contact.profile_error,
        solved.history.len() - 1,
        problem.space.unknowns(),
        solver.report().path,
        solver.report().condensed_unknowns,
    );
    contact
}

/// On 8 and 12 cells across; on 12 the radius of contact is 8 cells. `profile` bounds the error of the finer one.
fn check(body: Body, theta: f64, profile: f64) {
    let [coarse, fine] = [8, 12].map(|divisions| solve(body, divisions, theta));
    assert!(fine.profile_error < coarse.profile_error);
    assert!((0.6..0.7).contains(&fine.radius), "a = {} at P = {}", fine.radius, fine.force);
    assert!(fine.radius_error.abs() < 0.02, "a: {}", fine.radius_error);
    assert!(fine.peak_error.abs() < 0.01, "p0: {}", fine.peak_error);
    assert!(fine.profile_error < profile, "pressure: {}", fine.profile_error);
}

#[test]
fn a_ball_on_a_rigid_flat() {
    check(Body::Ball, 1.0, 0.02);
}

// 2.33 % at θ = −1, 2.07 % at θ = 1: most of it in the cells at the edge of the contact, where the slope is infinite.
#[test]
fn a_block_on_a_rigid_ball() {
    check(Body::Block, -1.0, 0.025);
}
