//! Rows of a run of the program.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The rows of a run in a directory.
pub fn run(arguments: &[&str], directory: &Path) -> Vec<Value> {
    let output = Command::new(env!("CARGO_BIN_EXE_contact_bench"))
        .args(arguments)
        .args(["--out", "out"])
        .current_dir(directory)
        .output();
    let output = output.expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = std::fs::read_to_string(directory.join("out/contact_bench.json")).expect("JSON");
    serde_json::from_str(&json).expect("it can be read")
}

/// The rows of a run in a directory of its own.
pub fn rows(arguments: &[&str]) -> Vec<Value> {
    run(arguments, tempfile::tempdir().expect("a directory").path())
}

/// A number that the problem asks for.
pub fn quantity(row: &Value, name: &str) -> f64 {
    let all = row["answer"]["solved"]["quantities"].as_array().unwrap_or_else(|| panic!("{row}"));
    let of_name = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {all:?}"));
    of_name["value"].as_f64().unwrap_or(f64::NAN)
}
