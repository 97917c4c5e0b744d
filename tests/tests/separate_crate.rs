//! Users' crates of their own, which are no members of the workspace: a form whose only dependency is forms-fem, and a
//! contact law by the steps of docs/new_contact_law.md. FORMS_SWEEPS=1: they are compiled and run, for which the library is built again.

use std::path::Path;
use std::process::Command;

#[test]
fn a_form_in_a_crate_that_depends_on_forms_fem_alone_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let manifest = std::fs::read_to_string(root.join("tests/separate_crate/Cargo.toml")).unwrap();
    let dependencies = manifest.split("[dependencies]").nth(1).unwrap().split('[').next().unwrap();
    let lines: Vec<&str> = dependencies.lines().filter(|line| !line.trim().is_empty()).collect();
    assert_eq!(lines, ["forms-fem = { path = \"../../fem\" }"]);
    if let Some(printed) = run("separate_crate") {
        assert!(printed.starts_with("u(0) = "), "{printed}");
    }
}

/// Thirty lines of form, fifteen of driver; two and three dimensions from one source; its adjoint passes its Taylor test.
#[test]
fn a_contact_law_that_is_not_in_the_library_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let lines = |file: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(root.join("tests/contact_law/src").join(file)).unwrap();
        let start = text.find(from).unwrap();
        let end = start + text[start..].find(to).unwrap();
        text[start..end].lines().filter(|line| !line.trim().is_empty()).count()
    };
    let form = lines("tresca.rs", "pub mod tresca {", "\n}\n") - 1;
    let driver = lines("main.rs", "    let space = ", "\n}\n");
    assert!(form <= 30 && driver <= 15, "{form} lines of form, {driver} of driver");
    if let Some(printed) = run("contact_law") {
        assert!(printed.contains("2D: ") && printed.contains("3D: "), "{printed}");
    }
}

/// Builds and runs a crate next to the tests, where sweeps are asked for. It is given the workspace's lock file, profile and target directory,
/// so that faer and the other dependencies from the registry are not built a second time.
fn run(name: &str) -> Option<String> {
    std::env::var_os("FORMS_SWEEPS")?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let user = root.join("tests").join(name);
    std::fs::copy(root.join("Cargo.lock"), user.join("Cargo.lock")).unwrap();
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let mut command = Command::new(env!("CARGO"));
    command.args(["run", "--offline", "--quiet", "--manifest-path"]).arg(user.join("Cargo.toml"));
    command.arg("--target-dir").arg(target);
    // The workspace's own dev profile, with which `.ci/run` has built the library for the starter.
    let workspace = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let start = workspace.find("[profile.dev]").unwrap();
    let end = workspace.find("[profile.release]").unwrap();
    let profile = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("profile_of_{name}.toml"));
    std::fs::write(&profile, &workspace[start..end]).unwrap();
    command.arg("--config").arg(profile);
    let output = command.output().unwrap();
    let (printed, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "the separate crate fails:\n{printed}\n{errors}");
    Some(printed.into_owned())
}
