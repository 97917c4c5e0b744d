//! Contact of two bodies: ours and GetFEM's, on one thread each.

use std::fmt::Write;
use std::process::Command;

use forms_fem::output::tell;
use serde::Serialize;

use super::assembly::{ours, read};
use super::process::{output, peers, succeeds, system_python};
use super::{ComparisonError, Options, Report};
use crate::bodies::{Bodies, Law, MeasuredBodies};

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

/// Norms of both programs that differ by more than this, relatively, are of different problems.
const SAME: f64 = 1e-6;

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
    fn disagreement(&self) -> Option<String> {
        let difference = self.difference()?;
        (difference.is_nan() || difference > SAME).then(|| {
            format!("{}, {}: the results differ by {difference:.1e}", self.case.name(), self.law.name())
        })
    }

    fn is_solve(&self) -> bool {
        matches!(self.case, Bodies::PlaneSolve | Bodies::SpaceSolve)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Measures all cases.
pub(super) fn compare(options: &Options, report: &mut Report) -> Result<(), ComparisonError> {
    let present = succeeds(system_python(), &["-c", "import getfem"]);
    let known = report.missing.iter().any(|(name, _)| name == "GetFEM");
    if !present && !known {
        report.missing.push(("GetFEM".to_owned(), "Debian 12's package python3-getfem".to_owned()));
    }
    let file = std::env::temp_dir().join(format!("bodies-{}.json", std::process::id()));
    let path = file.to_string_lossy().into_owned();
    for case in Bodies::ALL {
        let divisions = if options.quick { case.quick_divisions() } else { case.divisions() };
        let is_solve = matches!(case, Bodies::PlaneSolve | Bodies::SpaceSolve);
        // A term takes a millisecond or so: many samples, and their mean.
        let samples = if is_solve { "1" } else { "40" };
        for law in Law::ALL {
            tell(format!("{}, {}", case.name(), law.name()));
            let measure = || -> Result<MeasuredBodies, ComparisonError> {
                let size = divisions.to_string();
                let arguments = ["bodies", case.name(), law.name(), &size, samples, &path];
                let mut rows = read("forms-fem", &ours(&arguments)?)?;
                Ok(rows.swap_remove(0))
            };
            let mut row = BodiesRow { case, law, divisions, ours: measure()?, getfem: None };
            if present {
                let mut command = Command::new(system_python());
                command.arg(peers().join("bodies_getfem.py")).arg(&file);
                command.arg(if is_solve { "solve" } else { "term" });
                command.args(["--samples", if is_solve || options.quick { "1" } else { "3" }]);
                command.env("OMP_NUM_THREADS", "1").env("OPENBLAS_NUM_THREADS", "1");
                command.env("PYTHONDONTWRITEBYTECODE", "1");
                match output("GetFEM", &mut command).and_then(|text| read("GetFEM", &text)) {
                    Ok(mut rows) => row.getfem = Some(rows.swap_remove(0)),
                    Err(error) => report.failures.push(error.to_string()),
                }
                // Ours runs before and after the peer: both count.
                let again = measure()?;
                row.ours.residual.extend(again.residual);
                row.ours.tangent.extend(again.tangent);
                row.ours.search.extend(again.search);
                row.ours.solve.extend(again.solve);
            }
            report.failures.extend(row.disagreement());
            report.bodies.push(row);
        }
    }
    // What is left in the directory for temporary files does no harm.
    let _ = std::fs::remove_file(&file);
    Ok(())
}

/// The tables.
pub(super) fn write(rows: &[BodiesRow], text: &mut String) {
    let (solves, terms): (Vec<&BodiesRow>, Vec<&BodiesRow>) = rows.iter().partition(|row| row.is_solve());
    // Writing to a string does not fail.
    let _ = write!(
        text,
        "## Contact of two bodies\n\nThe contact term of a block on a slab, quadratic displacements on simplices that do not match, points that \
         slide along rays, µs of a processor per own facet (means), search and insertion included. Both programs have the same meshes, rule, law \
         and iterate; the last column is the largest relative difference of the norms of residual and tangent.\n\n\
         | case | unknowns | own facets | search | residual | GetFEM | ratio | tangent | GetFEM | ratio | difference |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n"
    );
    let none = || "-".to_owned();
    for row in terms {
        let each = |seconds: &[f64]| 1e6 * mean(seconds) / row.ours.facets as f64;
        let ours = |seconds: &[f64]| format!("{:.2}", each(seconds));
        let theirs = |own: &[f64], of: fn(&MeasuredBodies) -> &[f64]| match &row.getfem {
            Some(getfem) => {
                (format!("{:.0}", each(of(getfem))), format!("{:.1}", mean(of(getfem)) / mean(own)))
            }
            None => (none(), none()),
        };
        let (residual, residual_ratio) = theirs(&row.ours.residual, |getfem| &getfem.residual);
        let (tangent, tangent_ratio) = theirs(&row.ours.tangent, |getfem| &getfem.tangent);
        let _ = writeln!(
            text,
            "| {}, {} | {} | {} | {} | {} | {residual} | {residual_ratio} | {} | {tangent} | {tangent_ratio} | {} |",
            row.case.name(),
            row.law.name(),
            row.ours.unknowns,
            row.ours.facets,
            ours(&row.ours.search),
            ours(&row.ours.residual),
            ours(&row.ours.tangent),
            row.difference().map_or_else(none, |difference| format!("{difference:.0e}")),
        );
    }
    let _ = write!(
        text,
        "\nA whole solve: the block pressed onto the slab and drawn along, in seconds of a processor, from the constraints on. The last column is the relative \
         difference of the displacement's norm.\n\n\
         | case | unknowns | own facets | ours | Newton steps | GetFEM | Newton steps | ratio | difference |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
    );
    for row in solves {
        let seconds = mean(&row.ours.solve);
        let theirs = row.getfem.as_ref().map(|getfem| (mean(&getfem.solve), getfem.steps));
        let _ = writeln!(
            text,
            "| {}, {} | {} | {} | {seconds:.2} | {} | {} | {} | {} | {} |",
            row.case.name(),
            row.law.name(),
            row.ours.unknowns,
            row.ours.facets,
            row.ours.steps,
            theirs.map_or_else(none, |(seconds, _)| format!("{seconds:.1}")),
            theirs.map_or_else(none, |(_, steps)| steps.to_string()),
            theirs.map_or_else(none, |(theirs, _)| format!("{:.1}", theirs / seconds)),
            row.difference().map_or_else(none, |difference| format!("{difference:.0e}")),
        );
    }
    text.push('\n');
}
