//! Hertz's line contact (`forms_contact::hertz`), on half the section: an elastic cylinder on a rigid flat. The body is nine
//! times as wide as the contact, which leaves a difference below (a/W)², one percent. a and p0 are taken at the computed
//! force P.

use forms_contact::forms;
use forms_contact::hertz::{CONTACT, CONTACT_CELLS, Hertz, YOUNG, cylinder_on_flat};
use forms_contact::threshold::required_gamma0;
use forms_fem::prelude::*;

/// Contact of one half of the body (symmetric in x).
struct Contact {
    force: f64,
    /// (a_h − a)/a.
    half_width_error: f64,
    /// (p_h(0) − p0)/p0.
    peak_error: f64,
    /// ‖p_h − p‖/‖p‖ in L²(Γ_C).
    profile_error: f64,
}

fn solve(divisions: usize, theta: f64) -> Contact {
    let mut problem = cylinder_on_flat(divisions).unwrap();
    // 1.5 times what θ = 1 asks for.
    problem.law.data.theta = 1.0;
    problem.law.data.gamma0 = 1.5 * required_gamma0(&problem, CONTACT_CELLS).unwrap();
    problem.law.data.theta = theta;
    let solved = problem.direct().unwrap().solver(&mut TangentSolver::default()).solve();
    let u = solved.unwrap().into_field();
    let (data, gamma_c, assembler) = (&problem.law.data, &problem.law.regions.gamma_c, &problem.assembler);
    let force = 2.0 * assembler.functional(&forms::contact_force(data, gamma_c, &u)).unwrap();
    let exact = Hertz::of_line(force);
    let length = assembler.functional(&forms::contact_length(data, gamma_c, &u)).unwrap();
    let pressure = forms::contact_pressure(data, &u);
    let samples = assembler.along_facets_uniformly(&pressure, CONTACT, 2).unwrap();
    let first = samples.iter().min_by(|a, b| a.position[0].total_cmp(&b.position[0])).unwrap();
    let contact = Contact {
        force,
        half_width_error: (length - exact.reach) / exact.reach,
        peak_error: (first.value[0] - exact.peak) / exact.peak,
        profile_error: exact.profile_error(&problem, &u).unwrap(),
    };
    println!(
        "n={divisions} γ₀={} E θ={theta}: P {force:.4} a {:.5} {length:.5} ({:+.2e}) p0 {:.4} ({:+.2e}) profile {:.2e}",
        problem.law.data.gamma0 / YOUNG,
        exact.reach,
        contact.half_width_error,
        exact.peak,
        contact.peak_error,
        contact.profile_error
    );
    contact
}

#[test]
fn a_cylinder_on_a_rigid_flat() {
    for theta in [-1.0, 0.0, 1.0] {
        let meshes = [10, 20, 40].map(|divisions| solve(divisions, theta));
        for pair in meshes.windows(2) {
            assert!(pair[1].half_width_error.abs() < pair[0].half_width_error.abs());
            assert!(pair[1].profile_error < pair[0].profile_error);
        }
        let finest = &meshes[2];
        // p0's error is that of the finite body, not the mesh's.
        assert!((finest.force - 10.0).abs() < 0.05, "P = {}", finest.force);
        assert!(finest.half_width_error.abs() < 0.005, "a: {}", finest.half_width_error);
        assert!(finest.peak_error.abs() < 0.003, "p0: {}", finest.peak_error);
        assert!(finest.profile_error < 0.01, "pressure: {}", finest.profile_error);
    }
}
