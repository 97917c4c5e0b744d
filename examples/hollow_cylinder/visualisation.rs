//! The derived fields, the `.vtu` file and the pictures of a solution.

use std::path::{Path, PathBuf};
use std::time::Instant;

use forms_contact_problem::forms;
use forms_contact_problem::hollow_cylinder::{CONTACT, CylinderSolution};
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;

use crate::Outcome;
use crate::measurements::Seconds;
use crate::pictures;

/// Fields that follow from the displacement.
pub struct DerivedFields {
    /// σ(u_h), projected \[MPa\].
    pub stress: Field<2>,
    /// Von Mises stress, projected \[MPa\].
    pub von_mises: Field<2>,
    /// g − u_n, the height above the obstacle \[cm\]; on the whole body, because zero would mean contact.
    pub gap: Field<2>,
    /// The contact pressure at the nodes of Γ_C, zero at all others \[MPa\].
    pub contact_pressure: Field<2>,
}

impl DerivedFields {
    fn new(solution: &CylinderSolution) -> Outcome<DerivedFields> {
        let (problem, u) = (&solution.problem, &solution.u);
        let (assembler, data, mesh) = (&problem.assembler, &problem.law.data, problem.space.mesh());
        let (scalars, tensors) = (Space::scalar(mesh, 2)?, Space::tensor(mesh, 2)?);
        Ok(DerivedFields {
            stress: assembler.project(&forms::stress(data, u), &tensors)?,
            von_mises: assembler.project(&forms::von_mises(data, u), &scalars)?,
            gap: assembler.project(&forms::current_gap(data, u), &scalars)?,
            contact_pressure: assembler.at_facet_nodes(
                &forms::contact_pressure(data, u),
                CONTACT,
                &scalars,
            )?,
        })
    }
}

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
