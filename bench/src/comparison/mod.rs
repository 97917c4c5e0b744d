//! One run that compares everything: element kernels with FFCx, whole assembly with other programs, contact with GetFEM.

mod assembly;
mod bodies;
mod bodies_tables;
mod kernels;
mod machine;
mod plain_names;
mod process;
mod report;
mod rows;

use std::path::PathBuf;

use forms_fem::output::picture::PictureError;
use thiserror::Error;

pub use assembly::{WORKER, work};
pub use kernels::read_timings;
pub use machine::Machine;
pub use plain_names::plain_name;
pub use report::Report;
pub use rows::{AssemblyRow, BodiesRow, ContactRow, KernelRow, Timing};

/// Choices of the comparison, and the directory for its results.
#[derive(Clone, Debug)]
pub struct Options {
    /// Few samples, and small meshes.
    pub quick: bool,
    /// Compare element kernels.
    pub kernels: bool,
    /// Compare whole assembly.
    pub assembly: bool,
    /// Compare contact of two bodies.
    pub contact: bool,
    /// Directory for the table, the pictures and the numbers.
    pub directory: PathBuf,
    /// Only kernels whose name has this in it.
    pub only_forms: Option<String>,
}

/// Errors that stop the comparison. A peer that is missing or fails stops nothing: it is named in the report.
#[derive(Debug, Error)]
pub enum ComparisonError {
    /// A program that is needed did not run.
    #[error("{program} failed: {reason}")]
    Program {
        /// Its name.
        program: String,
        /// Its message.
        reason: String,
    },
    /// A file or directory.
    #[error("{path}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A program printed something else than numbers.
    #[error("{program} printed what is no report: {reason}")]
    Output {
        /// Its name.
        program: String,
        /// The problem.
        reason: String,
    },
    /// The chart.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// Runs the comparison and writes `comparison.md`, `kernels.png`, `assembly.png` and `comparison.json`.
///
/// # Errors
/// A [`ComparisonError`] when our own side fails or a file cannot be written.
pub fn compare(options: &Options) -> Result<Report, ComparisonError> {
    let mut report = Report { machine: Machine::this(), quick: options.quick, ..Report::default() };
    if options.kernels {
        kernels::compare(options, &mut report)?;
    }
    if options.assembly {
        assembly::compare(options, &mut report)?;
    }
    if options.contact {
        bodies::compare(options, &mut report)?;
    }
    report.write(&options.directory)?;
    Ok(report)
}
