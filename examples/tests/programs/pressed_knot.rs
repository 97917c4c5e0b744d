//! The program `pressed_knot` as a user runs it, with few cells.

use std::process::Command;

use crate::printed::after;

#[test]
fn knot_from_a_file_is_pressed_by_both_plates() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut command = Command::new(env!("CARGO_BIN_EXE_pressed_knot"));
    command.args(["--cells", "4", "--fitted", "0", "--out"]).arg(directory.path());
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");
    // Nothing but the plates carries the knot.
    let [lower, upper] = [after(&printed, "forces "), after(&printed, " and ")];
    assert!((lower / upper - 1.0).abs() < 1e-4, "{printed}");
    // Coarse cells are stiff: fine ones come below 1.
    assert!((0.9..2.1).contains(&lower), "{printed}");
    let [volume, of] = [after(&printed, "volume "), after(&printed, " of ")];
    assert!((volume / of - 1.0).abs() < 0.05, "{printed}");
    let bytes = std::fs::read(directory.path().join("pressed_knot.png")).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000);
}
