//! The program `closing_c` as a user runs it, with few cells: its gradient, its ascent, and the same bodies with contact pairs.

use std::process::Command;

use crate::printed::after;

#[test]
fn densities_hold_an_arm_that_closes_onto_them() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut command = Command::new(env!("CARGO_BIN_EXE_closing_c"));
    let output =
        command.args(["8", "10"]).current_dir(directory.path()).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");

    // With even densities and with those that were found, when the medium is crushed.
    let checks: Vec<&str> = printed.lines().filter(|line| line.starts_with("slope along")).collect();
    assert_eq!(checks.len(), 2, "{printed}");
    for line in checks {
        let slope = after(line, "sin(7x + 3y): ");
        assert!((after(line, "by differences ") / slope - 1.0).abs() < 1e-7, "{line}");
        assert!((after(line, "order of the Taylor test ") - 2.0).abs() < 0.05, "{line}");
    }
    let first = after(&printed, "| 2 | 0 | ");
    let forces = |name: &str| {
        let row = format!("| {name} | ");
        let rest = printed.split(&row).nth(1).expect("the row");
        [after(&printed, &row), after(rest, " | ")]
    };
    let [bar, whole, fitted] =
        ["a bar of the same area", "what was found, in whole cells", "what was found, on triangles that fit"]
            .map(forces);
    // The medium and the pairs are two models of one contact, and here they agree on 1.5 to 2.2 % from 16 × 8 to 32 × 16 cells. A body
    // without contact, or with that of other cells, differs by a factor.
    for [medium, pairs] in [bar, whole] {
        assert!((medium / pairs - 1.0).abs() < 0.04, "{printed}");
    }
    // After few iterations many densities are between body and medium. They are softer than the parts of a body and of medium that fit.
    assert!((-0.25..0.0).contains(&(fitted[0] / fitted[1] - 1.0)), "{printed}");
    assert!(after(&printed, "area on triangles over its limit: ").abs() < 0.15, "{printed}");
    // Below the gap even densities and a bar hold the arm little.
    for found in [whole[1], fitted[1]] {
        assert!(found > 1.5 * first && found > 1.5 * bar[1], "{printed}");
    }
    for name in ["closing_c.png", "closing_c_animation.png"] {
        assert!(directory.path().join("out").join(name).exists(), "{name}");
    }
}
