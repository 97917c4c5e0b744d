//! The program `closing_c` as a user runs it, with few cells: its gradient, its descent, and the same body with contact pairs.

use std::process::Command;

/// The number after some words.
fn after(printed: &str, words: &str) -> f64 {
    let rest = printed.split(words).nth(1).unwrap_or_else(|| panic!("`{words}`: {printed}"));
    let number: String = rest.chars().take_while(|c| c.is_ascii_digit() || "+-.e".contains(*c)).collect();
    number.parse().unwrap_or_else(|error| panic!("`{words}` {number}: {error}"))
}

#[test]
fn densities_push_back_through_a_third_medium() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut command = Command::new(env!("CARGO_BIN_EXE_closing_c"));
    let output =
        command.args(["8", "20"]).current_dir(directory.path()).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");
    let slope = after(&printed, "dJ along sin(7x + 3y): ");
    assert!((after(&printed, "by differences ") / slope - 1.0).abs() < 1e-7, "{printed}");
    assert!((after(&printed, "order of the Taylor test ") - 2.0).abs() < 0.05, "{printed}");
}
