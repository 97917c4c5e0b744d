//! The command line.

use std::path::PathBuf;

use clap::Parser;
use forms_contact::hollow_cylinder::Settings;
use forms_examples::memory;
use forms_fem::prelude::Threads;

use crate::Outcome;

/// The coarsest mesh that the program takes: coarser ones do not resolve the contact zone.
const COARSEST: usize = 2;
/// Errors are measured on meshes coarser at least by this factor than the reference.
pub const RATIO: usize = 4;

/// Figures 3, 4 and 5 of Bretin, Chapelat, Douanla-Lontsi, Homolle and Renard (2023): errors on the hollow cylinder
/// against a finer mesh, and the contact zone.
///
/// Lengths are in cm, stresses in MPa. Writes figure_*.png, .svg and .csv.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "convergence", allow_negative_numbers = true)]
pub struct Options {
    /// Cells across the thickness of the reference mesh; the paper's has 160, which takes about 10 GB
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub reference: usize,
    /// Cells across the thickness of the coarsest mesh; the meshes are those whose cells divide into the reference's
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub coarsest: usize,
    /// Variants of Nitsche's method: -1 skew-symmetric, 0 incomplete, 1 symmetric; several one after the other
    #[arg(long, value_name = "T", num_args = 1.., default_values_t = [-1.0])]
    pub theta: Vec<f64>,
    /// Values of C in xi = C sqrt(h) of the extended-Neumann adjoint (41) [MPa/sqrt(cm)]
    #[arg(long, value_name = "C", num_args = 1.., default_values_t = [0.1, 1.0, 10.0])]
    pub extension: Vec<f64>,
    /// Also solves with contact facets split at the zeros of beta_h, and tells what that changes
    #[arg(long)]
    pub split: bool,
    /// Threads; FORMS_THREADS where it is not given, or else as many as the process may use. Results do not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<Threads>,
    /// Runs even if the estimated memory exceeds what is available
    #[arg(long)]
    pub any_memory: bool,
    /// Directory of the results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/convergence")]
    pub out: PathBuf,
}

impl Options {
    /// Checks options that depend on each other; [`Settings::check`] checks each value.
    pub fn check(&self) -> Outcome<()> {
        if self.coarsest < COARSEST {
            return Err(format!("--coarsest {}: at least {COARSEST} cells are needed", self.coarsest).into());
        }
        if self.meshes().len() < 2 {
            let (coarsest, reference) = (self.coarsest, self.reference);
            return Err(format!(
                "--reference {reference}, --coarsest {coarsest}: an order needs two meshes between them whose cells \
                 divide into the reference's, at least {RATIO} times coarser than it"
            )
            .into());
        }
        for &theta in &self.theta {
            for &extension in &self.extension {
                Settings { extension, ..self.settings(self.reference, theta) }.check()?;
            }
        }
        if !self.any_memory {
            let unknowns = self.settings(self.reference, -1.0).unknowns();
            memory::check(
                &format!("--reference {}", self.reference),
                unknowns,
                memory::of_contact(unknowns),
            )?;
        }
        Ok(())
    }

    /// The meshes on which errors are measured. Each of their cells consists of whole cells of the reference mesh, so coarse fields have no kink
    /// inside a cell of the reference.
    pub fn meshes(&self) -> Vec<usize> {
        let nested = |radial: &usize| self.reference.is_multiple_of(*radial);
        (self.coarsest..=self.reference / RATIO).filter(nested).collect()
    }

    /// The meshes whose contact zones are compared: zones need no common cells.
    pub fn meshes_of_zones(&self) -> std::ops::RangeInclusive<usize> {
        self.coarsest..=self.reference / RATIO
    }

    /// The experiment's settings on a mesh.
    pub fn settings(&self, radial: usize, theta: f64) -> Settings {
        let threads = self.threads.unwrap_or_default();
        Settings { radial, theta, threads, ..Settings::default() }
    }
}
