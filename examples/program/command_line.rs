//! The command line of a program.

use std::io;
use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;
use forms_fem::output::{StandardOutput, one_line, program, tell};

/// A program with options: reads them and runs it. Help and version go to the standard output; an error of the command line is one line, with the
/// exit code 2. The other exit codes are those of [`program`].
pub fn program_with_options<O: Parser, E: std::fmt::Display>(
    run: impl FnOnce(&O, &mut StandardOutput) -> Result<(), E>,
) -> ExitCode {
    match O::try_parse() {
        Ok(options) => program(|out| run(&options, out)),
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            program(|out| {
                out.line(error.render().to_string().trim_end());
                Ok::<(), io::Error>(())
            })
        }
        Err(error) => {
            // After the first paragraph clap repeats the usage.
            let text = error.render().to_string();
            let text = one_line(text.split("\n\n").next().unwrap_or(&text));
            tell(format!("{text} (--help lists the options)"));
            ExitCode::from(2)
        }
    }
}
