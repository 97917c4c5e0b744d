//! Rows of the report: what was measured of each kernel, assembly and contact problem.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::assembly::{Case, ContactUpdate, Measured};
use crate::bodies::{Bodies, Law, MeasuredBodies};

/// Norms of both programs that differ by more than this, relatively, are of different problems.
const SAME: f64 = 1e-6;

/// One kernel in one library.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Timing {
    /// Least time per element matrix \[ns\].
    pub ns: f64,
    /// Median.
    pub ns_med: f64,
    /// Largest difference from the first library over the largest entry.
    pub relerr: f64,
}

/// One form in all libraries.
#[derive(Clone, Debug, Serialize)]
pub struct KernelRow {
    /// The form's name.
    pub form: String,
    /// Ours.
    pub ours: Option<Timing>,
    /// FFCx's fastest variant, with its name.
    pub best: (String, Timing),
    /// All variants of FFCx.
    pub variants: BTreeMap<String, Timing>,
}

impl KernelRow {
    /// FFCx's least time over ours.
    pub fn ratio(&self) -> Option<f64> {
        self.ours.as_ref().map(|ours| self.best.1.ns / ours.ns)
    }
}

/// One case in all programs.
#[derive(Clone, Debug, Serialize)]
pub struct AssemblyRow {
    /// The case.
    pub case: Case,
    /// n.
    pub divisions: usize,
    /// Measurements of each program, ours first.
    pub programs: Vec<Measured>,
}

/// The update of a contact tangent on one mesh.
pub type ContactRow = ContactUpdate;

/// One case in both programs.
#[derive(Clone, Debug, Serialize)]
pub struct BodiesRow {
    /// The case.
    pub case: Bodies,
    /// With friction or without.
    pub law: Law,
    /// Cells along the slab.
    pub divisions: usize,
    /// Ours, before and after the peer.
    pub ours: MeasuredBodies,
    /// GetFEM's, where it is installed.
    pub getfem: Option<MeasuredBodies>,
}

impl BodiesRow {
    /// The largest relative difference of the norms; none without the peer.
    pub fn difference(&self) -> Option<f64> {
        let getfem = self.getfem.as_ref()?;
        let pairs = self.ours.norms.iter().zip(&getfem.norms);
        let differences = pairs.map(|(a, b)| ((a - b) / b).abs());
        let same_counts = self.ours.norms.len() == getfem.norms.len()
            && (self.ours.unknowns, self.ours.facets) == (getfem.unknowns, getfem.facets);
        Some(if same_counts { differences.fold(0.0, f64::max) } else { f64::NAN })
    }

    /// The reason to leave the times out: results of the two programs that differ.
    pub(super) fn disagreement(&self) -> Option<String> {
        let difference = self.difference()?;
        (difference.is_nan() || difference > SAME).then(|| {
            format!("{}, {}: the results differ by {difference:.1e}", self.case.name(), self.law.name())
        })
    }

    pub(super) fn is_solve(&self) -> bool {
        matches!(self.case, Bodies::PlaneSolve | Bodies::SpaceSolve)
    }
}
