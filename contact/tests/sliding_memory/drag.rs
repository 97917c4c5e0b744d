//! Blocks drawn along slabs with friction by springs that remember: forces in closed form, whatever the number of steps, energy lost in a
//! closed cycle, turned bodies, paths with corners in space.

use forms_contact::laws::friction_with_memory as law;
use forms_contact::laws::friction_with_memory::penalty_with_memory as penalty;
use forms_fem::history::WithoutPartner;
use forms_fem::prelude::*;

use crate::bodies::{APART, LAMBDA, MU, YOUNG, along, moved, plane, space, touch};

/// κ.
const FRICTION: f64 = 0.3;
/// ε \[stress/length\].
const STIFFNESS: f64 = 500.0;
/// The overlap of the surfaces \[length\].
const DEPTH: f64 = 1e-3;

/// Bodies of given displacements, with what the own points remember.
struct Drag<const D: usize> {
    space: Arc<Space<D>>,
    assembler: Assembler<D>,
    data: law::Data<D>,
    before: Field<D>,
}

impl<const D: usize> Drag<D>
where
    Dim: Dimension<D>,
{
    fn new(mesh: &Mesh<D>, start: [f64; D]) -> Self {
        let space = Space::vector(mesh, 1).unwrap();
        let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(3));
        let remembered = assembler.history_on_sliding_pairs(&touch(), 3, [0.0; D]).unwrap();
        let data = law::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(20.0 * YOUNG)
            .stick_stiffness(STIFFNESS)
            .elastic_slip(remembered)
            .share(1.0)
            .friction(FRICTION);
        let before = moved(&space, start);
        Drag { space, assembler, data, before }
    }

    fn law(&self, direction: [f64; D]) -> law::Model<D> {
        let data = self
            .data
            .clone()
            .displacement_before(Given::field(&self.before))
            .force_direction(Given::constant(direction));
        law::Model { data, regions: law::Regions::default().touch(touch()).gamma_n("block top") }
    }

    /// The force of the slab on the block at a displacement.
    fn force(&self, u: &Field<D>) -> [f64; D] {
        std::array::from_fn(|axis| {
            let force = self.law(along(axis, 1.0)).contact_force(u);
            self.assembler.functional(&force).unwrap()
        })
    }

    /// The step is over.
    fn remember(&mut self, u: &Field<D>) {
        let law = self.law([0.0; D]);
        let remembered = &law.data.elastic_slip;
        self.assembler
            .update_sliding_history(&law.slip_after_step(u), remembered, &touch(), u, WithoutPartner::Restart)
            .unwrap();
        remembered.commit();
        self.before = u.clone();
    }

    /// The force of each of some steps to places of the block.
    fn along(&mut self, places: impl IntoIterator<Item = [f64; D]>) -> Vec<[f64; D]> {
        let mut forces = vec![];
        for place in places {
            let u = moved(&self.space, place);
            forces.push(self.force(&u));
            self.remember(&u);
        }
        forces
    }
}

/// A displacement of the block that presses, at a distance along the first axis.
fn at<const D: usize>(distance: f64) -> [f64; D] {
    let mut place = along(0, distance);
    place[D - 1] = -APART - DEPTH;
    place
}

fn steps<const D: usize>(distance: f64, count: usize) -> impl Iterator<Item = [f64; D]> {
    (1..=count).map(move |step| at(distance * step as f64 / count as f64))
}

/// κ N where the block slides, ε d per area where it sticks, to rounding and for any number of steps.
fn forces_in_closed_form<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let last = |distance: f64, count: usize| {
        let mut drag = Drag::new(mesh, at(0.0));
        drag.along(steps(distance, count)).pop().unwrap()
    };
    // The area of the surface is 1.
    let elastic = FRICTION * last(0.0, 1)[D - 1] / STIFFNESS;
    for count in [1, 3, 10, 40] {
        let (sliding, sticking) = (last(1.2, count), last(0.9 * elastic, count));
        assert!((sliding[0] / (FRICTION * sliding[D - 1]) + 1.0).abs() < 1e-11, "{count}: {sliding:?}");
        assert!((sticking[0] / (STIFFNESS * 0.9 * elastic) + 1.0).abs() < 1e-11, "{count}: {sticking:?}");
    }
}

#[test]
fn forces_do_not_depend_on_the_number_of_steps() {
    forces_in_closed_form(&plane(4));
    forces_in_closed_form(&space());
}

/// Springs that forget are those of the penalty method: their force vanishes with the length of the steps.
#[test]
fn without_memory_the_force_vanishes_with_the_steps() {
    let mesh = plane(4);
    let force = |count: usize| {
        let mut drag = Drag::new(&mesh, at(0.0));
        let mut force = 0.0;
        for place in steps(0.01, count) {
            let u = moved(&drag.space, place);
            force = drag.force(&u)[0];
            drag.before = u;
        }
        -force
    };
    let forces = [10, 20, 40].map(force);
    assert!(forces.windows(2).all(|two| (two[0] / two[1] - 2.0).abs() < 1e-9), "{forces:?}");
}

/// The area of the loop of force and distance in a closed cycle: 4 κN (d − κN/ε) for an amplitude d.
#[test]
fn a_closed_cycle_loses_the_energy_of_its_loop() {
    let mesh = plane(3);
    let mut drag = Drag::new(&mesh, at(0.0));
    let bound = FRICTION * drag.along([at(0.0)])[0][1];
    let elastic = bound / STIFFNESS;
    // Steps end where sliding begins, so that the trapezoidal rule is exact.
    let (step, amplitude) = (elastic / 5.0, 4.0 * elastic);
    let count = 20;
    let way = (0..=count).map(|k| k as f64 * step);
    let back = (1..=2 * count).map(|k| amplitude - k as f64 * step);
    let again = (1..=2 * count).map(|k| k as f64 * step - amplitude);
    let distances: Vec<f64> = way.chain(back).chain(again).collect();
    let forces = drag.along(distances.iter().map(|distance| at(*distance)));
    let work = |from: usize, to: usize| -> f64 {
        (from..to).map(|k| -0.5 * (forces[k][0] + forces[k + 1][0]) * (distances[k + 1] - distances[k])).sum()
    };
    let cycle = work(count, 5 * count);
    let expected = 4.0 * bound * (amplitude - elastic);
    assert!((cycle / expected - 1.0).abs() < 1e-9, "{cycle} {expected}");
    assert!((forces[count][0] / forces[5 * count][0] - 1.0).abs() < 1e-11);
    // The first way: the springs' energy, and what has slid.
    let first = bound * elastic / 2.0 + bound * (amplitude - elastic);
    assert!((work(0, count) / first - 1.0).abs() < 1e-9);
}

/// Both bodies are turned together: the springs turn along, and nothing slides.
#[test]
fn turned_bodies_keep_their_springs() {
    let mesh = plane(4);
    let mut drag = Drag::new(&mesh, at(0.0));
    let elastic = FRICTION * drag.along([at(0.0)])[0][1] / STIFFNESS;
    let place = at(0.7 * elastic);
    let before = drag.along([place])[0];
    assert!((before[0] + 0.7 * STIFFNESS * elastic).abs() < 1e-10);
    for angle in [0.3_f64, 0.9, 1.7] {
        let (sin, cos) = angle.sin_cos();
        let turned = |v: [f64; 2]| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]];
        let u = Field::interpolate(&drag.space, |x: &[f64; 2]| {
            let by = if crate::bodies::is_of_block(x) { place } else { [0.0; 2] };
            let y = turned([x[0] + by[0], x[1] + by[1]]);
            [y[0] - x[0], y[1] - x[1]]
        });
        let u = u.unwrap();
        let (force, expected) = (drag.force(&u), turned(before));
        let error = (0..2).map(|k| (force[k] - expected[k]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-11 * before[1], "{angle}: {force:?} {expected:?}");
        drag.remember(&u);
    }
}

/// A path with a corner, in space: radial return of the force at each step, far beyond the facets where it began.
#[test]
fn paths_with_corners_follow_radial_return() {
    let mut drag = Drag::new(&space(), at(0.0));
    let bound = FRICTION * drag.along([at(0.0)])[0][2];
    let elastic = bound / STIFFNESS;
    let mut places: Vec<[f64; 3]> = steps(1.1, 7).collect();
    let corner = *places.last().unwrap();
    places.extend((1..=12).map(|k| [corner[0], 0.4 * elastic * k as f64, corner[2]]));
    places.extend((1..=6).map(|k| [corner[0] - 0.12 * k as f64, 0.1 * k as f64, corner[2]]));
    let forces = drag.along(places.iter().copied());
    let (mut slip, mut last) = ([0.0_f64; 2], [0.0; 2]);
    for (place, force) in places.iter().zip(&forces) {
        slip = [0, 1].map(|k| slip[k] + place[k] - last[k]);
        last = [place[0], place[1]];
        let size = slip[0].hypot(slip[1]);
        if size > elastic {
            slip = slip.map(|component| component * elastic / size);
        }
        for k in 0..2 {
            assert!((force[k] + STIFFNESS * slip[k]).abs() < 1e-11 * bound, "{place:?}: {force:?} {slip:?}");
        }
    }
}

/// A block of height 1 that shears above its springs, by Nitsche's method and on springs in the normal direction: Δ/(1/ε + 1/μ) while it sticks,
/// κ N afterwards. The vertical displacement is given, so that the block is in simple shear.
#[test]
fn springs_and_shear_in_series() {
    let mesh = plane(4);
    let solve = |is_penalty: bool, distance: f64, count: usize| {
        let mut drag = Drag::new(&mesh, at(0.0));
        let mut force = [0.0; 2];
        for place in steps::<2>(distance, count) {
            let mut held = Constraints::new(&drag.space);
            held.fix("slab", |_| [0.0; 2]).unwrap();
            held.fix_component("block", 1, |_| place[1]).unwrap();
            held.fix_component("block top", 0, |_| place[0]).unwrap();
            let law = drag.law([0.0; 2]);
            let regions = penalty::Regions::default().touch(touch()).gamma_n("block top");
            let springs = penalty::Model { data: law.data.clone(), regions };
            let form = if is_penalty { springs.direct() } else { law.direct() };
            let options = NewtonOptions {
                relative_tolerance: 1e-13,
                line_search: LineSearch::OnResidual,
                ..NewtonOptions::default()
            };
            let problem = Problem::new(&form, &drag.space).constrained(&held).assembler(&drag.assembler);
            let u = problem.start(&drag.before).options(options).solve().unwrap().into_field();
            force = drag.force(&u);
            drag.remember(&u);
        }
        force
    };
    let stiffness = 1.0 / (1.0 / STIFFNESS + 1.0 / MU);
    for is_penalty in [false, true] {
        for count in [1, 2, 8] {
            let force = solve(is_penalty, 0.004, count);
            assert!((force[0] / (stiffness * 0.004) + 1.0).abs() < 1e-9, "{count}: {force:?}");
            let force = solve(is_penalty, 0.5, count);
            assert!((force[0] / (FRICTION * force[1]) + 1.0).abs() < 1e-9, "{count}: {force:?}");
        }
    }
}
