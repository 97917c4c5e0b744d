//! Element kernels and whole assembly compared with other programs: starts the comparison, which is an example of `bench`.
//!
//! `cargo run --release --bin compare_with_peers -- --help` tells the options. The kernels of `bench` take minutes to
//! compile; who runs another program of this package does not wait for them.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

use forms_fem::output::tell;

const BENCH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../bench/Cargo.toml");

fn main() -> ExitCode {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(&cargo);
    command.args(["run", "--release", "--example", "compare_with_peers", "--manifest-path", BENCH, "--"]);
    // As compilers of other programs do, each crate is built in few parts.
    command.env("CARGO_INCREMENTAL", "0");
    match command.args(std::env::args_os().skip(1)).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(status) => {
            tell(format!("the comparison ended with {status}"));
            ExitCode::FAILURE
        }
        Err(error) => {
            tell(format!("`{}` cannot be started: {error}", cargo.to_string_lossy()));
            ExitCode::FAILURE
        }
    }
}
