//! The program `level_set_wheel` as a user runs it, with few cells: its gradient, a descent that holds volume and pattern, the wall, and
//! its resumption after it was killed.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::interrupted::killed_until_it_ends;
use crate::printed::after;

fn command(directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_level_set_wheel"));
    command.args(["--cells", "10", "--steps", "5", "--last-steps", "5", "--out"]).arg(directory);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[test]
fn holes_of_a_coarse_wheel_move_in_their_pattern() {
    let directory = tempfile::tempdir().expect("a directory");
    let (calm, rough) = (directory.path().join("calm"), directory.path().join("rough"));
    let output = command(&calm).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");
    for number in ["(21)", "(22)"] {
        let part = printed.split(&format!("with the adjoint {number}, ")).nth(1).expect("its lines");
        let (slope, difference) = (after(part, "dJ along a wave "), after(part, "by differences "));
        // That of (21) is the derivative of what is computed, that of (22) of the continuous problem.
        let exact = if number == "(21)" { 1e-8 } else { 1e-3 };
        assert!((slope / difference - 1.0).abs() < exact, "{number}: {slope} {difference}");
        let last = printed.split(&format!("{number}: J = ")).nth(1).expect("its line");
        assert!(after(last, "volume off by ").abs() < 1e-3 && after(last, "wall ") > 0.2, "{printed}");
        assert!(after(last, "pattern off by ") < 1e-9, "{printed}");
        let start = format!("| {number} at last |");
        let row = printed.lines().find(|line| line.starts_with(&start)).expect("its row");
        let numbers: Vec<f64> = row.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        assert!(
            numbers[0] < last.split(' ').next().and_then(|text| text.parse().ok()).expect("J"),
            "{printed}"
        );
    }
    let order = after(&printed, "order of the Taylor test ");
    assert!((order - 2.0).abs() < 0.05, "{printed}");
    let bytes = std::fs::read(calm.join("level_set_wheel.png")).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000);

    let kills = killed_until_it_ends(|| command(&rough), Duration::from_millis(700));
    for adjoint in ["adjoint_21", "adjoint_22"] {
        for name in
            ["smooth/history.csv", "smooth/checkpoint.json", "length/history.csv", "length/checkpoint.json"]
        {
            let [calm, rough] =
                [&calm, &rough].map(|run| std::fs::read(run.join(adjoint).join(name)).expect("a file"));
            assert!(calm == rough, "{adjoint}/{name} differs after {kills} kills");
        }
    }
}
