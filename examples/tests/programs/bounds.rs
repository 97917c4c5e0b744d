//! The programs of bounds as a user runs them, on coarse meshes.

use std::path::Path;
use std::process::Command;

fn run(program: &str, arguments: &[&str], directory: &Path) -> String {
    let output = Command::new(program).args(arguments).current_dir(directory).output().expect("it starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    printed
}

/// The numbers of each row of a table with this many columns; empty cells are left out.
fn rows(printed: &str, columns: usize) -> Vec<Vec<f64>> {
    let cells = |line: &str| line.trim_matches('|').split('|').map(str::trim).map(str::to_owned).collect();
    let lines = printed.lines().map(cells).filter(|cells: &Vec<String>| cells.len() == columns);
    let numbers = |cells: Vec<String>| cells.iter().filter_map(|cell| cell.parse().ok()).collect();
    lines.map(numbers).filter(|numbers: &Vec<f64>| numbers.len() > 3).collect()
}

#[test]
fn an_obstacle_meets_its_closed_form() {
    let directory = tempfile::tempdir().expect("a directory");
    let printed = run(env!("CARGO_BIN_EXE_obstacle"), &["3"], directory.path());
    let radial = rows(&printed, 8);
    let finest = radial.last().expect("rows of a radius");
    assert!((finest[2] - 0.453_542_954_841).abs() < 1e-9, "{printed}");
    assert!((finest[4] - 2.137_097_970_934).abs() < 2e-8, "{printed}");
    assert!((finest[6] - 0.348_982_574_112).abs() < 1e-9, "{printed}");
    assert!(directory.path().join("out/obstacle.png").exists());
}

#[test]
fn a_beam_cracks_and_its_energies_are_the_work() {
    let directory = tempfile::tempdir().expect("a directory");
    let printed = run(env!("CARGO_BIN_EXE_damage"), &["20", "12"], directory.path());
    let steps = rows(&printed, 7);
    assert_eq!(steps.len(), 12, "{printed}");
    let damage: Vec<f64> = steps.iter().map(|step| step[2]).collect();
    assert!(damage.windows(2).all(|pair| pair[1] >= pair[0]) && damage[0] == 0.0, "{printed}");
    let cracked = steps.iter().position(|step| step[2] > 0.9).expect("a crack");
    assert!(cracked > 3, "{printed}");
    for step in &steps[..cracked] {
        // The rest is in the contact, most of it before the tool touches several nodes.
        assert!((step[3] + step[4] - step[5]).abs() < 0.03 * step[5], "{printed}");
    }
    let last = &steps[cracked - 1];
    assert!((last[3] + last[4] - last[5]).abs() < 0.005 * last[5], "{printed}");
    // A crack that runs at once releases more than it costs.
    let after = &steps[cracked];
    assert!(after[3] + after[4] < after[5] && after[1] < 0.3 * steps[cracked - 1][1], "{printed}");
    assert!(directory.path().join("out/damage.png").exists());
}
