//! Random runs of laws between bodies: a layer in two bodies, on meshes that do not match, has an answer that is known whatever the
//! start.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_contact::laws::sliding_bodies;
use forms_contact::laws::two_bodies::{self, Data};
use forms_fem::prelude::*;

use super::layers::{answer, compare, to_rounding};
use super::{Case, Random, all, bound, case};
use crate::cohesive::{END, model, torn};
use crate::setting::{Friction, LAMBDA, MU};
use crate::two_bodies::{constraints, layers, pairings};

fn data(case: &Case, share: f64) -> Data<2> {
    let (slip_stress, friction) = match case.friction {
        Friction::Tresca(bound) => (bound, 0.0),
        Friction::Coulomb(coefficient) => (0.0, coefficient),
    };
    two_bodies::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(case.gamma0)
        .theta(case.theta)
        .share(share)
        .slip_stress(slip_stress)
        .friction(friction)
}

fn pairing(random: &mut Random) -> (Pairing, f64) {
    let [both, lower, upper] = pairings();
    match random.between(0.0, 3.0) {
        choice if choice < 1.0 => both,
        choice if choice < 2.0 => lower,
        _ => upper,
    }
}

/// The forces at the top and at the bottom, which balance each other, if it converges.
fn forces<L: ContactLaw<2>>(
    problem: &ContactProblem<2, L>,
    start: &Field<2>,
    case: &Case,
) -> Option<Vec<f64>> {
    match problem.direct().unwrap().options(to_rounding()).start(start).solve() {
        Ok(solved) => {
            let [top, bottom] = ["upper top", "lower bottom"].map(|region| solved.reaction(region).unwrap());
            let size = top[0].hypot(top[1]).max(1e-3 * MU);
            for (top, bottom) in top.iter().zip(&bottom) {
                assert!((top + bottom).abs() < 1e-9 * size, "{case:?}: {top} and {bottom}");
            }
            Some(top)
        }
        Err(error) => {
            assert!(error.to_string().contains("failed at iteration"), "{case:?}: {error}");
            println!("{case:?}: {error}");
            None
        }
    }
}

#[test]
fn two_bodies_at_small_strains() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    all(9, |random| {
        let (case, (pairing, share)) = (case(random), pairing(random));
        let regions = two_bodies::Regions::default().touch(pairing).gamma_n("upper top");
        let model = two_bodies::Model { data: data(&case, share), regions };
        let held = constraints(&space, case.aside, case.down);
        let problem = ContactProblem::new(&space, model, held);
        let found = forces(&problem, &random.start(&space, 0.02), &case);
        if let Some(force) = &found {
            compare(&case, force, answer(&case, case.down, case.aside));
        }
        found.is_some()
    });
}

/// p = μ(1/J − J) − λ ln J/J and τ = μ k, while they stick: periodic images are no partners of what has slipped beyond an end.
#[test]
fn two_bodies_at_finite_strains() {
    let apart = 0.01;
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 3], apart);
    let space = Space::vector(&mesh, 1).unwrap();
    all(10, |random| {
        let (case, (pairing, share)) = (case(random), pairing(random));
        let down = random.between(-0.01, 0.2);
        let stretch = 1.0 - (down - apart).max(0.0);
        let pressure = MU * (1.0 / stretch - stretch) - LAMBDA * stretch.ln() / stretch;
        let most = if stretch < 1.0 { bound(case.friction, pressure) / MU } else { 0.0 };
        let shear = random.between(-0.9, 0.9) * most.min(0.2);
        let exact = |x: &[f64; 2]| {
            let height = if x[1] > 0.505 { x[1] - apart } else { x[1] };
            [shear * height, stretch * height - x[1]]
        };
        let near = Field::interpolate(&space, |x| if stretch < 1.0 { exact(x) } else { [0.0; 2] }).unwrap();
        let noise = random.start(&space, 0.01);
        let values = near.values().iter().zip(noise.values()).map(|(u, noise)| 0.9 * u + noise);
        let start = Field::from_values(&space, values.collect()).unwrap();
        let regions = sliding_bodies::Regions::default().touch(pairing).gamma_n("upper top");
        let model = sliding_bodies::Model { data: data(&case, share), regions };
        let held = constraints(&space, shear, down);
        let problem = ContactProblem::new(&space, model, held);
        let found = forces(&problem, &start, &case);
        if let Some(force) = &found {
            compare(&case, force, [MU * shear, -pressure]);
        }
        found.is_some()
    });
}

/// Glue that has been torn to any opening, and is torn on, let go or pressed.
#[test]
fn glued_bodies() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    all(11, |random| {
        let (case, touch) = (case(random), pairing(random));
        let mut largest = random.between(-0.5, 1.2).max(0.0) * END;
        let length = random.between(-0.02, 1.2 * END);
        let mut law = model(&assembler, &touch);
        law.data.largest_opening = assembler.history_on_pairs(&touch.0, 4, largest).unwrap();
        let held = constraints(&space, 0.0, -length);
        let problem = ContactProblem::new(&space, law, held).assembler(assembler.clone());
        let found = forces(&problem, &random.start(&space, 0.005), &case);
        if let Some(force) = &found {
            compare(&case, force, [0.0, torn(length, &mut largest)]);
        }
        found.is_some()
    });
}
