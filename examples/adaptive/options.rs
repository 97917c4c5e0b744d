//! The command line.

use std::path::PathBuf;

use clap::Parser;

/// Adaptive meshes compared with uniform ones: an L-shaped membrane whose mean is the goal, and a membrane on an obstacle, its
/// displacement, its adjoint state and a goal. Prints tables and draws pictures.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "adaptive")]
pub struct Options {
    /// Unknowns at which each study ends
    #[arg(long, value_name = "N", default_value_t = 26_000)]
    pub unknowns: usize,
    /// Directory of the pictures; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/adaptive")]
    pub out: PathBuf,
}
