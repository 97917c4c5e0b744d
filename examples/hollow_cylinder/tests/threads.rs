//! The number of threads of the main job: where it comes from, and that no result depends on it.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn run(threads: &str, arguments: &[&str], directory: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hollow_cylinder"));
    command.env("FORMS_THREADS", threads).args(arguments).current_dir(directory);
    command.output().expect("the program starts")
}

/// The numbers in the JSON file, the number of threads, and the bytes of all other files.
fn results(threads: &str, arguments: &[&str]) -> (Value, u64, BTreeMap<String, Vec<u8>>) {
    let directory = tempfile::tempdir().expect("a directory");
    let output = run(threads, &[&["--json", "result.json"], arguments].concat(), directory.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = std::fs::read_to_string(directory.path().join("result.json")).expect("the JSON file");
    let mut json: Value = serde_json::from_str(&json).expect("JSON");
    let object = json.as_object_mut().expect("an object");
    let clocks = ["seconds", "peak_rss_mb"].map(|name| object.remove(name));
    assert!(clocks.iter().all(Option::is_some));
    let settings = object["settings"].as_object_mut().expect("an object");
    let count = settings.remove("threads").and_then(|threads| threads.as_u64()).expect("a number");
    let files = std::fs::read_dir(directory.path().join("out")).expect("the results");
    let files = files.map(|file| {
        let path = file.expect("a file").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        (name, std::fs::read(path).expect("bytes"))
    });
    (json, count, files.collect())
}

#[test]
fn numbers_files_and_pictures_do_not_depend_on_the_number_of_threads() {
    // Several runs of 1024 cells.
    let (json, _, files) = results("1", &["--radial", "16"]);
    assert!(files.len() > 4, "{:?}", files.keys());
    for threads in ["2", "3", "7", "16"] {
        let (others, count, same) = results(threads, &["--radial", "16"]);
        assert_eq!(count.to_string(), threads);
        assert_eq!(json, others, "{threads} threads");
        for (name, bytes) in &files {
            assert!(same[name] == *bytes, "{name} on {threads} threads");
        }
    }
    // The option comes before the environment.
    assert_eq!(results("3", &["--radial", "2", "--threads", "2"]).1, 2);
}

#[test]
fn a_wrong_number_of_threads_is_named() {
    let directory = tempfile::tempdir().expect("a directory");
    for (value, reason) in [("many", "a whole number"), ("0", "at least one"), ("100000", "at most 1024")] {
        let output = run(value, &["--radial", "2"], directory.path());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{value}");
        assert!(message.contains(&format!("FORMS_THREADS is \"{value}\": {reason}")), "{message}");
    }
}
