//! Shape optimisation with a law of friction: the criterion's derivative by the shape against differences of what is computed
//! again on moved meshes.

use forms_contact::ContactProblem;
use forms_contact::laws::frictional_nitsche as law;
use forms_contact::shape_problem::{LawShape, LawState, VolumeRule};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Failure, ShapeProblem, Values, Volume, measured_volume};

use crate::block::Block;
use crate::setting::{Friction, THETAS, YOUNG, close, data, difference};

type Problem = ContactProblem<2, law::Model<2>>;

/// Right-angled triangles: one side is the longest wherever nodes move a little.
fn mesh() -> Mesh<2> {
    rectangle([0.0; 2], [2.0, 1.0], [8, 4], CellShape::Triangle, 1).unwrap()
}

fn check(theta: f64, friction: Friction) {
    let mut data = data::<2>(friction, theta, 20.0 * YOUNG);
    let force = |x: &[f64; 2]| [0.3 + x[0] - 0.5 * x[0] * x[1], 0.2 * x[1]];
    data.criterion_force =
        Given::function_with_gradient(force, |x| [[1.0 - 0.5 * x[1], -0.5 * x[0]], [0.0, 0.2]]);
    let regions = law::Regions::default().gamma_n("right").gamma_c("bottom");
    let problem_on = |mesh: &Mesh<2>| -> Result<Problem, Failure> {
        let block = Block { mesh: mesh.clone(), space: Space::vector(mesh, 1)? };
        Ok(block.problem(law::Model { data: data.clone(), regions: regions.clone() }, 0.008, 0.01))
    };
    let mesh = mesh();
    let target = measured_volume(&mesh).unwrap();
    let shape = LawShape {
        problem: problem_on,
        volume: VolumeRule::Constraint(Volume { target }),
        moving: "right".into(),
        perimeter_penalty: 0.3,
        fixed: vec!["top".into()],
    };
    let mut values = shape.solve(&mesh).unwrap();
    let problem = &values.state.problem;
    let [stuck, slipped] = [
        problem.assembler.functional(&problem.law.stick_length(&values.state.u)).unwrap(),
        problem.assembler.functional(&problem.law.slip_length(&values.state.u)).unwrap(),
    ];
    assert!(stuck > 0.05 && slipped > 0.05, "{stuck} sticks, {slipped} slips");

    let movements = Space::of_geometry(&mesh).unwrap();
    let mut held = Constraints::new(&movements);
    shape.fix(&mut held).unwrap();
    assert_eq!(held.prescribed().len(), 2 * 9);
    let along =
        Field::interpolate(&movements, |x| [(1.0 - x[1]) * (0.7 * x[0]).cos(), (x[0] + x[1]).sin() - 0.4])
            .unwrap();
    let found = shape.derivatives(&movements, &mut values.state).unwrap();
    let product = |derivative: &[f64]| -> f64 {
        derivative.iter().zip(along.values()).map(|(by, along)| by * along).sum()
    };
    let anew = |step: f64| shape.solve(&along.move_mesh(step).unwrap()).unwrap();
    let by_differences = |of: &dyn Fn(&Values<LawState<2, law::Model<2>>>) -> f64| {
        difference(2e-5, |step| {
            let values = anew(step);
            let LawState { problem, u, .. } = &values.state;
            Ok((of(&values), problem.assembler.active_set(&problem.law.direct(), &[u])?))
        })
    };
    let label = format!("theta = {theta}, {friction:?}");
    close(&label, product(&found.criterion), by_differences(&|values| values.criterion), 1e-7);
    let volume = product(&found.constraint.unwrap());
    close(&label, volume, by_differences(&|values| values.constraint.unwrap()), 1e-7);
}

#[test]
fn derivatives_are_those_of_what_is_computed() {
    for theta in THETAS {
        check(theta, Friction::Coulomb(0.3));
        check(theta, Friction::Tresca(0.6));
    }
}
