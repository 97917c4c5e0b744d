//! Contact in the volume, with a mesh of the gap, and of rubber, compared with closed forms and other programs.

mod rows;

use rows::{quantity, rows, run};
use serde_json::Value;

#[test]
fn a_membrane_has_the_energy_and_force_of_its_closed_form() {
    let formulations = "nitsche θ = 0,penalty 100 E/h,dual,log barrier";
    let two = ["--problems", "obstacle", "--degrees", "2", "--levels", "2", "--formulations", formulations];
    let all = rows(&two);
    let names = [
        "nitsche θ = 0",
        "penalty 100 E/h",
        "dual multipliers (bounds at nodes)",
        "log barrier, ĝ/d = 0.1",
        "log barrier, ĝ/d = 0.01",
    ];
    for label in names {
        let pair: Vec<&Value> = all.iter().filter(|row| row["formulation"] == label).collect();
        assert_eq!(pair.len(), 2, "{label}: {pair:?}");
        // A barrier of a fixed reach converges to another solution.
        let [energy, least_order] = match label {
            "log barrier, ĝ/d = 0.1" => [1.2e-2, 1.2],
            "penalty 100 E/h" => [4e-3, 1.4],
            _ => [1.5e-3, 1.4],
        };
        let errors = [0, 1].map(|level: usize| quantity(pair[level], "H1 error"));
        assert!((errors[0] / errors[1]).log2() > least_order, "{label}: {errors:?}");
        assert!((quantity(pair[1], "energy") - 0.453542954841).abs() < energy, "{label}");
        assert!((quantity(pair[1], "force") - 2.137097970934).abs() < 4e-2, "{label}");
    }
}

/// MFEM's example 36 takes 9 to 19 outer steps with 11 to 21 Newton steps on these meshes.
#[test]
fn proximal_galerkin_with_one_step_each_takes_as_few_steps_on_each_mesh() {
    let formulations = "proximal Galerkin (";
    let asked = ["--problems", "obstacle", "--degrees", "2", "--levels", "3", "--formulations", formulations];
    let all = rows(&asked);
    let of = |name: &str, level: usize| {
        let row = all.iter().find(|row| row["formulation"] == name && row["level"] == level);
        row.unwrap_or_else(|| panic!("no {name}"))
    };
    for level in 0..3 {
        let short = of("proximal Galerkin (ψ in cells), one step each", level);
        let whole = of("proximal Galerkin (ψ in cells)", level);
        for steps in ["newton", "outer"] {
            let steps = short["answer"]["solved"][steps].as_u64();
            assert!(steps.is_some_and(|steps| (9..=13).contains(&steps)), "{short}");
        }
        let [a, b] = [short, whole].map(|row| quantity(row, "energy"));
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    let finest = of("proximal Galerkin (ψ in cells), one step each", 2);
    assert!((quantity(finest, "energy") - 0.453542954841).abs() < 5e-4);
    assert!((quantity(finest, "contact radius") - 0.348982574).abs() < 1e-2);
}

/// Forces of felupe and NGSolve, which agree to 2e-11.
#[test]
fn a_closing_c_has_the_forces_of_two_other_programs_and_an_exact_gradient() {
    let asked = ["--problems", "closing_c", "--degrees", "2", "--levels", "1", "--formulations", "third"];
    let all = rows(&asked);
    let row = all.iter().find(|row| row["formulation"] == "third medium").expect("a row");
    let known = [
        ("F(1)", 1.33196155e-5),
        ("F(5)", 6.73803462e-5),
        ("F(10)", 1.48316229e-4),
        ("F(15)", 3.08914658e-4),
        ("F(20)", 6.78987133e-4),
    ];
    for (name, force) in known {
        assert!((quantity(row, name) / force - 1.0).abs() < 5e-9, "{name}: {}", quantity(row, name));
    }
    assert!(row["answer"]["solved"]["newton"].as_u64().is_some_and(|steps| steps <= 96));
    let gradient = &row["answer"]["solved"]["gradient"];
    let [adjoint, difference] = ["adjoint", "difference"].map(|name| gradient[name].as_f64().unwrap());
    assert!((adjoint / difference - 1.0).abs() < 1e-8, "{adjoint} {difference}");
}

#[test]
fn a_half_ring_has_the_force_of_two_other_programs() {
    let formulations = "nitsche θ = 0,augmented";
    let asked =
        ["--problems", "half_ring", "--degrees", "2", "--levels", "2", "--formulations", formulations];
    let fine: Vec<Value> = rows(&asked).into_iter().filter(|row| row["level"] == 1).collect();
    assert_eq!(fine.len(), 2, "{fine:?}");
    for row in fine {
        let force = quantity(&row, "F(2)");
        assert!((force / 4.589 - 1.0).abs() < 4e-3, "{}: {force}", row["formulation"]);
        let growth = quantity(&row, "∫(J − 1) there");
        assert!((growth + 0.1342).abs() < 3e-4, "{}: {growth}", row["formulation"]);
    }
}

/// What is held open by ĝ/2 or c presses more at small ways.
#[test]
fn a_half_ring_has_this_force_by_outer_iterations_and_barriers() {
    let formulations = "uzawa,proximal Galerkin,log barrier";
    let asked =
        ["--problems", "half_ring", "--degrees", "2", "--levels", "1", "--formulations", formulations];
    let all = rows(&asked);
    for (formulation, tolerance) in
        [("uzawa", 2e-2), ("proximal Galerkin", 2e-2), ("log barrier, ĝ/d = 0.01", 3e-2)]
    {
        let row = all.iter().find(|row| row["formulation"] == formulation).expect("a row");
        let force = quantity(row, "F(2)");
        assert!((force / 4.589 - 1.0).abs() < tolerance, "{formulation}: {force}");
        let growth = quantity(row, "∫(J − 1) there");
        assert!((growth + 0.1342).abs() < 1e-3, "{formulation}: {growth}");
    }
}

/// 64 facets along, most of them far from contact, where multipliers fall from node to node below the rounding of the system.
#[test]
fn multipliers_far_from_contact_are_found_on_a_finer_mesh() {
    let formulations = "augmented,dual";
    let asked =
        ["--problems", "half_ring", "--degrees", "1", "--levels", "3", "--formulations", formulations];
    let fine: Vec<Value> = rows(&asked).into_iter().filter(|row| row["level"] == 2).collect();
    for name in ["F(2)", "F(10)"] {
        let [multipliers, bounds] = [0, 1].map(|row| quantity(&fine[row], name));
        assert!((multipliers / bounds - 1.0).abs() < 2e-3, "{name}: {multipliers} {bounds}");
    }
}

#[test]
fn rows_of_other_programs_are_in_the_table() {
    let directory = tempfile::tempdir().expect("a directory");
    let line = r#"{"problem": "obstacle", "formulation": "another", "degree": 1, "level": 0, "unknowns": 89, "seconds": 1.0, "newton": [3, 1], "outer": 2, "numbers": {"H1 error": 0.2}}"#;
    std::fs::write(directory.path().join("others.jsonl"), format!("{line}\n")).expect("a file");
    let asked = ["--problems", "obstacle", "--degrees", "1", "--levels", "1", "--formulations", "dual"];
    let found = run(&[&asked[..], &["--others", "others.jsonl"]].concat(), directory.path());
    let row = found.iter().find(|row| row["formulation"] == "another").expect("its row");
    assert_eq!(row["answer"]["solved"]["newton"], 4);
    assert_eq!(quantity(row, "H1 error"), 0.2);
}
