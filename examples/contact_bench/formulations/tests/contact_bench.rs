//! The program as a user runs it, on coarse meshes: files, rows, known numbers, reasons.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The rows of a run.
fn run(arguments: &[&str], directory: &Path) -> Vec<Value> {
    let output =
        Command::new(env!("CARGO_BIN_EXE_contact_bench")).args(arguments).current_dir(directory).output();
    let output = output.expect("it starts");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    let json = std::fs::read_to_string(directory.join("out/contact_bench/contact_bench.json")).expect("JSON");
    let table =
        std::fs::read_to_string(directory.join("out/contact_bench/contact_bench.md")).expect("a table");
    assert!(printed.starts_with(&table), "{printed}");
    serde_json::from_str(&json).expect("it can be read")
}

/// The rows of Nitsche's method and the augmented Lagrangian on two meshes, with degree 2.
fn on_two_meshes(problems: &str) -> Vec<Value> {
    let directory = tempfile::tempdir().expect("a directory");
    let formulations = "nitsche θ = -1,augmented";
    let asked = ["--problems", problems, "--formulations", formulations, "--degrees", "2", "--levels", "2"];
    run(&asked, directory.path())
}

fn text(row: &Value, name: &str) -> String {
    row[name].as_str().unwrap_or_default().to_owned()
}

/// A number of a solution.
fn number(row: &Value, name: &str) -> f64 {
    row["answer"]["solved"][name].as_f64().unwrap_or(f64::NAN)
}

/// A number that the problem asks for.
fn quantity(row: &Value, name: &str) -> f64 {
    let all = row["answer"]["solved"]["quantities"].as_array().expect("quantities");
    let of_name = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {all:?}"));
    of_name["value"].as_f64().expect("a number")
}

#[test]
fn every_formulation_has_a_row_with_numbers_or_a_reason() {
    let directory = tempfile::tempdir().expect("a directory");
    let rows =
        run(&["--problems", "patch,hertz,half_ball", "--levels", "1", "--degrees", "2"], directory.path());
    assert!(rows.len() >= 45, "{}", rows.len());
    for row in &rows {
        let label = format!("{}, {}", text(row, "problem"), text(row, "formulation"));
        let answer = row["answer"].as_object().expect("an answer");
        match answer.iter().next().map(|(kind, value)| (kind.as_str(), value)) {
            Some(("solved", _)) => assert!(number(row, "newton") >= 1.0, "{label}"),
            Some(("failed" | "not_defined", why)) => {
                assert!(why.as_str().is_some_and(|why| !why.is_empty()), "{label}")
            }
            other => panic!("{label}: {other:?}"),
        }
    }
    let patch = |formulation: &str| {
        let is_it = |row: &&Value| text(row, "problem") == "patch" && text(row, "formulation") == formulation;
        rows.iter().find(is_it).unwrap_or_else(|| panic!("no {formulation}"))
    };
    for formulation in [
        "nitsche θ = -1",
        "nitsche θ = 0, unbiased",
        "nitsche θ = 1",
        "augmented Lagrangian",
        "penalty 100 E/h",
    ] {
        let row = patch(formulation);
        assert!(number(row, "pressure_error") < 1e-9, "{formulation}: {row}");
        assert!(number(row, "force_balance") < 1e-12, "{formulation}: {row}");
        let fallen = quantity(row, "u_y of the top");
        assert!(formulation.starts_with("penalty") || (fallen + 2.0 * 0.91 + 1e-3).abs() < 1e-9, "{fallen}");
    }
    for what in ["hertz_pressures", "half_ball_pressures", "patch_pressures"] {
        assert!(directory.path().join(format!("out/contact_bench/{what}.png")).exists(), "{what}");
    }
}

#[test]
fn known_pressures_are_met_with_order_two() {
    let rows = on_two_meshes("lame,shrink_fit");
    for pair in rows.chunks(2).filter(|pair| text(&pair[0], "problem") == "lame") {
        let label = text(&pair[0], "formulation");
        let errors = [0, 1].map(|level| (quantity(&pair[level], "mean pressure") - 0.15625).abs());
        assert!(errors[1] < 2e-4 && (errors[0] / errors[1]).log2() > 1.8, "{label}: {errors:?}");
    }
    for row in rows.iter().filter(|row| text(row, "problem") == "shrink_fit" && row["level"] == 1) {
        let exact = 1.171875e-4 / 0.91;
        // Both surfaces of unlike facets overlap by different gaps.
        let tolerance = if text(row, "formulation").contains("unbiased") { 5e-3 } else { 1e-3 };
        assert!(
            (quantity(row, "mean pressure") / exact - 1.0).abs() < tolerance,
            "{exact}: {}",
            row["formulation"]
        );
    }
}

/// Cases are computed at the same time, each on one thread: only their seconds differ.
#[test]
fn rows_are_the_same_on_any_number_of_threads() {
    let rows = ["1", "3"].map(|threads| {
        let directory = tempfile::tempdir().expect("a directory");
        let asked = ["--problems", "patch,hertz", "--formulations", "nitsche,mortar", "--levels", "2"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_contact_bench"));
        let output = command.args(asked).env("FORMS_THREADS", threads).current_dir(directory.path()).output();
        assert!(output.expect("it starts").status.success());
        let json = directory.path().join("out/contact_bench/contact_bench.json");
        let mut rows: Vec<Value> =
            serde_json::from_str(&std::fs::read_to_string(json).expect("JSON")).expect("it can be read");
        for row in &mut rows {
            if let Some(solved) = row["answer"]["solved"].as_object_mut() {
                solved.remove("seconds");
            }
        }
        rows
    });
    // Two problems and degrees; mortar has no row on finer meshes of the rigid parabola, where it does not exist.
    assert!(rows[0].len() > 40 && rows[0].iter().any(|row| !row["answer"]["not_defined"].is_null()));
    assert_eq!(rows[0], rows[1]);
}

/// Pages write formulations with a capital letter.
#[test]
fn names_are_found_in_small_and_capital_letters() {
    let directory = tempfile::tempdir().expect("a directory");
    let asked =
        ["--problems", "Hertz", "--formulations", "Nitsche θ = -1", "--degrees", "1", "--levels", "1"];
    let rows = run(&asked, directory.path());
    let names: Vec<_> = rows.iter().map(|row| (text(row, "problem"), text(row, "formulation"))).collect();
    let expected =
        ["nitsche θ = -1", "nitsche θ = -1, unbiased"].map(|name| ("hertz".to_owned(), name.to_owned()));
    assert_eq!(names, expected);
}

/// A surface that no mesh fits has the known numbers, too; those of the ball, the ring and the membrane are curved.
#[test]
fn a_cut_body_has_known_pressures_and_forces() {
    let directory = tempfile::tempdir().expect("a directory");
    let asked = [
        "--problems",
        "hertz,wavy,half_ball,patch,lame,obstacle,shrink_fit",
        "--formulations",
        "cut",
        "--degrees",
        "2",
        "--levels",
        "2",
    ];
    let rows = run(&asked, directory.path());
    assert_eq!(rows.iter().filter(|row| row["level"] == 1).count(), 12);
    for row in rows.iter().filter(|row| row["level"] == 1) {
        let label = format!("{}, {}", text(row, "problem"), text(row, "formulation"));
        let known = match text(row, "problem").as_str() {
            "hertz" => ("force", 0.00215769, 1e-3),
            "wavy" => ("mean pressure/p*", 0.5, 1e-4),
            "half_ball" => ("reaction", 277.4, 1.5e-3),
            "lame" => ("mean pressure", 0.15625, 2e-4),
            "obstacle" => ("energy", 0.453542954841, 2e-4),
            _ => {
                // A uniform stress is in the space.
                assert!(number(row, "pressure_error") < 1e-9, "{label}: {row}");
                continue;
            }
        };
        let found = quantity(row, known.0);
        assert!((found / known.1 - 1.0).abs() < known.2, "{label}: {found}");
    }
    for row in rows.iter().filter(|row| row["level"] == 0) {
        let gradient = &row["answer"]["solved"]["gradient"];
        let (Some(adjoint), Some(difference)) =
            (gradient["adjoint"].as_f64(), gradient["difference"].as_f64())
        else {
            // No support moves, or no cut body is given.
            let problem = text(row, "problem");
            assert!(["lame", "obstacle", "shrink_fit"].contains(&problem.as_str()), "{row}");
            assert_eq!(problem == "shrink_fit", !row["answer"]["not_defined"].is_null(), "{row}");
            continue;
        };
        assert!((adjoint / difference - 1.0).abs() < 1e-6, "{adjoint} {difference}: {row}");
    }
    // The end of contact is at an edge of cells of the wave.
    let of = |problem: &str| -> Vec<f64> {
        let found = rows.iter().filter(|row| row["problem"] == problem);
        found.map(|row| number(row, "pressure_error")).collect()
    };
    let (wave, parabola) = (of("wavy"), of("hertz"));
    assert!(wave.chunks(2).all(|pair| pair[1] < 0.4 * pair[0] && pair[1] < 2e-3), "{wave:?}");
    assert!(parabola.iter().all(|error| *error < 5e-2), "{parabola:?}");
    let ring = of("lame");
    assert!(ring.chunks(2).all(|pair| pair[1] < 0.25 * pair[0] && pair[1] < 2e-2), "{ring:?}");
    let membrane: Vec<f64> =
        rows.iter().filter(|row| row["problem"] == "obstacle").map(|row| quantity(row, "H1 error")).collect();
    assert!(membrane.chunks(2).all(|pair| pair[1] < 0.5 * pair[0] && pair[1] < 2e-2), "{membrane:?}");
}

#[test]
fn a_name_that_does_not_exist_is_refused_with_those_that_do() {
    let asked = ["--problems", "hertzz"];
    let output = Command::new(env!("CARGO_BIN_EXE_contact_bench")).args(asked).output().expect("it starts");
    assert!(!output.status.success());
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("hertzz") && told.contains("patch"), "{told}");
}

/// Parts of a punch's force end at nodes, by every formulation with good pressures: a cut facet is off by the force between two of its points.
#[test]
fn parts_of_the_force_of_a_punch_are_those_of_the_finite_block() {
    let rows = on_two_meshes("punch");
    for row in rows.iter().filter(|row| !row["answer"]["solved"].is_null()) {
        let label = text(row, "formulation");
        let tolerance = if row["level"] == 0 { 1.5e-3 } else { 4e-4 };
        for (name, known) in [("part of F within a/2", 0.3338), ("part of F within 0.8 a", 0.5909)] {
            let part = quantity(row, name);
            assert!((part - known).abs() < tolerance, "{label}, {}, {name}: {part}", row["level"]);
        }
        if row["level"] == 0 {
            let gradient = &row["answer"]["solved"]["gradient"];
            let [adjoint, difference] =
                ["adjoint", "difference"].map(|name| gradient[name].as_f64().unwrap());
            assert!((adjoint / difference - 1.0).abs() < 1e-7, "{label}: {adjoint} {difference}");
        }
    }
}
