//! The program `level_set_cantilever` as a user runs it, with few cells: holes in a full plate, and its resumption after it was killed.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::interrupted::killed_until_it_ends;

fn command(directory: &Path, cells: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_level_set_cantilever"));
    command.args(["--cells", cells, "--steps", "40", "--out"]).arg(directory);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[test]
fn a_full_plate_gets_holes_with_the_same_bits_after_kills() {
    let directory = tempfile::tempdir().expect("a directory");
    let (calm, rough) = (directory.path().join("calm"), directory.path().join("rough"));
    let output = command(&calm, "32").output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");
    // Start, given holes, new holes, J at first, J at last, voids at last.
    let row = |start: &str| -> Vec<f64> {
        let line = printed.lines().find(|line| line.starts_with(&format!("| {start} |"))).expect("its row");
        line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect()
    };
    let (full, given) = (row("full plate"), row("given holes"));
    assert!(full[0] == 0.0 && full[1] >= 3.0 && full[4] >= 1.0, "{printed}");
    assert!(full[3] < 0.9 * full[2], "{printed}");
    assert!(given[0] == 18.0 && given[1] == 0.0 && given[3] < given[2], "{printed}");

    let kills = killed_until_it_ends(|| command(&rough, "32"), Duration::from_millis(100));
    for name in ["full/history.csv", "full/checkpoint.json", "given/history.csv"] {
        let [calm, rough] = [&calm, &rough].map(|run| std::fs::read(run.join(name)).expect("a file"));
        assert!(calm == rough, "{name} differs after {kills} kills");
    }
    let output = command(&calm, "24").output().expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("--cells 24: it must be a multiple of sixteen"), "{errors}");
}
