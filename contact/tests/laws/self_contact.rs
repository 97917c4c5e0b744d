//! A body that closes on itself: a ring with a slit, pressed together until its ends touch. One surface that may touch itself
//! gives what its two ends give as two surfaces, forces and moments balance, and turning the whole changes nothing.

use std::f64::consts::TAU;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as law;
use forms_contact::laws::two_bodies::data;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::setting::{LAMBDA, MU, YOUNG};

/// Half of the slit's angle.
const SLIT: f64 = 0.04;

/// The ring between the radii 1 and 1.4 with its slit at angle 0; cells of the two ends do not match. "skin" is its inside with both ends.
fn slit_ring() -> Mesh<2> {
    let mut mesh = structured([24, 4], CellShape::Quadrilateral, 1, |[s, t]| {
        let angle = -SLIT - s * (TAU - 2.0 * SLIT);
        let radius = 1.0 + 0.4 * t.powf(1.0 + 0.4 * s);
        [radius * angle.cos(), radius * angle.sin()]
    })
    .unwrap();
    let [lower, upper, inside] =
        ["left", "right", "bottom"].map(|end| mesh.facet_region(end).unwrap().to_vec());
    mesh.name_listed_facets("skin", &[lower.clone(), upper.clone(), inside].concat()).unwrap();
    mesh.name_listed_facets("lower end", &lower).unwrap();
    mesh.name_listed_facets("upper end", &upper).unwrap();
    mesh.name_facets("back", "top", |x| x[0] < -1.2).unwrap();
    mesh.name_facets("pushed down", "top", |x| x[0] > 0.9 && x[1] > 0.0).unwrap();
    mesh.name_facets("pushed up", "top", |x| x[0] > 0.9 && x[1] < 0.0).unwrap();
    mesh
}

fn model(space: &Arc<Space<2>>, touch: Pairing, friction: f64) -> law::Model<2> {
    let required = data().lambda(LAMBDA).mu(MU).gamma0(10.0 * YOUNG);
    let before = Given::field(Field::zero(space));
    let data = required.friction(friction).displacement_before(before);
    law::Model { data, regions: law::Regions::default().touch(touch).gamma_n("top") }
}

/// The ends are pushed together, one further than the other, so that they slide.
fn closed(space: &Arc<Space<2>>, touch: Pairing, friction: f64) -> Field<2> {
    let mut constraints = Constraints::new(space);
    constraints.fix("back", |_| [0.0, 0.0]).unwrap();
    constraints.fix("pushed down", |_| [0.0, -0.07]).unwrap();
    constraints.fix("pushed up", |_| [0.02, 0.06]).unwrap();
    let law = model(space, touch, friction);
    let problem = ContactProblem::new(space, law, constraints);
    let solved = problem.direct().unwrap().solve().unwrap();
    println!("friction {friction}: {} steps", solved.iterations());
    solved.into_field()
}

fn residual(space: &Arc<Space<2>>, friction: f64, u: &Field<2>) -> Vec<f64> {
    let form = model(space, Pairing::within("skin"), friction).direct();
    Assembler::new(space.mesh()).residual(&form, &[u], &[space]).unwrap()
}

/// Force of the ends on each other.
fn pressed_with(space: &Arc<Space<2>>, u: &Field<2>) -> f64 {
    let mut law = model(space, Pairing::onto("lower end", "upper end"), 0.0);
    law.data.force_direction = Given::constant([0.0, -1.0]);
    Assembler::new(space.mesh()).functional(&law.contact_force(u)).unwrap()
}

#[test]
fn one_surface_and_two() {
    let space = Space::vector(&slit_ring(), 1).unwrap();
    for friction in [0.0, 0.3] {
        let own = closed(&space, Pairing::within("skin"), friction);
        let two = closed(&space, Pairing::between("lower end", "upper end"), friction);
        let force = pressed_with(&space, &own);
        println!("force {force}");
        assert!(force > 0.01 * YOUNG * 0.4, "the ends hardly touch: {force}");
        let apart = own.values().iter().zip(two.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-10, "friction {friction}: {apart:.1e}");
    }
}

#[test]
fn forces_and_moments_balance() {
    let space = Space::vector(&slit_ring(), 1).unwrap();
    let u = closed(&space, Pairing::within("skin"), 0.0);
    for friction in [0.0, 0.3] {
        let forces = residual(&space, friction, &u);
        let size: f64 = forces.iter().map(|force| force.abs()).sum();
        for axis in 0..2 {
            let sum: f64 = forces.iter().skip(axis).step_by(2).sum();
            assert!(sum.abs() < 1e-13 * size, "friction {friction}: {sum:.1e} of {size}");
        }
        // Points lie opposite to each other along the normal: friction alone has a moment across a gap.
        let places = space.positions().iter().zip(u.values().chunks(2)).zip(forces.chunks(2));
        let moment: f64 = places.map(|((x, u), f)| (x[0] + u[0]) * f[1] - (x[1] + u[1]) * f[0]).sum();
        println!("friction {friction}: moment {moment:.1e} of {size:.1}");
        assert!(friction > 0.0 || moment.abs() < 1e-13 * size, "{moment:.1e} of {size}");
    }
}

#[test]
fn turning_the_whole_changes_nothing() {
    let space = Space::vector(&slit_ring(), 1).unwrap();
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    let turn = |v: [f64; 2]| [cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1]];
    for friction in [0.0, 0.3] {
        let u = closed(&space, Pairing::within("skin"), friction);
        let turned = space.positions().iter().zip(u.values().chunks(2)).flat_map(|(x, u)| {
            let y = turn([x[0] + u[0], x[1] + u[1]]);
            [y[0] - x[0] + 0.7, y[1] - x[1] - 0.2]
        });
        let turned = Field::from_values(&space, turned.collect()).unwrap();
        // The slip is counted from u itself, so that what would slip by turning were seen.
        let [still, moved] = [(&u, &u), (&turned, &u)].map(|(at, before)| {
            let mut law = model(&space, Pairing::within("skin"), friction);
            law.data.displacement_before = Given::field(before);
            Assembler::new(space.mesh()).residual(&law.direct(), &[at], &[&space]).unwrap()
        });
        let size = still.iter().fold(0.0_f64, |size, force| size.max(force.abs()));
        let mut largest = 0.0_f64;
        for (still, moved) in still.chunks(2).zip(moved.chunks(2)) {
            let still = turn([still[0], still[1]]);
            for axis in 0..2 {
                largest = largest.max((still[axis] - moved[axis]).abs());
            }
        }
        println!("friction {friction}: turned, forces differ by {:.1e} of the largest", largest / size);
        assert!(largest < 3e-13 * size, "friction {friction}: {largest:.1e} of {size}");
    }
}
