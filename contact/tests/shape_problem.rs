//! Contact problems as a descent sees them: the derivatives of each criterion against central differences of what is computed
//! again on moved meshes, and which criteria go with which adjoint state.

use forms_contact::hollow_cylinder::{CONTACT, Settings, hollow_cylinder_on};
use forms_contact::shape_problem::{ContactShape, ContactState, Criterion, GradientForm, VolumeRule};
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::mesh::PerforatedAnnulus;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Failure, ShapeProblem, Values, Volume, measured_volume};

type ProblemOn = fn(&Mesh<2>) -> Result<ContactProblem<2>, Failure>;

/// The paper's cylinder with holes, whose upper outside is loaded, too.
fn problem_on(mesh: &Mesh<2>) -> Result<ContactProblem<2>, Failure> {
    let mut problem = hollow_cylinder_on(mesh, &Settings::default())?;
    problem.law.data.traction =
        Given::function_with_gradient(|x| [0.01 * x[0], -0.2], |_| [[0.01, 0.0], [0.0; 2]]);
    problem.law.data.body_force = Given::constant([0.02, -0.01]);
    problem.law.regions.gamma_n = forms_contact::forms::GammaN::on("above");
    Ok(problem)
}

/// Turned by a part of a sector and sheared a little: no diagonal is as long as another, where h_T has a kink.
fn ring(cells: usize) -> Mesh<2> {
    let ring = PerforatedAnnulus {
        inner_radius: 20.0,
        outer_radius: 30.0,
        rows: 1,
        holes_around: 16,
        hole_radius: 2.0,
        cells_per_side: cells,
        layers: cells,
        shape: CellShape::Quadrilateral,
        degree: 2,
    };
    let mut mesh = ring.mesh().unwrap();
    mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0).unwrap();
    mesh.name_facets("above", "outer", |centre| centre[1] > 0.0).unwrap();
    let twisted = mesh.nodes().iter().map(|[x, y]| {
        let (sine, cosine) = (0.1 + 0.01 * (x.hypot(*y) - 20.0)).sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    });
    mesh.with_nodes(twisted.collect()).unwrap()
}

fn shape(
    criterion: Criterion,
    adjoint: Adjoint,
    gradient: GradientForm,
    volume: VolumeRule,
) -> ContactShape<ProblemOn> {
    ContactShape {
        problem: problem_on as ProblemOn,
        criterion,
        adjoint,
        gradient,
        volume,
        moving: "holes".into(),
        perimeter_penalty: 0.2,
        fixed: vec!["inner".into(), "outer".into()],
    }
}

fn active(state: &ContactState<2>) -> Option<Vec<u32>> {
    let problem = &state.problem;
    problem.assembler.active_set(&problem.law.direct(), &[&state.u]).unwrap()
}

#[test]
fn derivatives_are_those_of_what_is_computed() {
    let mesh = ring(2);
    let movements = Space::of_geometry(&mesh).unwrap();
    // Everything moves but the inside, which is clamped.
    let movement = |x: &[f64; 2]| {
        let outwards = (x[0].hypot(x[1]) - 20.0) / 10.0;
        [outwards * (0.3 * x[1]).sin(), outwards * (0.2 * x[0] + 0.5).cos()]
    };
    let along = Field::interpolate(&movements, movement).unwrap();
    let target = measured_volume(&mesh).unwrap();
    let constraint = VolumeRule::Constraint(Volume { target });
    for (criterion, volume) in [
        (Criterion::Paper, constraint),
        (Criterion::Compliance, constraint),
        (Criterion::PressureVariation { over: 10.0 }, constraint),
        (Criterion::Compliance, VolumeRule::Penalty(-0.3)),
    ] {
        let problem = shape(criterion, Adjoint::Discrete, GradientForm::Volume, volume);
        let mut values = problem.solve(&mesh).unwrap();
        let switches = active(&values.state);
        assert!(
            switches.as_ref().is_some_and(|points| points.iter().filter(|point| **point > 0).count() > 3)
        );
        let found = problem.derivatives(&movements, &mut values.state).unwrap();
        let product = |derivative: &[f64]| -> f64 {
            derivative.iter().zip(along.values()).map(|(by, along)| by * along).sum()
        };
        let moved = |step: f64| -> Values<ContactState<2>> {
            let values = problem.solve(&along.move_mesh(step).unwrap()).unwrap();
            assert_eq!(active(&values.state), switches, "another active set at the step {step}");
            values
        };
        // Of fourth order, from two steps.
        let difference = |of: &dyn Fn(&Values<ContactState<2>>) -> f64| {
            let central = |step: f64| (of(&moved(step)) - of(&moved(-step))) / (2.0 * step);
            (4.0 * central(1e-3) - central(2e-3)) / 3.0
        };
        let (exact, differences) = (product(&found.criterion), difference(&|values| values.criterion));
        let relative = (exact / differences - 1.0).abs();
        println!(
            "{criterion:?}, {volume:?}: {exact:.8e}, differences {differences:.8e}, relative {relative:.1e}"
        );
        assert!(relative < 1e-7, "{criterion:?}: {exact} and {differences} ({relative:.1e})");
        match (volume, &found.constraint) {
            (VolumeRule::Constraint(_), Some(derivative)) => {
                assert!(values.constraint.unwrap().abs() < 1e-14);
                let differences = difference(&|values| values.constraint.unwrap());
                let exact = product(derivative);
                // What the movement adds to the volume and takes from it nearly cancels.
                let scale: f64 =
                    derivative.iter().zip(along.values()).map(|(by, along)| (by * along).abs()).sum();
                assert!((exact - differences).abs() < 1e-10 * scale, "{exact} and {differences}, {scale}");
            }
            (VolumeRule::Penalty(_), None) => assert!(values.constraint.is_none()),
            _ => panic!("a constraint where there is none, or none where there is one"),
        }
    }
}

/// On the holes, which are free, the paper's boundary form with (22) comes near the exact derivative of the discrete
/// criterion as cells become smaller.
#[test]
fn the_boundary_form_is_near_the_volume_form_on_holes() {
    let volume = VolumeRule::Penalty(0.0);
    let exact = shape(Criterion::Paper, Adjoint::Discrete, GradientForm::Volume, volume);
    let papers = shape(Criterion::Paper, Adjoint::Consistent, GradientForm::Boundary, volume);
    // A smooth movement of what is near the holes alone.
    let movement = |x: &[f64; 2]| {
        let weight = (1.0 - ((x[0].hypot(x[1]) - 25.0) / 4.9).powi(2)).max(0.0).powi(2);
        [weight * (0.3 * x[1]).sin(), weight * (0.2 * x[0] + 0.5).cos()]
    };
    let differences = [2, 4, 8].map(|cells| {
        let mesh = ring(cells);
        let movements = Space::of_geometry(&mesh).unwrap();
        let along = Field::interpolate(&movements, movement).unwrap();
        let derivative = |problem: &ContactShape<ProblemOn>| -> f64 {
            let mut values = problem.solve(&mesh).unwrap();
            let by = problem.derivatives(&movements, &mut values.state).unwrap().criterion;
            by.iter().zip(along.values()).map(|(by, along)| by * along).sum()
        };
        let (exact, papers) = (derivative(&exact), derivative(&papers));
        println!(
            "{cells} cells per side: volume form with (21) {exact:.6e}, boundary form with (22) {papers:.6e}"
        );
        (papers / exact - 1.0).abs()
    });
    let [first, second, third] = differences;
    assert!(second < first && third < 0.5 * second, "{differences:?}");
    assert!(third < 1e-2, "{differences:?}");
}

#[test]
fn criteria_without_their_adjoint_are_refused() {
    let volume = VolumeRule::Penalty(0.0);
    let refused = |criterion, adjoint, gradient| {
        shape(criterion, adjoint, gradient, volume).check().err().map(|error| error.to_string())
    };
    let variation = Criterion::PressureVariation { over: 10.0 };
    assert_eq!(refused(Criterion::Paper, Adjoint::Discrete, GradientForm::Boundary), None);
    assert_eq!(refused(Criterion::Paper, Adjoint::Extended, GradientForm::Boundary), None);
    assert_eq!(refused(variation, Adjoint::Discrete, GradientForm::Volume), None);
    let message = refused(Criterion::Paper, Adjoint::Consistent, GradientForm::Volume).unwrap();
    assert!(message.contains("needs the adjoint (21)"), "{message}");
    for (adjoint, gradient) in
        [(Adjoint::Consistent, GradientForm::Volume), (Adjoint::Discrete, GradientForm::Boundary)]
    {
        let message = refused(variation, adjoint, gradient).unwrap();
        assert!(message.contains("cover the paper's criterion (3) alone"), "{message}");
    }
}
