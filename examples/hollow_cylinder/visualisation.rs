//! The `.vtu` file and the pictures of a solution.

use std::path::{Path, PathBuf};
use std::time::Instant;

use forms_contact_problem::hollow_cylinder::CylinderSolution;
use forms_fem::output::VtuFile;

use crate::Outcome;
use crate::derived_fields::DerivedFields;
use crate::measurements::Seconds;
use crate::pictures;

/// Writes all files into the directory and returns their paths.
pub fn write_all(
    solution: &CylinderSolution,
    directory: &Path,
    seconds: &mut Seconds,
) -> Outcome<Vec<PathBuf>> {
    let mut clock = Instant::now();
    let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
    let derived = DerivedFields::new(solution)?;
    seconds.derived_fields = lap();
    let vtu = directory.join("hollow_cylinder.vtu");
    VtuFile::new(solution.problem.space.mesh())
        .threads(solution.problem.assembler.threads())
        .point_data("displacement", &solution.u)?
        .point_data("adjoint state (21)", &solution.p_discrete)?
        .point_data("adjoint state (22)", &solution.p_consistent)?
        .point_data("adjoint state (41)", &solution.p_extended)?
        .point_data("stress", &derived.stress)?
        .point_data("von Mises stress", &derived.von_mises)?
        .point_data("gap", &derived.gap)?
        .point_data("contact pressure", &derived.contact_pressure)?
        .write(&vtu)?;
    seconds.vtu = lap();
    let mut files = vec![vtu];
    files.extend(pictures::write_all(solution, &derived, directory)?);
    seconds.pictures = lap();
    Ok(files)
}
