//! The cylinder with friction against GetFEM 5.4.2 on the same meshes and quadrature rule, in two load steps
//! (`tests/getfem/frictional_cylinder.json`, made by the script next to it).

use forms_contact::hollow_cylinder::{Friction, Settings, solve};
use forms_fem::norms::norms;
use serde_json::Value;

const TOLERANCE: f64 = 1e-9;

fn compare(run: &Value) {
    let number = |value: &Value, name: &str| value[name].as_f64().unwrap_or_else(|| panic!("{name}"));
    let friction = match run["tresca"].as_f64() {
        Some(bound) => Friction::Tresca(bound),
        None => Friction::Coulomb(number(run, "coulomb")),
    };
    let steps = run["steps"].as_array().unwrap();
    let push = |step: &Value| [0, 1].map(|k| step["push"][k].as_f64().unwrap());
    let settings = Settings {
        radial: number(run, "radial") as usize,
        theta: number(run, "theta"),
        gamma0_over_young: number(run, "gamma0_over_young"),
        friction,
        pushes: steps.iter().map(push).collect(),
        ..Settings::default()
    };
    let label = format!("n_r = {}, theta = {}, {friction:?}", settings.radial, settings.theta);
    let solution = solve(&settings).unwrap_or_else(|error| panic!("{label}: {error}"));
    let norm = |field| norms(&solution.problem.assembler, field).unwrap();
    let check = |name: &str, value: f64, theirs: f64, scale: f64| {
        let error = (value - theirs).abs() / scale;
        println!("{label}: {name} {value} {theirs} {error:.1e}");
        assert!(error < TOLERANCE, "{label}: {name} = {value}, GetFEM has {theirs} ({error:.1e})");
    };
    for (step, theirs) in solution.steps.iter().zip(steps) {
        let found = step.friction.unwrap();
        let (force, length) = (number(theirs, "contact_force"), number(theirs, "contact_length"));
        check("contact_force", step.contact_force, force, force);
        check("tangential_force", found.tangential_force, number(theirs, "tangential_force"), force);
        check("contact_length", step.contact_length, length, length);
        check("stick_length", found.stick_length, number(theirs, "stick_length"), length);
        check("slip_length", found.slip_length, number(theirs, "slip_length"), length);
    }
    let last = steps.last().unwrap();
    let (u, discrete, consistent) =
        (norm(&solution.u), norm(&solution.p_discrete), norm(&solution.p_consistent));
    for (name, value, theirs) in [
        ("J", solution.criterion, number(last, "J")),
        ("u_l2", u.l2, number(last, "u_l2")),
        ("u_h1", u.h1, number(last, "u_h1")),
        ("p_discrete_l2", discrete.l2, number(run, "p_discrete_l2")),
        ("p_discrete_h1", discrete.h1, number(run, "p_discrete_h1")),
        ("p_consistent_l2", consistent.l2, number(run, "p_consistent_l2")),
        ("p_consistent_h1", consistent.h1, number(run, "p_consistent_h1")),
    ] {
        check(name, value, theirs, theirs.abs());
    }
}

#[test]
fn both_laws_agree_with_getfem_for_every_theta() {
    let text = include_str!("../getfem/frictional_cylinder.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let runs = file["runs"].as_array().unwrap();
    runs.iter().for_each(compare);
    assert_eq!(runs.len(), 18);
}
