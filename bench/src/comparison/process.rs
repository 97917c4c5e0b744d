//! Other programs: where they are, and what they print.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::ComparisonError;

/// The workspace that this was built from: the harness and the scripts of the peers lie in it.
pub fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The directory of the peers' scripts.
pub fn peers() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers")
}

/// The Python of the virtual environment with FFCx and scikit-fem.
pub fn environment_python() -> PathBuf {
    let environment = std::env::var_os("FFCX_VENV").map(PathBuf::from);
    let home = || PathBuf::from(std::env::var_os("HOME").unwrap_or_default());
    environment.unwrap_or_else(|| home().join(".cache/peers/venv")).join("bin/python")
}

/// The Python that the system's packages are installed for.
pub fn system_python() -> PathBuf {
    let usual = PathBuf::from("/usr/bin/python3");
    if usual.exists() { usual } else { PathBuf::from("python3") }
}

/// Whether a command runs and succeeds.
pub fn succeeds(program: impl Into<PathBuf>, arguments: &[&str]) -> bool {
    let mut command = Command::new(program.into());
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// Runs a command and gives what it prints.
pub fn output(name: &str, command: &mut Command) -> Result<String, ComparisonError> {
    let failed = |reason: String| ComparisonError::Program { program: name.to_owned(), reason };
    let output = command.output().map_err(|error| failed(error.to_string()))?;
    if !output.status.success() {
        // FreeFEM says what is wrong where it prints its results.
        let streams = [&output.stderr, &output.stdout];
        let said = streams.into_iter().find(|said| !said.is_empty()).unwrap_or(&output.stderr);
        let said = String::from_utf8_lossy(said);
        let last: Vec<&str> = said.lines().rev().take(5).collect();
        return Err(failed(last.into_iter().rev().collect::<Vec<_>>().join("\n")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The first line that a command prints, if it runs.
pub fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then(|| text.lines().next().unwrap_or_default().trim().to_owned())
}
