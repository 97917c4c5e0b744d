//! Random runs of the laws with an obstacle that is round and moves.

use forms_contact::laws::analytic_obstacle;
use forms_contact::laws::capsule;
use forms_contact::laws::moving_obstacle;

use super::{Case, Random, all, block, case, check};
use crate::setting::{Friction, LAMBDA, MU, along};

/// An obstacle of radius 2 that has come from below and moved aside, without its shape.
fn obstacle(random: &mut Random, case: &Case) -> moving_obstacle::Data<2> {
    let centre = [random.between(0.5, 1.5), -2.0 + 2.0 * case.down];
    let moved = [centre[0] + case.aside, centre[1]];
    let still = [along(0, 1.0), along(1, 1.0)];
    let (slip_stress, friction) = match case.friction {
        Friction::Tresca(bound) => (bound, 0.0),
        Friction::Coulomb(coefficient) => (0.0, coefficient),
    };
    moving_obstacle::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(case.gamma0)
        .centre(moved)
        .rotation(still)
        .centre_before(centre)
        .rotation_before(still)
        .slip_stress(slip_stress)
        .friction(friction)
}

#[test]
fn a_round_obstacle_at_finite_strains() {
    let block = block();
    all(4, |random| {
        let case = case(random);
        let (obstacle, half_length) = (obstacle(random, &case), random.between(0.0, 0.4));
        let data = capsule::data_from(obstacle).radius(2.0).half_length(half_length);
        let law = capsule::Model { data, regions: capsule::Regions::default().gamma_c("bottom") };
        let problem = block.problem(law, 0.0, 0.0);
        let start = random.start(&block.space, 0.01);
        check(
            &problem,
            &start,
            case.friction,
            case.augmentation(),
            &case,
            |law, u| law.obstacle_traction(u),
            |law, u| law.obstacle_normal(u),
        )
        .is_some()
    });
}

#[test]
fn a_round_obstacle_at_small_strains() {
    let block = block();
    all(6, |random| {
        let case = case(random);
        let obstacle = obstacle(random, &case);
        let half_sizes = [random.between(0.0, 0.4), 0.0];
        let data = analytic_obstacle::data_from(obstacle)
            .radius(2.0)
            .theta(case.theta)
            .half_sizes(half_sizes)
            .body_force(case.force);
        let regions = analytic_obstacle::Regions::default().gamma_n("right").gamma_c("bottom");
        let problem = block.problem(analytic_obstacle::Model { data, regions }, 0.0, 0.0);
        let start = random.start(&block.space, 0.01);
        check(
            &problem,
            &start,
            case.friction,
            case.augmentation(),
            &case,
            |law, u| law.obstacle_traction(u),
            |law, u| law.obstacle_normal(u),
        )
        .is_some()
    });
}
