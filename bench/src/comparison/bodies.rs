//! Contact of two bodies: ours and GetFEM's, on one thread each.

use std::process::Command;

use forms_fem::output::tell;

use super::assembly::{ours, read};
use super::process::{output, peers, succeeds, system_python};
use super::rows::BodiesRow;
use super::{ComparisonError, Options, Report};
use crate::bodies::{Bodies, Law, MeasuredBodies};

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
