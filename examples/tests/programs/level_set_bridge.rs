//! The program `level_set_bridge` as a user runs it, with few cells: its gradient, its descent, and its resumption after it was killed.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::interrupted::killed_until_it_ends;
use crate::printed::after;

fn command(directory: &Path, cells: &str, steps: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_level_set_bridge"));
    command.args(["--cells", cells, "--steps", steps, "--out"]).arg(directory);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Killed again and again at whatever moment it was, the program ends with the files of an undisturbed run, byte for byte.
#[test]
fn a_bridge_that_is_killed_ends_as_one_that_is_not() {
    let directory = tempfile::tempdir().expect("a directory");
    let (calm, rough) = (directory.path().join("calm"), directory.path().join("rough"));
    let output = command(&calm, "24", "30").output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");

    let slope = after(&printed, "dJ along a wave ");
    assert!((after(&printed, "by differences ") / slope - 1.0).abs() < 1e-6, "{printed}");
    assert!((after(&printed, "order of the Taylor test ") - 2.0).abs() < 0.05, "{printed}");
    let [first, last] = ["at first: ", "at last: "].map(|name| {
        let line = printed.split(name).nth(1).expect("the line");
        assert!((after(line, "contact force ") / 2.5 - 1.0).abs() < 1e-6, "{printed}");
        let voids: usize =
            line.split(", ").nth(1).and_then(|text| text.split(' ').next()?.parse().ok()).expect("a number");
        (after(line, "J = "), voids)
    });
    // Holes have merged.
    assert!(last.0 < 0.85 * first.0 && last.1 < first.1, "{first:?} {last:?}");
    let bytes = std::fs::read(calm.join("level_set_bridge.png")).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000);

    let kills = killed_until_it_ends(|| command(&rough, "24", "30"), Duration::from_millis(300));
    for name in ["history.csv", "checkpoint.json", "bridge.vtu"] {
        let [calm, rough] = [&calm, &rough].map(|run| std::fs::read(run.join(name)).expect("a file"));
        assert!(calm == rough, "{name} differs after {kills} kills");
    }
    // More steps go on; other cells are refused.
    let output = command(&calm, "16", "30").output().expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("the checkpoint was made with cells = 24, not 16"), "{errors}");
    let output = command(&calm, "10", "30").output().expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("--cells 10: it must be a multiple of eight"), "{errors}");
}
