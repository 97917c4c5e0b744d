//! Round obstacles that move and turn: the distance, the tangent, adjoints, known answers.

use forms_contact::ContactProblem;
use forms_contact::laws::capsule::{capsule as law, capsule_distance};
use forms_contact::laws::moving_obstacle;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::setting::{LAMBDA, MU, YOUNG, along, check_tangent, close, difference, wave};

#[test]
fn the_distance_is_that_to_a_segment() {
    assert_eq!(capsule_distance([3.0, 4.0], 0.0, 2.0), 3.0);
    assert_eq!(capsule_distance([4.0, 3.0, 4.0], 5.0, 1.0), 4.0);
    assert_eq!(capsule_distance([-8.0, 4.0], 5.0, 1.0), 4.0);
    assert!(capsule_distance([0.3, -0.5], 0.0, 1.0) < 0.0);
}

fn rotation<const D: usize>(angle: f64) -> [[f64; D]; D] {
    let mut turned = std::array::from_fn(|k| along(k, 1.0));
    // In the plane of the first and the last axis.
    turned[0][0] = angle.cos();
    turned[0][D - 1] = -angle.sin();
    turned[D - 1][0] = angle.sin();
    turned[D - 1][D - 1] = angle.cos();
    turned
}

/// A capsule below a block's base, its top at height `top`, tilted and moved since the last step.
fn data<const D: usize>(friction: f64, top: f64) -> law::Data<D> {
    let mut centre = [0.5; D];
    centre[0] = 0.9;
    centre[D - 1] = top - 3.0;
    let mut before = centre;
    before[0] += 0.004;
    let obstacle = moving_obstacle::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(20.0 * YOUNG)
        .centre(centre)
        .rotation(rotation(0.1))
        .centre_before(before)
        .rotation_before(rotation(0.102))
        .friction(friction)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0]));
    law::data_from(obstacle).radius(3.0).half_length(0.2)
}

fn problem<const D: usize>(block: &Block<D>, data: law::Data<D>) -> ContactProblem<D, law::Model<D>>
where
    Dim: Dimension<D>,
{
    let regions = law::Regions::default().gamma_c("bottom");
    block.problem(law::Model { data, regions }, 0.0, 0.0)
}

#[test]
fn tangents_and_adjoint_gradients() {
    fn check<const D: usize>(block: &Block<D>)
    where
        Dim: Dimension<D>,
    {
        let mut tresca = data::<D>(0.0, 0.05);
        tresca.slip_stress = 5.0;
        for data in [data::<D>(0.3, 0.05), tresca] {
            let problem = problem(block, data);
            let (u, direction) = (wave(&block.space, 0.03, 0.4), wave(&block.space, 0.03, 2.3));
            let form = problem.law.direct();
            check_tangent(&format!("{D}D"), &problem.assembler, &form, &[&u], &[&direction]);
        }
        let solve = |coefficient: f64| {
            let problem = problem(block, data(coefficient, 0.05));
            let solved = problem.from_stick().unwrap().solve().unwrap();
            (problem, solved.into_field())
        };
        let (problem, u) = solve(0.25);
        let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
        let gradient = problem.assembler.functional(&problem.law.by_friction(&u, &p)).unwrap();
        assert!(gradient != 0.0, "a part slips");
        let found = difference(2e-5, |change| {
            let (problem, u) = solve(0.25 + change);
            Ok((problem.criterion(&u)?, problem.assembler.active_set(&problem.law.direct(), &[&u])?))
        });
        close(&format!("{D}D"), gradient, found, 1e-8);
    }
    check(&plane_block(4));
    check(&solid_block());
}

/// Body, support and obstacle turned and moved as a whole after the press: tractions turn along, sticking and slipping.
#[test]
fn a_rigid_motion_of_all_changes_no_traction() {
    let block = plane_block(4);
    let zero = Field::zero(&block.space);
    let solve = |data: law::Data<2>, constraints: Constraints<2>, start: &Field<2>| {
        let mut problem = problem(&block, data);
        problem.constraints = constraints;
        problem.from_stick().unwrap().start(start).solve().unwrap()
    };
    let mut still = data::<2>(0.3, 0.05);
    (still.centre_before, still.rotation_before) = (still.centre, still.rotation);
    let mut held = Constraints::new(&block.space);
    held.fix("top", |_| [0.01, -0.01]).unwrap();
    let first = solve(still.clone(), held, &zero);
    let reaction = first.reaction("top").unwrap();
    // Q x + c for everything, the slip counted from the same start as before.
    let (turn, shift) = (rotation::<2>(0.4), [0.7, -0.3]);
    let apply = |y: [f64; 2]| [0, 1].map(|i| turn[i][0] * y[0] + turn[i][1] * y[1] + shift[i]);
    let mut turned = still.clone();
    turned.centre = apply(still.centre);
    turned.rotation = [0, 1].map(|i| [0, 1].map(|j| (0..2).map(|k| turn[i][k] * still.rotation[k][j]).sum()));
    let mut held = Constraints::new(&block.space);
    held.fix("top", |x| {
        let y = apply([x[0] + 0.01, x[1] - 0.01]);
        [y[0] - x[0], y[1] - x[1]]
    })
    .unwrap();
    let start = Field::interpolate(&block.space, |x| {
        let y = apply(*x);
        [y[0] - x[0], y[1] - x[1]]
    })
    .unwrap();
    let second = solve(turned, held, &start).reaction("top").unwrap();
    for i in 0..2 {
        let expected = turn[i][0] * reaction[0] + turn[i][1] * reaction[1];
        close("reaction", second[i], expected, 1e-9);
    }
}
