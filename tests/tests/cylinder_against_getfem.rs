//! The paper's cylinder against GetFEM 5.4.2 on the same meshes and quadrature rule
//! (`tests/getfem/cylinder.json`, made by the script next to it).

use forms_contact::hollow_cylinder::{Settings, solve};
use forms_fem::norms::norms;
use serde_json::Value;

const TOLERANCE: f64 = 1e-10;

fn runs() -> Vec<Value> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/getfem/cylinder.json")).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    file["runs"].as_array().unwrap().clone()
}

fn compare(run: &Value) {
    let number = |name: &str| run[name].as_f64().unwrap();
    let settings = Settings {
        radial: number("radial") as usize,
        theta: number("theta"),
        gamma0_over_young: number("gamma0_over_young"),
        ..Settings::default()
    };
    let label = format!("n_r = {}, theta = {}", settings.radial, settings.theta);
    let solution = solve(&settings).unwrap_or_else(|error| panic!("{label}: {error}"));
    let assembler = &solution.problem.assembler;
    let u = norms(assembler, &solution.u).unwrap();
    let h1 = |field| norms(assembler, field).unwrap().h1;
    let ours = [
        ("J", solution.criterion),
        ("u_l2", u.l2),
        ("u_h1", u.h1),
        ("contact_force", solution.contact_force),
        ("contact_length", solution.contact_length),
        ("p_discrete_h1", h1(&solution.p_discrete)),
        ("p_consistent_h1", h1(&solution.p_consistent)),
        ("p_extended_h1", h1(&solution.p_extended)),
    ];
    for (name, value) in ours {
        let theirs = number(name);
        let error = (value - theirs).abs() / theirs.abs();
        println!("{label}: {name} {value} {theirs} {error:.1e}");
        assert!(error < TOLERANCE, "{label}: {name} = {value}, GetFEM has {theirs} ({error:.1e})");
    }
    // A difference of lengths of 1 cm.
    let penetration = (solution.max_penetration - number("max_penetration")).abs();
    assert!(penetration < TOLERANCE, "{label}: penetration differs by {penetration:.1e}");
    assert_eq!(solution.u.space().unknowns(), number("unknowns") as usize);
    assert_eq!(solution.history.len() - 1, number("newton_iterations") as usize, "{label}: Newton steps");
    for point in run["points"].as_array().unwrap() {
        let vector = |name: &str| -> [f64; 2] { [0, 1].map(|k| point[name][k].as_f64().unwrap()) };
        for (name, field) in [("u", &solution.u), ("p", &solution.p_consistent)] {
            let (ours, theirs) = (field.evaluate(&vector("x")).unwrap(), vector(name));
            let scale = theirs[0].abs().max(theirs[1].abs());
            for k in 0..2 {
                let error = (ours[k] - theirs[k]).abs() / scale;
                assert!(error < TOLERANCE, "{label}: {name}{k} at {:?}: {error:.1e}", vector("x"));
            }
        }
    }
}

/// On meshes of up to eight cells across; FORMS_SWEEPS=1: on the default mesh, too.
#[test]
fn solutions_agree_with_getfem_digit_by_digit() {
    let (finest, least) = if std::env::var_os("FORMS_SWEEPS").is_some() { (16.0, 12) } else { (8.0, 9) };
    let mut compared = 0;
    for run in runs().iter().filter(|run| run["radial"].as_f64().unwrap() <= finest) {
        compare(run);
        compared += 1;
    }
    assert!(compared >= least, "{compared} runs");
}
