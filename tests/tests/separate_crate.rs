//! A user's form in a crate of its own, whose only dependency is forms-fem, compiles and runs.

use std::path::Path;
use std::process::Command;

/// The crate is no member of the workspace; it is given the workspace's lock file, profile and target directory,
/// so that faer and the other dependencies from the registry are not built a second time.
#[test]
fn a_form_in_a_crate_that_depends_on_forms_fem_alone_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let user = root.join("tests/separate_crate");
    let manifest = std::fs::read_to_string(user.join("Cargo.toml")).unwrap();
    let dependencies = manifest.split("[dependencies]").nth(1).unwrap().split('[').next().unwrap();
    let lines: Vec<&str> = dependencies.lines().filter(|line| !line.trim().is_empty()).collect();
    assert_eq!(lines, ["forms-fem = { path = \"../../fem\" }"]);

    std::fs::copy(root.join("Cargo.lock"), user.join("Cargo.lock")).unwrap();
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let mut command = Command::new(env!("CARGO"));
    command.args(["run", "--offline", "--quiet", "--manifest-path"]).arg(user.join("Cargo.toml"));
    command.arg("--target-dir").arg(target);
    // The workspace's own dev profile. Its packages are built anew, since they are no members here: without optimisation,
    // which is fast and enough for 165 unknowns.
    let workspace = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let start = workspace.find("[profile.dev]").unwrap();
    let end = workspace.find("[profile.release]").unwrap();
    let profile = Path::new(env!("CARGO_TARGET_TMPDIR")).join("profile_of_the_workspace.toml");
    std::fs::write(&profile, &workspace[start..end]).unwrap();
    command.arg("--config").arg(profile);
    command.args(["--config", "profile.dev.package.forms-fem.opt-level=0"]);
    let output = command.output().unwrap();
    let (printed, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "the separate crate fails:\n{printed}\n{errors}");
    assert!(printed.starts_with("u(0) = "), "{printed}");
}
