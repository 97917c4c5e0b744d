//! The program `hollow_cylinder` as a user runs it: options, exit codes, files, JSON.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

const FILES: [&str; 7] = [
    "adjoint_state.png",
    "contact_pressure.png",
    "displacement.png",
    "figure_2.png",
    "hollow_cylinder.vtu",
    "mesh.png",
    "von_mises.png",
];

fn run(arguments: &[&str], directory: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hollow_cylinder"));
    command.args(arguments).current_dir(directory).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

/// Runs on the coarsest sensible mesh and reads the JSON file.
fn solve(arguments: &[&str], directory: &Path) -> Value {
    let all = [&["--radial", "2", "--json", "result.json"], arguments].concat();
    let output = run(&all, directory);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json = std::fs::read_to_string(directory.join("result.json")).expect("the JSON file");
    serde_json::from_str(&json).expect("JSON")
}

fn names_in(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).expect("a directory");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("text")).collect();
    names.sort();
    names
}

#[test]
fn everything_is_measured_and_written() {
    let directory = tempfile::tempdir().expect("a directory");
    let json = solve(&["--out", "nested/results"], directory.path());
    let results = directory.path().join("nested").join("results");
    assert_eq!(names_in(&results), FILES);
    for name in FILES {
        let bytes = std::fs::read(results.join(name)).expect("a file");
        let start: &[u8] = if name.ends_with(".png") { b"\x89PNG" } else { b"<?xml" };
        assert!(bytes.starts_with(start) && bytes.len() > 5000, "{name}: {} bytes", bytes.len());
    }
    assert_eq!(names_in(directory.path()), ["nested", "result.json"]);
    let number = |name: &str| json[name].as_f64().unwrap_or_else(|| panic!("{name}: {}", json[name]));
    // 2 × 32 cells of degree 2: 5 × 64 nodes with 2 unknowns each.
    assert_eq!(number("unknowns"), 640.0);
    assert_eq!(number("prescribed_unknowns"), 128.0);
    for name in [
        "J",
        "u_l2",
        "u_h1",
        "p_discrete_l2",
        "p_discrete_h1",
        "p_consistent_l2",
        "p_consistent_h1",
        "p_extended_l2",
        "p_extended_h1",
        "contact_force",
        "contact_length",
    ] {
        assert!(number(name) > 0.0, "{name}");
    }
    assert!(number("max_penetration").abs() < 0.1);
    let history = json["newton_history"].as_array().expect("a history");
    assert_eq!(history.len(), 1 + number("newton_iterations") as usize);
    let last = history.last().expect("an iterate");
    assert!(last["relative_residual"].as_f64().is_some_and(|residual| residual <= 1e-10));
    assert!(last["active_points"].as_u64().is_some_and(|count| count > 0));
    assert!(history[0]["step"].is_null());
    for stage in ["assembly", "factorisation", "newton_total", "adjoint", "pictures", "total"] {
        assert!(json["seconds"][stage].as_f64().is_some_and(|seconds| seconds > 0.0), "{stage}");
    }
    let points = json["points"].as_array().expect("points");
    assert_eq!(points.len(), 3);
    for (point, x) in points.iter().zip([[0.0, -25.0], [25.0, 0.0], [0.0, 25.0]]) {
        assert_eq!(point["x"], Value::from(x.to_vec()));
        // The body is symmetric about x = 0, and all of it has moved down.
        assert!(x[0] != 0.0 || point["u"][0].as_f64().is_some_and(|u| u.abs() < 1e-10));
        assert!(point["u"][1].as_f64().is_some_and(|u| (-1.01..-0.3).contains(&u)));
        assert_eq!(point["p"].as_array().map(Vec::len), Some(2));
    }
    if cfg!(target_os = "linux") {
        assert!(number("peak_rss_mb") > 1.0);
    } else {
        assert!(json["peak_rss_mb"].is_null());
    }
    assert_eq!(json["required_gamma0"], 0.0);
    assert_eq!(json["settings"]["gamma0"], 1000.0);
}

/// Two runs differ in nothing but the clock and the memory.
#[test]
fn numbers_are_deterministic() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut runs = [(); 2].map(|()| solve(&["--theta", "0.5"], directory.path()));
    for run in &mut runs {
        let object = run.as_object_mut().expect("an object");
        assert!(object.remove("seconds").is_some() && object.remove("peak_rss_mb").is_some());
    }
    assert_eq!(runs[0], runs[1]);
    assert_eq!(
        names_in(&directory.path().join("out")),
        FILES,
        "out is the directory unless another is given"
    );
}

/// The resultant does not depend on the variant beyond the mesh's error; it is proportional to E.
#[test]
fn options_arrive() {
    let directory = tempfile::tempdir().expect("a directory");
    let force = |arguments: &[&str]| {
        let json = solve(arguments, directory.path());
        json["contact_force"].as_f64().expect("a force")
    };
    let reference = force(&[]);
    assert!((force(&["--young", "200"]) / reference - 2.0).abs() < 1e-9);
    let symmetric = force(&["--theta=1", "--gamma0", "40"]);
    assert!((symmetric / reference - 1.0).abs() < 0.05, "{symmetric} {reference}");
    assert!((force(&["--poisson", "0.4"]) / reference - 1.0).abs() > 0.05);
    let degree = force(&["--degree", "12"]);
    assert!(degree != reference && (degree / reference - 1.0).abs() < 0.05);
}

#[test]
fn a_gamma0_below_the_threshold_is_warned_of() {
    let directory = tempfile::tempdir().expect("a directory");
    let warning = |gamma0: &str, theta: &str| {
        let output = run(&["--radial", "2", "--gamma0", gamma0, "--theta", theta], directory.path());
        let errors = text(&output.stderr);
        errors.lines().find(|line| line.starts_with("warning:")).map(str::to_owned)
    };
    // The threshold at θ = 1 is 9.47 E on fine meshes.
    let line = warning("1", "1").expect("a warning");
    assert!(line.contains("gamma0 = 1 E") && line.contains("theta = 1") && line.contains("--gamma0 above"));
    assert_eq!(warning("40", "1"), None);
    assert_eq!(warning("1", "-1"), None);
}

/// Far below the threshold Newton's method does not converge: the history is printed, no result is written.
#[test]
fn a_failure_is_explained() {
    let directory = tempfile::tempdir().expect("a directory");
    let arguments = ["--radial", "2", "--theta", "1", "--gamma0", "0.001", "--json", "result.json"];
    let output = run(&arguments, directory.path());
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    let errors = text(&output.stderr);
    let last = errors.lines().last().expect("a line");
    assert!(last.starts_with("error: Newton's method failed at iteration"), "{errors}");
    assert!(errors.lines().any(|line| line.trim_start().starts_with("iteration")), "{errors}");
    assert!(errors.lines().any(|line| line.starts_with("warning: gamma0 = 0.001 E")), "{errors}");
    assert_eq!(names_in(directory.path()), ["out"]);
    assert_eq!(names_in(&directory.path().join("out")), Vec::<String>::new());
}

#[test]
fn wrong_options_are_one_line_and_a_code() {
    let directory = tempfile::tempdir().expect("a directory");
    let cases: [(&[&str], &str); 29] = [
        (&["--radial", "many"], "--radial"),
        (&["--radial", "0"], "radial"),
        (&["--radial", "-3"], "--radial"),
        (&["--radial", "2.5"], "--radial"),
        (&["--radial", "3000"], "radial"),
        (&["--theta", "NaN"], "--theta"),
        (&["--theta", "skew"], "--theta"),
        (&["--gamma0", "-1"], "gamma0"),
        (&["--gamma0", "0"], "gamma0"),
        (&["--gamma0", "inf"], "--gamma0"),
        (&["--young", "-5"], "young"),
        (&["--poisson", "0.5"], "poisson"),
        (&["--poisson", "nan"], "--poisson"),
        (&["--degree", "1"], "degree"),
        (&["--degree", "1000"], "degree"),
        (&["--xi", "-0.1"], "xi"),
        (&["--xi"], "--xi"),
        (&["--threads", "0"], "at least one thread"),
        (&["--threads", "1025"], "at most 1024 threads"),
        (&["--threads", "100000000"], "at most 1024 threads"),
        (&["--threads", "1000000000000"], "at most 1024 threads"),
        (&["--threads", "18446744073709551615"], "at most 1024 threads"),
        (&["--threads", "two"], "whole number of threads"),
        (&["--json", ""], "--json"),
        (&["--colour", "blue"], "--colour"),
        (&["--young", "1\n2"], "--young"),
        (&["stray"], "stray"),
        (&["--theta", "1", "--theta", "2"], "--theta"),
        (&["--young", "1e300", "--gamma0", "1e300"], "gamma0"),
    ];
    for (arguments, mentioned) in cases {
        let output = run(arguments, directory.path());
        let errors = text(&output.stderr);
        assert!(output.status.code().is_some_and(|code| code == 1 || code == 2), "{arguments:?}: {errors}");
        assert_eq!(errors.lines().count(), 1, "{arguments:?}: {errors}");
        assert!(errors.starts_with("error: ") && errors.contains(mentioned), "{arguments:?}: {errors}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(names_in(directory.path()), Vec::<String>::new(), "nothing was made");
}

#[test]
fn places_that_cannot_be_written_stop_the_program_at_once() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("file"), "kept").expect("a file");
    for arguments in
        [["--out", "file"], ["--out", "file/below"], ["--json", "file/result.json"], ["--json", "."]]
    {
        let output = run(&arguments, directory.path());
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
        // No line of progress: the computation has not begun.
        assert_eq!(errors.lines().count(), 1, "{arguments:?}: {errors}");
        assert!(errors.starts_with("error: "), "{arguments:?}: {errors}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(std::fs::read_to_string(directory.path().join("file")).expect("a file"), "kept");
}

/// A program that needs more memory than any machine has reports it before it begins.
#[cfg(target_os = "linux")]
#[test]
fn what_needs_too_much_memory_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let output = run(&["--radial", "2000"], directory.path());
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.starts_with("error: --radial 2000: 512128000 unknowns need about 13"), "{errors}");
    assert!(errors.contains("are available (--any-memory"), "{errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    assert_eq!(names_in(directory.path()), Vec::<String>::new(), "nothing was made");
}

/// Results on disk do not depend on who reads the standard output; the exit code reports that it was lost.
#[cfg(target_os = "linux")]
#[test]
fn results_are_written_whatever_the_standard_output_does() {
    let everything_is_there = |directory: &Path| {
        assert_eq!(names_in(&directory.join("out")), FILES);
        let json = std::fs::read_to_string(directory.join("result.json")).expect("the JSON file");
        serde_json::from_str::<Value>(&json).expect("JSON");
    };
    let start = |directory: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hollow_cylinder"));
        command.args(["--radial", "2", "--json", "result.json"]).current_dir(directory);
        command.stderr(Stdio::piped());
        command
    };
    let full = || Stdio::from(std::fs::File::create("/dev/full").expect("the device"));
    let directory = tempfile::tempdir().expect("a directory");
    let output = start(directory.path()).stdout(full()).output().expect("the program starts");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let last = errors.lines().last().expect("a line");
    assert!(last.starts_with("error: the standard output cannot be written: "), "{errors}");
    everything_is_there(directory.path());
    // A reader that closes the pipe at once: no message, and the exit code of a broken pipe.
    let directory = tempfile::tempdir().expect("a directory");
    let mut child = start(directory.path()).stdout(Stdio::piped()).spawn().expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(141), "{errors}");
    assert!(!errors.contains("error") && !errors.contains("panicked"), "{errors}");
    everything_is_there(directory.path());
    // Nobody hears the progress: no error.
    let directory = tempfile::tempdir().expect("a directory");
    let output = start(directory.path()).stderr(full()).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(0));
    everything_is_there(directory.path());
    // Help, too.
    let mut command = Command::new(env!("CARGO_BIN_EXE_hollow_cylinder"));
    let status = command.arg("--help").stdout(full()).stderr(Stdio::null()).status().expect("it starts");
    assert_eq!(status.code(), Some(1));
}

/// A link under the name of the results stays, and leads to them; a named pipe is written through.
#[cfg(unix)]
#[test]
fn links_and_pipes_stay() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = |name: &str| directory.path().join(name);
    std::os::unix::fs::symlink("there.json", at("link.json")).expect("a link");
    let output = run(&["--radial", "2", "--json", "link.json"], directory.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(std::fs::symlink_metadata(at("link.json")).expect("the link").is_symlink());
    assert!(std::fs::read_to_string(at("there.json")).expect("the results").starts_with('{'));
    assert!(Command::new("mkfifo").arg(at("pipe")).status().expect("mkfifo").success());
    let pipe = at("pipe");
    let reader = std::thread::spawn(move || std::fs::read_to_string(pipe).expect("what was written"));
    let output = run(&["--radial", "2", "--json", "pipe"], directory.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(!std::fs::metadata(at("pipe")).expect("the pipe").is_file(), "the pipe was replaced");
    let json: Value = serde_json::from_str(&reader.join().expect("a reader")).expect("JSON");
    assert_eq!(json["unknowns"], 640);
}

#[test]
fn help_states_units_and_defaults() {
    let directory = tempfile::tempdir().expect("a directory");
    let output = run(&["--help"], directory.path());
    assert!(output.status.success());
    let help = text(&output.stdout);
    for part in
        ["--radial <N>", "[default: 16]", "in units of E", "[MPa]", "[default: 0.3]", "[default: out]"]
    {
        assert!(help.contains(part), "{part}\n{help}");
    }
}

/// Friction and load steps: bounds, the sign, what was asked for, and the same digits as before without them.
#[test]
fn friction_and_load_steps() {
    let directory = tempfile::tempdir().expect("a directory");
    let number =
        |json: &Value, name: &str| json[name].as_f64().unwrap_or_else(|| panic!("{name}: {}", json[name]));
    let without = solve(&[], directory.path());
    let explicit = solve(&["--push", "0", "-1"], directory.path());
    for name in
        ["J", "contact_force", "contact_length", "u_h1", "p_discrete_h1", "p_consistent_h1", "p_extended_h1"]
    {
        assert_eq!(without[name], explicit[name], "{name}");
    }
    for name in ["tangential_force", "stick_length", "slip_length"] {
        assert!(without[name].is_null(), "{name}");
    }
    let steps = ["--push", "0", "-1", "--push", "0.2", "-1"];
    let coulomb = solve(&[&["--coulomb", "0.3"], &steps[..]].concat(), directory.path());
    let (normal, tangential) = (number(&coulomb, "contact_force"), number(&coulomb, "tangential_force"));
    assert!(tangential < 0.0 && -tangential < 0.3 * normal, "{tangential}, {normal}");
    let (stick, slip) = (number(&coulomb, "stick_length"), number(&coulomb, "slip_length"));
    assert!((stick + slip - number(&coulomb, "contact_length")).abs() < 1e-9, "{stick} {slip}");
    let listed = coulomb["load_steps"].as_array().expect("steps");
    assert_eq!(listed.len(), 2);
    assert_eq!(listed[1]["push"], Value::from(vec![0.2, -1.0]));
    assert!(number(&listed[0], "tangential_force").abs() < 1e-9 * normal, "by symmetry");
    assert_eq!(listed[1]["tangential_force"], coulomb["tangential_force"]);
    assert_eq!(coulomb["settings"]["coulomb"], 0.3);
    // In one step the slip has another history.
    let at_once = solve(&["--coulomb", "0.3", "--push", "0.2", "-1"], directory.path());
    assert!((number(&at_once, "tangential_force") - tangential).abs() > 1e-6 * normal);
    let tresca = solve(&[&["--tresca", "0.5"], &steps[..]].concat(), directory.path());
    let force = number(&tresca, "tangential_force");
    assert!(force < 0.0 && -force <= 0.5 * 30.0 * std::f64::consts::PI + 1e-6, "{force}");
    assert_eq!(tresca["settings"]["tresca"], 0.5);
}

#[test]
fn friction_that_makes_no_sense_is_named() {
    let directory = tempfile::tempdir().expect("a directory");
    let message = |arguments: &[&str]| {
        let output = run(arguments, directory.path());
        assert!(!output.status.success(), "{arguments:?}");
        text(&output.stderr)
    };
    assert!(message(&["--coulomb", "-0.1"]).contains("coulomb = -0.1 is not possible"));
    assert!(message(&["--tresca", "-2"]).contains("tresca = -2 is not possible"));
    assert!(message(&["--tresca", "1", "--coulomb", "0.3"]).contains("cannot be used with"));
    assert!(message(&["--push", "1"]).contains("--push"));
    assert!(message(&["--push", "1", "nan"]).contains("finite"));
}
