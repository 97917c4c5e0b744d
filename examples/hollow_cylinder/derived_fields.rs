//! The derived fields of a solution.

use forms_contact_problem::forms;
use forms_contact_problem::hollow_cylinder::{CONTACT, CylinderSolution};
use forms_fem::prelude::*;

use crate::Outcome;

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
    pub fn new(solution: &CylinderSolution) -> Outcome<DerivedFields> {
        let (problem, u) = (&solution.problem, &solution.u);
        let (assembler, data) = (&problem.assembler, &problem.law.data);
        let (scalars, tensors) = (problem.space.with_shape(&[])?, problem.space.with_shape(&[2, 2])?);
        let (stress, von_mises) = (forms::stress(data, u), forms::von_mises(data, u));
        let gap = forms::current_gap(data, u);
        let [stress, von_mises, gap] =
            assembler.project_together([(&stress, &tensors), (&von_mises, &scalars), (&gap, &scalars)])?;
        let pressure = forms::contact_pressure(data, u);
        let contact_pressure = assembler.at_facet_nodes(&pressure, CONTACT, &scalars)?;
        Ok(DerivedFields { stress, von_mises, gap, contact_pressure })
    }
}
