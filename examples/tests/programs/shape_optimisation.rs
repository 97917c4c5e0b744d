//! The program `shape_optimisation`: its output, and its resumption after it was killed.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::interrupted::killed_until_it_ends;

/// A coarse ring with few holes, few steps.
const COARSE: [&str; 13] = [
    "figure-6",
    "--holes",
    "8",
    "--hole-radius",
    "3",
    "--cells-per-side",
    "2",
    "--layers",
    "2",
    "--steps",
    "12",
    "--every",
    "4",
];

fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shape_optimisation"));
    command.args(arguments).arg("--out").arg(directory).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(directory: &Path, arguments: &[&str]) -> String {
    let output = command(directory, arguments).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// All files below a directory that hold numbers of the descent, by name.
fn numbers_in(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for run in ["adjoint_22", "adjoint_21"] {
        for entry in std::fs::read_dir(directory.join(run)).expect("a directory") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().into_string().expect("text");
            // What a killed process was writing is left next to it.
            if !name.starts_with('.') && !name.ends_with(".png") {
                let bytes = std::fs::read(entry.path()).expect("a file");
                files.insert(format!("{run}/{name}"), bytes);
            }
        }
    }
    files
}

/// A column of a history, by its place.
fn column(csv: &[u8], place: usize) -> Vec<f64> {
    let text = std::str::from_utf8(csv).expect("text");
    text.lines()
        .skip(1)
        .map(|line| line.split(',').nth(place).expect("a column").parse().expect("a number"))
        .collect()
}

/// Killed again and again at whatever moment it was, the program ends with the files of an undisturbed run, byte for byte.
/// FORMS_SWEEPS=1: a longer run.
#[test]
fn a_descent_that_is_killed_ends_as_one_that_is_not() {
    let directory = tempfile::tempdir().expect("a directory");
    let (calm, rough) = (directory.path().join("calm"), directory.path().join("rough"));
    let mut arguments = COARSE;
    if std::env::var_os("FORMS_SWEEPS").is_none() {
        arguments[10] = "4";
    }
    let printed = run(&calm, &arguments);
    let kills = killed_until_it_ends(|| command(&rough, &arguments), Duration::from_millis(120));
    let (calm, rough) = (numbers_in(&calm), numbers_in(&rough));
    assert_eq!(calm.keys().collect::<Vec<_>>(), rough.keys().collect::<Vec<_>>());
    for (name, bytes) in &calm {
        assert!(rough[name] == *bytes, "{name} differs after {kills} kills");
    }
    // What it shows: less at the same volume, on good cells, the same with both adjoint states.
    for run in ["adjoint_22", "adjoint_21"] {
        let csv = &calm[&format!("{run}/history.csv")];
        let (criteria, constraints, qualities) = (column(csv, 1), column(csv, 2), column(csv, 3));
        assert!(criteria.last() < criteria.first(), "{run}: {criteria:?}");
        assert!(constraints.iter().all(|off| off.abs() < 1e-3), "{run}: {constraints:?}");
        assert!(qualities.iter().all(|quality| *quality > 0.1), "{run}: {qualities:?}");
    }
    assert!(printed.contains("Between the two optimal shapes: at most "), "{printed}");
}

/// Without a step there is still a shape to show; and shapes that were written every n steps are found again when the
/// run goes on with another number.
#[test]
fn a_run_goes_on_with_another_number_of_steps_between_shapes() {
    let directory = tempfile::tempdir().expect("a directory");
    let with = |steps: &'static str, every: &'static str| {
        let mut arguments = COARSE.to_vec();
        (arguments[10], arguments[12]) = (steps, every);
        arguments
    };
    run(directory.path(), &with("0", "4"));
    run(directory.path(), &with("3", "3"));
    run(directory.path(), &with("4", "2"));
    // It has ended: it is shown again.
    run(directory.path(), &with("4", "1"));
    let text = std::fs::read_to_string(directory.path().join("adjoint_21").join("checkpoint.json"));
    let sealed: serde_json::Value = serde_json::from_str(&text.expect("a checkpoint")).expect("JSON");
    let checkpoint = &sealed["checkpoint"];
    assert_eq!(checkpoint["shapes"], serde_json::json!([0, 3, 4]));
    assert_eq!(checkpoint["changeable"], serde_json::json!({ "every": 2, "steps": 4 }));
    assert_eq!(checkpoint["settings"]["version"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn too_many_cells_are_refused() {
    if cfg!(target_os = "linux") {
        for case in ["figure-6", "cantilever"] {
            let directory = tempfile::tempdir().expect("a directory");
            let arguments = [case, "--cells-per-side", "1000000"];
            let output = command(directory.path(), &arguments).output().expect("it starts");
            let errors = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1));
            assert!(
                errors.starts_with("error: --cells-per-side 1000000: ") && errors.contains(" GB"),
                "{errors}"
            );
        }
    }
}

#[test]
fn a_checkpoint_of_other_settings_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let with_steps = |steps: &'static str, more: &[&'static str]| {
        let mut arguments = COARSE.to_vec();
        arguments[10] = steps;
        arguments.extend(more);
        arguments
    };
    run(directory.path(), &with_steps("1", &[]));
    let output =
        command(directory.path(), &with_steps("1", &["--longest-move", "0.1"])).output().expect("it starts");
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        errors.starts_with("error: the checkpoint was made with ") && errors.contains("_move = 0.2, not 0.1"),
        "{errors}"
    );
    // Anew, or with more steps, it goes.
    run(directory.path(), &with_steps("1", &["--longest-move", "0.1", "--anew"]));
    run(directory.path(), &with_steps("2", &["--longest-move", "0.1"]));
    let csv = std::fs::read(directory.path().join("adjoint_21").join("history.csv")).expect("a history");
    assert_eq!(column(&csv, 1).len(), 3);
}
