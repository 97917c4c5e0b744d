//! The program `convergence` as a user runs it, on coarse meshes.

use std::path::Path;
use std::process::{Command, Output};

fn run(arguments: &[&str], directory: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_convergence"));
    command.args(arguments).current_dir(directory).output().expect("the program starts")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn figures_stand_beside_their_tables() {
    let directory = tempfile::tempdir().expect("a directory");
    let output =
        run(&["--reference", "16", "--coarsest", "2", "--split", "--out", "results"], directory.path());
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results = directory.path().join("results");
    for figure in ["figure_3_left", "figure_3_right", "figure_4_left", "figure_4_right", "figure_5"] {
        for (ending, start) in [("png", &b"\x89PNG"[..]), ("svg", b"<")] {
            let bytes = std::fs::read(results.join(format!("{figure}_theta_-1.{ending}"))).expect("a figure");
            assert!(bytes.starts_with(start) && bytes.len() > 5000, "{figure}.{ending}");
        }
    }
    // Errors of u, p and p̃ in the full norm, in this order of size, falling from mesh to mesh.
    let table = read(&results.join("figure_5_theta_-1.csv"));
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|number| number.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [2.0, 4.0]);
    for row in &rows {
        assert!(row[2] < row[5] && row[5] < row[8], "{row:?}");
        assert!((row[2].powi(2) / row[4] - 1.0).abs() < 1e-12, "the squared ratio: {row:?}");
    }
    for column in [2, 5, 8] {
        assert!(rows[1][column] < rows[0][column], "{rows:?}");
    }
    // The map's numbers: at each node of the finest mesh, largest somewhere on the contact boundary or near it.
    let map = read(&results.join("figure_4_left_theta_-1.csv"));
    let numbers: Vec<f64> = map
        .lines()
        .skip(1)
        .map(|line| line.rsplit(',').next().expect("a column").parse().expect("a number"))
        .collect();
    // Q2 on 4 × 64 cells.
    assert_eq!(numbers.len(), 9 * 128);
    assert!(
        numbers.iter().all(|value| value.is_finite() && *value >= 0.0)
            && numbers.iter().any(|value| *value > 0.0)
    );
    // Contact zones are found inside facets: no length is a multiple of a quadrature point's share.
    let zones = read(&results.join("figure_3_right_theta_-1.csv"));
    assert_eq!(zones.lines().count(), 4, "{zones}");
    assert!(read(&results.join("split_facets_theta_-1.csv")).lines().count() == 4);
    for words in ["θ = −1, reference n_r = 16", "Contact zone of the reference: 12.", "split at the zeros"]
    {
        assert!(printed.contains(words), "{words} is not in\n{printed}");
    }
}

#[test]
fn meshes_that_give_no_order_are_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    for (arguments, words) in [
        (["--reference", "7", "--coarsest", "2"], "--reference 7"),
        (["--reference", "64", "--coarsest", "1"], "--coarsest 1"),
        (["--reference", "64", "--theta", "nan"], "theta"),
    ] {
        let output = run(&arguments, directory.path());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && error.contains(words), "{error}");
        assert!(std::fs::read_dir(directory.path()).expect("a directory").next().is_none());
    }
}
