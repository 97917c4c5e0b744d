//! The main job: `cargo run --release`.

use std::process::ExitCode;

fn main() -> ExitCode {
    forms_program::command_line::program_with_options(forms_hollow_cylinder::run)
}
