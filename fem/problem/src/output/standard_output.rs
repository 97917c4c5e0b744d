//! The standard streams of a program that has more to do than to print: a reader who goes away, or a full disk, does not
//! stop it.

use std::error::Error;
use std::fmt::{self, Debug, Display};
use std::io::{self, Write};
use std::process::ExitCode;

/// The exit code of a program whose reader has gone away, quietly: what a shell reports of a program that the signal
/// SIGPIPE ended, 128 + 13.
const READER_GONE: u8 = 141;

/// The standard output of a program. Writing never fails: the first failure is kept for the end, and what comes after it is
/// dropped, so that results on disk are written whatever the standard output does.
#[derive(Debug, Default)]
pub struct StandardOutput {
    failure: Option<io::Error>,
}

impl StandardOutput {
    /// An output with nothing printed yet.
    pub fn new() -> Self {
        StandardOutput::default()
    }

    /// A line.
    ///
    /// ```
    /// # use forms_fem::output::StandardOutput;
    /// let mut out = StandardOutput::new();
    /// out.line(format!("force {:.3} N", 17.58));
    /// ```
    pub fn line(&mut self, text: impl Display) {
        self.attempt(|stream| writeln!(stream, "{text}"));
    }

    /// The remaining output, written.
    ///
    /// # Errors
    /// The first failure since the beginning.
    pub fn finish(mut self) -> io::Result<()> {
        self.attempt(|stream| stream.flush());
        self.failure.map_or(Ok(()), Err)
    }

    fn attempt(&mut self, act: impl FnOnce(&mut io::StdoutLock<'static>) -> io::Result<()>) {
        if self.failure.is_none() {
            self.failure = act(&mut io::stdout().lock()).err();
        }
    }
}

impl Write for StandardOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.attempt(|stream| stream.write_all(bytes));
        Ok(bytes.len())
    }

    /// A whole line at once where possible.
    fn write_fmt(&mut self, text: fmt::Arguments<'_>) -> io::Result<()> {
        self.attempt(|stream| stream.write_fmt(text));
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt(|stream| stream.flush());
        Ok(())
    }
}

/// A program, run with its standard output. If it fails, the reason is one line on the standard error stream.
/// The exit code is 0 if all went well, 1 after an error or if the standard output could not be written, and 141 without a
/// word if its reader had gone away, as a shell reports of other programs.
///
/// ```no_run
/// use std::error::Error;
/// use std::process::ExitCode;
///
/// use forms_fem::output::{StandardOutput, program};
///
/// fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
///     out.line(format!("u at the centre   {:.8}", 0.073_671_35));
///     Ok(())
/// }
///
/// fn main() -> ExitCode {
///     program(run)
/// }
/// ```
pub fn program<E: Display>(run: impl FnOnce(&mut StandardOutput) -> Result<(), E>) -> ExitCode {
    let mut output = StandardOutput::new();
    let outcome = run(&mut output);
    match (outcome, output.finish()) {
        (Err(error), _) => {
            tell(format_args!("error: {}", one_line(&error.to_string())));
            ExitCode::FAILURE
        }
        (Ok(()), Err(error)) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::from(READER_GONE),
        (Ok(()), Err(error)) => {
            tell(format_args!("error: the standard output cannot be written: {error}"));
            ExitCode::FAILURE
        }
        (Ok(()), Ok(())) => ExitCode::SUCCESS,
    }
}

/// Any error, as the end of a small program: `fn main() -> Result<(), Failure>` prints it in words. It is made by `?`, also of a text.
///
/// ```
/// use forms_fem::output::Failure;
///
/// fn largest(values: &[f64]) -> Result<f64, Failure> {
///     Ok(values.iter().copied().reduce(f64::max).ok_or("there are no values")?)
/// }
/// assert_eq!(format!("{:?}", largest(&[]).unwrap_err()), "there are no values");
/// ```
pub struct Failure(Box<dyn Error>);

impl<E: Into<Box<dyn Error>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure(error.into())
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&one_line(&self.0.to_string()))
    }
}

/// As text: Rust prints an error of `main` in this way.
impl Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Display::fmt(self, f)
    }
}

/// A line on the standard error stream, for progress and warnings. A closed stream is no error.
pub fn tell(line: impl Display) {
    // One write: lines of several processes do not mingle.
    let _ = io::stderr().lock().write_all(format!("{line}\n").as_bytes());
}

/// The text on one line, whatever a user's argument or a system's message contains.
pub fn one_line(text: &str) -> String {
    let parts = text.split(|c: char| c.is_control() || c.is_whitespace()).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join(" ")
}
