//! The command line.

use std::path::PathBuf;

use clap::Parser;
use forms_contact_problem::hollow_cylinder::{Friction, IMPOSED_DISPLACEMENT, Settings};
use forms_fem::prelude::Threads;

use crate::Outcome;

/// Solves the hollow cylinder of Bretin, Chapelat, Douanla-Lontsi, Homolle and Renard (2023), Section 5:
/// radii 20 cm and 30 cm, plane strain, the inner circle moved down by 1 cm, a flat obstacle at y = -30 cm. Beyond
/// the paper: friction, and other movements of the inner circle, in load steps.
///
/// Lengths are in cm, stresses in MPa, forces in MPa·cm (per cm of depth). Prints a table and writes
/// hollow_cylinder.vtu and pictures.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "hollow_cylinder", allow_negative_numbers = true)]
pub struct Options {
    /// Cells across the thickness; there are 16 times as many around
    #[arg(long, value_name = "N", default_value = "16", value_parser = whole_number)]
    radial: usize,
    /// Variant of Nitsche's method: -1 skew-symmetric, 0 incomplete, 1 symmetric
    #[arg(long, value_name = "T", default_value = "-1", value_parser = number)]
    theta: f64,
    /// Nitsche's parameter gamma0, in units of E
    #[arg(long, value_name = "G", default_value = "10", value_parser = number)]
    gamma0: f64,
    /// Young's modulus E \[MPa\]
    #[arg(long, value_name = "E", help = "Young's modulus E [MPa]", default_value = "100", value_parser = number)]
    young: f64,
    /// Poisson's ratio
    #[arg(long, value_name = "NU", default_value = "0.3", value_parser = number)]
    poisson: f64,
    /// Degree of the quadrature on cells and contact facets
    #[arg(long, value_name = "Q", default_value = "8", value_parser = whole_number)]
    degree: usize,
    /// C in xi = C sqrt(h) of the extended-Neumann adjoint (41) [MPa/sqrt(cm)]
    #[arg(long, value_name = "C", default_value = "1", value_parser = number)]
    xi: f64,
    /// Tresca's friction on the contact boundary, bounded by S in MPa, in addition to the contact
    #[arg(long, value_name = "S", conflicts_with = "coulomb", value_parser = number)]
    tresca: Option<f64>,
    /// Coulomb's friction on the contact boundary, with the coefficient K
    #[arg(long, value_name = "K", value_parser = number)]
    coulomb: Option<f64>,
    /// Displacement of the inner circle in cm, 0 -1 where it is not given. Given again it is a further load step: slip
    /// is counted from the step before
    #[arg(long, num_args = 2, value_names = ["X", "Y"], value_parser = number)]
    push: Vec<f64>,
    /// Threads; FORMS_THREADS where it is not given, or else as many as the process may use. Results do not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<Threads>,
    /// Runs even if the estimated memory exceeds what is available
    #[arg(long)]
    pub any_memory: bool,
    /// Writes all results to this file too; its directory must exist
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Directory of the .vtu file and the pictures; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

impl Options {
    /// The experiment's settings, checked.
    pub fn settings(&self) -> Outcome<Settings> {
        let friction = match (self.tresca, self.coulomb) {
            (Some(bound), _) => Friction::Tresca(bound),
            (None, Some(coefficient)) => Friction::Coulomb(coefficient),
            (None, None) => Friction::None,
        };
        let pushes = match self.push.is_empty() {
            true => vec![IMPOSED_DISPLACEMENT],
            false => self.push.chunks_exact(2).map(|push| [push[0], push[1]]).collect(),
        };
        let settings = Settings {
            friction,
            pushes,
            radial: self.radial,
            theta: self.theta,
            gamma0_over_young: self.gamma0,
            young: self.young,
            poisson: self.poisson,
            degree: self.degree,
            extension: self.xi,
            threads: self.threads.unwrap_or_default(),
        };
        settings.check()?;
        // Each factor may be a number and their product none.
        let gamma0 = settings.gamma0_over_young * settings.young;
        if !(gamma0.is_finite() && gamma0 > 0.0) {
            return Err(format!("gamma0 = {} E is {gamma0} MPa, which is no stress", self.gamma0).into());
        }
        Ok(settings)
    }
}

fn number(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "a number is needed".to_owned())?;
    if value.is_finite() { Ok(value) } else { Err("a finite number is needed".into()) }
}

fn whole_number(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "a whole number, not negative, is needed".to_owned())
}
