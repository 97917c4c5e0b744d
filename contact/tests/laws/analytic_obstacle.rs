//! Obstacles by their signed distance at small strains: a flat side against the law with a flat, a ball against the law with
//! finite strains, an obstacle that moves, a φ of a user's own, tangents and adjoints.

use forms_contact::contact_law;
use forms_contact::law::WithFriction;
use forms_contact::laws::analytic_obstacle as law;
use forms_contact::laws::capsule;
use forms_contact::laws::frictional_nitsche as flat;
use forms_contact::laws::moving_obstacle;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::setting::{self, Friction, LAMBDA, MU, THETAS, YOUNG, along};
use crate::setting::{check_tangent, close, difference, wave};

const GAMMA0: f64 = 20.0 * YOUNG;

/// A box with round edges whose upper side is the plane at the height `top`, wide beyond the block.
fn under<const D: usize>(friction: Friction, theta: f64, top: f64) -> law::Data<D> {
    let mut centre = along::<D>(0, 0.9);
    centre[D - 1] = top - 2.5;
    let rotation = std::array::from_fn(|k| along(k, 1.0));
    let (slip_stress, friction) = match friction {
        Friction::Tresca(bound) => (bound, 0.0),
        Friction::Coulomb(coefficient) => (0.0, coefficient),
    };
    let mut half_sizes = [4.0; D];
    half_sizes[D - 1] = 2.0;
    let obstacle = moving_obstacle::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(GAMMA0)
        .centre(centre)
        .rotation(rotation)
        .centre_before(centre)
        .rotation_before(rotation)
        .slip_stress(slip_stress)
        .friction(friction)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0]));
    law::data_from(obstacle).radius(0.5).theta(theta).half_sizes(half_sizes)
}

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

fn solve<L: WithFriction<D>, const D: usize>(block: &Block<D>, law: L, aside: f64, down: f64) -> Field<D>
where
    Dim: Dimension<D>,
{
    let problem = block.problem(law, aside, down);
    problem.from_stick().unwrap().solve().unwrap().into_field()
}

/// The largest difference relative to the largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |most, v| most.max(v.abs()));
    most(&mut a.iter().zip(b).map(|(a, b)| a - b)) / most(&mut b.iter().copied())
}

/// A block pressed and sheared in two steps: parts stick, slip and lift off.
fn flat_sides<const D: usize>(block: &Block<D>, thetas: &[f64])
where
    Dim: Dimension<D>,
{
    for &theta in thetas {
        for friction in [Friction::Coulomb(0.3), Friction::Tresca(0.8)] {
            let mut known = setting::data::<D>(friction, theta, GAMMA0);
            let mut found = under::<D>(friction, theta, 0.0);
            for aside in [0.02, 0.012] {
                let regions = flat::Regions::default().gamma_n("right").gamma_c("bottom");
                let expected = solve(block, flat::Model { data: known.clone(), regions }, aside, 0.01);
                let u = solve(block, model(found.clone()), aside, 0.01);
                let error = apart(u.values(), expected.values());
                println!("{D}D, theta = {theta}, {friction:?}: {error:.1e}");
                assert!(error < 1e-12, "{D}D, theta = {theta}, {friction:?}: {error:.1e}");
                known.displacement_before = Given::field(&expected);
                found.displacement_before = Given::field(&u);
            }
        }
    }
}

#[test]
fn a_flat_side_is_the_law_with_a_flat() {
    flat_sides(&plane_block(4), &THETAS);
    flat_sides(&solid_block(), &[0.0]);
}

/// The top moved by (U, −δ), or the obstacle by (−U, δ): u is the same except for that translation.
#[test]
fn an_obstacle_that_moves_is_a_body_that_moves() {
    let block = plane_block(4);
    let moved = solve(&block, model(under::<2>(Friction::Coulomb(0.3), 0.0, 0.0)), 0.02, 0.01);
    let mut data = under::<2>(Friction::Coulomb(0.3), 0.0, 0.0);
    data.centre = [data.centre[0] - 0.02, data.centre[1] + 0.01];
    let held = solve(&block, model(data), 0.0, 0.0);
    let shifted: Vec<f64> = held.values().chunks(2).flat_map(|u| [u[0] + 0.02, u[1] - 0.01]).collect();
    assert!(apart(&shifted, moved.values()) < 1e-11, "{:.1e}", apart(&shifted, moved.values()));
}

/// A tilted ball's reaction on the block comes to that of finite strains as the load becomes small, in first order.
#[test]
fn a_ball_presses_as_one_at_finite_strains_under_a_small_load() {
    fn reactions<L: WithFriction<2>>(block: &Block<2>, law: L) -> [f64; 2] {
        let problem = block.problem(law, 0.0, 0.0);
        let solved = problem.from_stick().unwrap().solve().unwrap();
        let reaction = solved.reaction("top").unwrap();
        [reaction[0], reaction[1]]
    }
    let block = plane_block(8);
    let mut errors = vec![];
    for depth in [0.008, 0.004, 0.002] {
        let mut small = under::<2>(Friction::Coulomb(0.3), 0.0, 0.0);
        (small.half_sizes, small.radius) = ([0.0; 2], 3.0);
        small.centre = [0.9, depth - 3.0];
        small.centre_before = [0.9 + 0.5 * depth, depth - 3.0];
        let finite = capsule::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(GAMMA0)
            .centre(small.centre)
            .rotation(small.rotation)
            .centre_before(small.centre_before)
            .rotation_before(small.rotation_before)
            .radius(3.0);
        let finite = finite.friction(small.friction);
        let finite = capsule::Model { data: finite, regions: capsule::Regions::default().gamma_c("bottom") };
        let (small, finite) = (reactions(&block, model(small)), reactions(&block, finite));
        assert!(finite[0].abs() > 0.05 * finite[1].abs(), "friction acts: {finite:?}");
        errors.push(apart(&small, &finite));
    }
    println!("beside finite strains: {errors:?}");
    assert!(errors[0] < 0.05, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.6 * pair[0]), "{errors:?}");
}

#[test]
fn tangents_and_adjoint_gradients() {
    fn check<const D: usize>(block: &Block<D>, thetas: &[f64])
    where
        Dim: Dimension<D>,
    {
        // Tilted and moved since the last step; Γ_C meets its flat side and its round edge.
        let data = |friction, theta: f64| {
            let mut data = under::<D>(friction, theta, 0.004);
            data.half_sizes = [0.3; D];
            data.centre[D - 1] = 0.02 - 0.8;
            for (rotation, angle) in [(&mut data.rotation, 0.1_f64), (&mut data.rotation_before, 0.102)] {
                let last = D - 1;
                (rotation[0][0], rotation[last][last]) = (angle.cos(), angle.cos());
                (rotation[0][last], rotation[last][0]) = (-angle.sin(), angle.sin());
            }
            data.centre_before[0] += 0.004;
            data
        };
        let (u, direction) = (wave(&block.space, 0.02, 0.4), wave(&block.space, 0.02, 2.3));
        for &theta in thetas {
            for friction in [Friction::Coulomb(0.6), Friction::Tresca(20.0)] {
                let problem = block.problem(model(data(friction, theta)), 0.0, 0.0);
                let pressed = problem.assembler.functional(&problem.law.contact_length(&u)).unwrap();
                assert!(pressed > 0.0 && pressed < 1.9, "{pressed}");
                let label = format!("{D}D, theta = {theta}, {friction:?}");
                let assembler = &problem.assembler;
                check_tangent(&label, assembler, &problem.law.direct(), &[&u], &[&direction]);
                check_tangent(&label, assembler, &problem.law.penalty(), &[&u], &[&direction]);
            }
        }
        let solve = |coefficient: f64, growth: f64| {
            let mut data = data(Friction::Coulomb(coefficient), 1.0);
            data.radius += growth;
            let problem = block.problem(model(data), 0.0, 0.0);
            let solved = problem.from_stick().unwrap().solve().unwrap();
            (problem, solved.into_field())
        };
        let (problem, u) = solve(0.1, 0.0);
        let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
        let evaluate = |change: f64, growth: f64| {
            let (problem, u) = solve(0.1 + change, growth);
            Ok((problem.criterion(&u)?, problem.assembler.active_set(&problem.law.direct(), &[&u])?))
        };
        let gradient = problem.assembler.functional(&problem.law.by_friction(&u, &p)).unwrap();
        assert!(gradient != 0.0, "a part slips");
        let found = difference(2e-5, |change| evaluate(change, 0.0));
        close(&format!("{D}D, by friction"), gradient, found, 1e-8);
        let gradient = problem.assembler.functional(&problem.law.by_radius(&u, &p)).unwrap();
        let found = difference(2e-6, |change| evaluate(0.0, change));
        close(&format!("{D}D, by the radius"), gradient, found, 1e-8);
    }
    check(&plane_block(4), &THETAS);
    check(&solid_block(), &[1.0]);
}

/// A law of a user's own: a wavy ground as a level set, which is no distance.
#[forms]
pub mod waves {
    use forms_contact::laws::frictional_nitsche::elasticity;
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::obstacle::gamma;
    use forms_contact::operators::signed_distance::{
        half_space_distance, level_set_distance, nitsche_density, obstacle_traction,
    };

    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub gamma0: Param,
        pub theta: Param,
        pub friction: Param,
        pub height: Param,
        pub ground: Param<Vector>,
        pub upward: Param<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn level(y: Vector) -> Scalar {
        3 * half_space_distance(y, ground, upward) - height * sin(5 * y[0])
    }
    fn slope(y: Vector) -> Vector {
        diff(level(y), y)
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let y = x + u;
        let g = level_set_distance(level(y), slope(y));
        let T = obstacle_traction(stress(u) * n, g, normalize(slope(y)), u, gamma(), 0, friction);
        elasticity(u, v)
            + integral(GammaC, nitsche_density(stress(u) * n, T, stress(v) * n, v, theta, gamma()))
    }
}
contact_law!(waves { direct: direct, region: gamma_c, coefficient: friction, line_search: OnResidual });

#[test]
fn a_distance_of_a_users_own() {
    let block = plane_block(4);
    let upward = [-(0.02_f64.sin()), 0.02_f64.cos()];
    let ground = [1.0, 0.0];
    let model = |height: f64, theta: f64| {
        let (lambda, mu, gamma0) = (LAMBDA, MU, GAMMA0);
        let data = waves::data()
            .lambda(lambda)
            .mu(mu)
            .gamma0(gamma0)
            .theta(theta)
            .friction(0.3)
            .height(height)
            .ground(ground)
            .upward(upward);
        waves::Model { data, regions: waves::Regions::default().gamma_c("bottom") }
    };
    // Without waves it is a plane, whatever the slope of φ.
    let mut known = setting::data::<2>(Friction::Coulomb(0.3), 1.0, GAMMA0);
    known.obstacle_normal = Given::constant(upward.map(|component| -component));
    known.gap = Given::function(move |x: &[f64; 2]| (x[0] - 1.0) * upward[0] + x[1] * upward[1]);
    let regions = flat::Regions::default().gamma_n("right").gamma_c("bottom");
    let expected = solve(&block, flat::Model { data: known, regions }, 0.01, 0.02);
    let u = solve(&block, model(0.0, 1.0), 0.01, 0.02);
    assert!(apart(u.values(), expected.values()) < 1e-12, "{:.1e}", apart(u.values(), expected.values()));
    let (u, direction) = (wave(&block.space, 0.02, 0.4), wave(&block.space, 0.02, 2.3));
    for theta in THETAS {
        let problem = block.problem(model(0.05, theta), 0.0, 0.0);
        let label = format!("waves, theta = {theta}");
        check_tangent(&label, &problem.assembler, &problem.law.direct(), &[&u], &[&direction]);
    }
}
