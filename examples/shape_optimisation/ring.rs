//! The ring: the paper's cylinder, a mesh with holes in it, and the criteria that its holes minimise.

use forms_contact::hollow_cylinder::{
    CONTACT, CONTACT_CELLS, INNER_RADIUS, OUTER_RADIUS, Settings, hollow_cylinder_on,
};
use forms_contact::shape_problem::{ContactShape, Criterion, GradientForm, VolumeRule};
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::mesh::PerforatedAnnulus;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Failure, Volume, measured_volume};

use crate::Outcome;
use crate::options::Options;

/// The length L of the variation of the pressure \[cm\].
pub const EVEN_OVER: f64 = 10.0;

/// A contact problem on a mesh of the ring.
pub type ProblemOn = fn(&Mesh<2>) -> Result<ContactProblem<2>, Failure>;

/// The mesh with round holes.
pub fn mesh(options: &Options) -> Outcome<Mesh<2>> {
    let ring = PerforatedAnnulus {
        inner_radius: INNER_RADIUS,
        outer_radius: OUTER_RADIUS,
        rows: options.rows,
        holes_around: options.holes,
        hole_radius: options.hole_radius,
        cells_per_side: options.cells_per_side(),
        layers: options.layers,
        shape: CellShape::Quadrilateral,
        degree: 2,
    };
    let mut mesh = ring.mesh()?;
    mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0)?;
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
    Ok(mesh)
}

fn problem_on(mesh: &Mesh<2>) -> Result<ContactProblem<2>, Failure> {
    Ok(hollow_cylinder_on(mesh, &Settings::default())?)
}

/// The ring whose holes move at constant volume. The boundary form goes with (22), the volume form with (21).
pub fn shape_problem(
    initial: &Mesh<2>,
    criterion: Criterion,
    adjoint: Adjoint,
) -> Outcome<ContactShape<ProblemOn>> {
    let gradient = if adjoint == Adjoint::Discrete { GradientForm::Volume } else { GradientForm::Boundary };
    Ok(ContactShape {
        problem: problem_on as ProblemOn,
        criterion,
        adjoint,
        gradient,
        volume: VolumeRule::Constraint(Volume { target: measured_volume(initial)? }),
        moving: "holes".into(),
        perimeter_penalty: 0.0,
        fixed: vec!["inner".into(), "outer".into()],
    })
}
