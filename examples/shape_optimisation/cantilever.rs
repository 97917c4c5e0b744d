//! A cantilever that rests on a support: clamped at the left, loaded at the right end, above a flat obstacle that it touches
//! in the middle. Its top moves until the work of the load is least at the same volume.

use forms_contact::forms;
use forms_contact::shape_problem::{ContactShape, Criterion, GradientForm, VolumeRule};
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Failure, Volume, measured_volume};

use crate::Outcome;
use crate::options::Options;
use crate::ring::ProblemOn;

/// Length and height \[cm\].
pub const SIZE: [f64; 2] = [60.0, 16.0];
/// Height of the body above the support \[cm\].
const GAP: f64 = 0.05;
/// g_N on the right end \[MPa\].
const TRACTION: [f64; 2] = [0.0, -0.05];
/// The support lies below this part of the length.
const SUPPORT: [f64; 2] = [0.5, 0.7];
/// E \[MPa\] and ν.
const YOUNG: f64 = 100.0;
const POISSON: f64 = 0.3;

/// The rectangle.
pub fn mesh(options: &Options) -> Outcome<Mesh<2>> {
    let cells = [10, 3].map(|count| count * options.cells_per_side());
    let mut mesh = rectangle([0.0; 2], SIZE, cells, CellShape::Quadrilateral, 2)?;
    let above_support = |x: &[f64; 2]| x[0] > SUPPORT[0] * SIZE[0] && x[0] < SUPPORT[1] * SIZE[0];
    mesh.name_facets("contact", "bottom", above_support)?;
    Ok(mesh)
}

fn problem_on(mesh: &Mesh<2>) -> Result<ContactProblem<2>, Failure> {
    let space = Space::vector(mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| [0.0; 2])?;
    let data = forms::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .gamma0(10.0 * YOUNG)
        .obstacle_normal([0.0, -1.0])
        .gap(Given::function_with_gradient(|x: &[f64; 2]| x[1] + GAP, |_| [0.0, 1.0]))
        .theta(-1.0)
        .extension(1.0)
        .traction(TRACTION);
    Ok(ContactProblem::new(
        &space,
        forms::Model { data, regions: forms::Regions::default().gamma_n("right").gamma_c("contact") },
        constraints,
    )
    .quadrature(Quadrature::Degree(8)))
}

/// The cantilever whose top moves at constant volume.
pub fn shape_problem(initial: &Mesh<2>) -> Outcome<ContactShape<ProblemOn>> {
    Ok(ContactShape {
        problem: problem_on as ProblemOn,
        criterion: Criterion::Compliance,
        adjoint: Adjoint::Discrete,
        gradient: GradientForm::Volume,
        volume: VolumeRule::Constraint(Volume { target: measured_volume(initial)? }),
        moving: "top".into(),
        perimeter_penalty: 0.0,
        fixed: vec!["left".into(), "right".into(), "bottom".into()],
    })
}
