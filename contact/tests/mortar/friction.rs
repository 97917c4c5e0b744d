//! Friction by multipliers: a block that is pressed on a rigid slab and drawn along it sticks without creep, or slides by Coulomb's law.

use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as law;
use forms_contact::laws::mortar_bodies::{data, frictional_mortar_problem};
use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;

use crate::exact::{check_tangent, multipliers, nodal};
use crate::patch::{LAMBDA, MU};

/// The way down of the top of the block, which is 1 high.
const DOWN: f64 = 0.05;

pub fn mesh() -> Mesh<2> {
    let slab = rectangle([0.0, -0.4], [4.0, 0.0], [11, 1], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([0.3, 0.0], [1.3, 1.0], [4, 3], CellShape::Quadrilateral, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap()
}

fn options() -> NewtonOptions {
    NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    }
}

fn held(space: &Arc<Space<2>>, aside: f64) -> Constraints<2> {
    let mut held = Constraints::new(space);
    held.fix("slab", |_| [0.0; 2]).unwrap();
    held.fix("block top", |_| [aside, -DOWN]).unwrap();
    held
}

/// The force of the slab on the block after it was pressed and drawn in some equal steps, the largest displacement of the block's bottom, and ∫ t / ∫ p.
pub fn drawn(
    (degree, of_multipliers): (usize, &Elements),
    friction: f64,
    along: f64,
    steps: usize,
) -> ([f64; 2], f64, f64) {
    let mesh = mesh();
    let space = Space::vector(&mesh, degree).unwrap();
    let traces =
        Space::of(&mesh, of_multipliers.clone(), Scope::Facets("block bottom".into()), &[2]).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2 * degree + 1));
    let mut u = Field::zero(&space);
    let mut m = nodal(&traces, |_| [10.0, 0.0]);
    let mut d = Field::zero(&traces);
    let touch = Pairing::onto("block bottom", "slab top").at(PairQuadrature::Pieces);
    let (mut force, mut ratio) = ([0.0; 2], 0.0);
    for step in 0..=steps {
        let held = held(&space, along * step as f64 / steps as f64);
        let base = data().lambda(LAMBDA).mu(MU).gamma0(1000.0).friction(friction);
        let base = base.displacement_before(Given::field(&u));
        let model = |direction: [f64; 2]| law::Model {
            data: base.clone().force_direction(Given::constant(direction)),
            regions: law::Regions::default().touch(touch.clone()).own("block bottom").gamma_n("block right"),
        };
        let solved = frictional_mortar_problem(&model([0.0; 2]), [&space, &traces], &held)
            .unwrap()
            .assembler(&assembler)
            .options(options())
            .start([&u, &m, &d])
            .solve()
            .unwrap_or_else(|error| panic!("degree {degree}, step {step}: {error}"));
        [u, m, d] = solved.fields;
        let of = |direction| assembler.functional(&model(direction).contact_force(&u, &m)).unwrap();
        force = [of([1.0, 0.0]), of([0.0, 1.0])];
        let touch = sums::Touch::on(touch.clone());
        let [pressure, along] = [sums::pressure(&touch, &u, &m), sums::along(&touch, &u, &m)];
        ratio = assembler.functional(&along).unwrap() / assembler.functional(&pressure).unwrap();
    }
    let mut moved = 0.0_f64;
    for facet in mesh.facet_region("block bottom").unwrap() {
        for node in space.cell_element(facet.cell as usize).facet_nodes(usize::from(facet.local)) {
            moved = moved.max(u.values()[2 * space.cell_nodes(facet.cell as usize)[node] as usize].abs());
        }
    }
    (force, moved, ratio)
}

/// The elastic block whose bottom is held: the forces on it.
fn clamped(degree: usize, along: f64) -> [f64; 2] {
    let mesh = mesh();
    let space = Space::vector(&mesh, degree).unwrap();
    let mut held = held(&space, along);
    held.fix("block bottom", |_| [0.0; 2]).unwrap();
    let bodies = solid::Model::new(solid::data().lambda(LAMBDA).mu(MU));
    let solved =
        Problem::new(&bodies.energy(), &space).constrained(&held).options(options()).solve().unwrap();
    let force = solved.reaction("block bottom").unwrap();
    [force[0], force[1]]
}

/// The sums of the multipliers over the covered surface.
#[forms(dimension = 2)]
mod sums {
    #[pairs]
    pub struct Touch;
    pub fn pressure(u: State<Vector>, m: State<Vector>) -> Functional {
        integral(Touch(u), this(m[0]))
    }
    pub fn along(u: State<Vector>, m: State<Vector>) -> Functional {
        integral(Touch(u), this(m[1]))
    }
}

#[forms(dimension = 2)]
mod solid {
    pub use forms_contact::operators::neo_hookean::Data;
    use forms_contact::operators::neo_hookean::energy_density;

    #[cells]
    pub struct Omega;
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, energy_density(u))
    }
}

/// With much friction the block is glued, with no creep in any number of steps: its forces are those of a clamped block.
#[test]
fn what_sticks_does_not_creep() {
    for degree in [1, 2] {
        let (along, expected) = (0.004, clamped(degree, 0.004));
        let with = (degree, &Elements::Bernstein(degree));
        let (reference, ..) = drawn(with, 20.0, along, 1);
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) / expected[1];
        // The ends of the block's bottom lift where their multiplier has no pressure.
        println!("degree {degree}: {:.1e}", apart(reference, expected));
        let tolerance = if degree == 1 { 1e-6 } else { 1e-5 };
        assert!(apart(reference, expected) < tolerance, "{degree}: {reference:?} {expected:?}");
        for steps in [1, 4, 13] {
            let (force, moved, _) = drawn(with, 20.0, along, steps);
            println!("degree {degree}, {steps} steps: {moved:.1e}");
            assert!(moved < 1e-12, "it creeps by {moved:e}");
            assert!(apart(force, reference) < 1e-8, "{steps}: {force:?} {reference:?}");
        }
    }
}

/// Over facets of the slab the sum of the tangential multiplier is κ times that of the pressure, to rounding.
#[test]
fn what_slides_bears_its_friction() {
    for (degree, steps) in [(1, 3), (1, 10), (2, 3), (2, 10)] {
        let (force, moved, ratio) = drawn((degree, &Elements::Bernstein(degree)), 0.3, 1.1, steps);
        let upright = force[0] / (0.3 * force[1]) + 1.0;
        println!("degree {degree}, {steps} steps: {:.1e} {upright:.1e}", ratio.abs() / 0.3 - 1.0);
        assert!(moved > 0.8 && force[1] > 5.0, "{moved} {force:?}");
        assert!((ratio.abs() / 0.3 - 1.0).abs() < 1e-10, "{degree} {steps}: {ratio}");
        // Normals of lifted ends are not upright.
        let tolerance = if degree == 1 { 2e-3 } else { 1e-2 };
        assert!(upright.abs() < tolerance, "{degree} {steps}: {force:?}");
    }
}

/// A block over the end of a slab, with nodes that nothing faces. From no tractions it comes to what it bears from a pressure, with every axis.
#[test]
fn from_no_tractions_at_nodes_that_nothing_faces() {
    let slab = rectangle([0.0, -0.4], [4.0, 0.0], [11, 1], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([-0.3, 0.0], [0.7, 1.0], [4, 3], CellShape::Quadrilateral, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
    for degree in [1, 2] {
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = multipliers(&mesh, "block bottom", degree, &[2]);
        for axis in [[1.0, 0.0], [0.0, -1.0], [0.6, -0.8]] {
            let held = held(&space, 0.01);
            let regions = law::Regions::default()
                .touch(Pairing::onto("block bottom", "slab top").at(PairQuadrature::Pieces))
                .own("block bottom")
                .gamma_n("block right");
            let data = data().lambda(LAMBDA).mu(MU).gamma0(1000.0).friction(0.3).axis(axis);
            let model = law::Model { data, regions };
            let from = |pressure: f64| {
                let tractions = nodal(&traces, |_| axis.map(|a| pressure * a));
                let start = [&Field::zero(&space), &tractions, &Field::zero(&traces)];
                let problem = frictional_mortar_problem(&model, [&space, &traces], &held).unwrap();
                let solved = problem.options(options()).start(start).solve();
                let solved = solved.unwrap_or_else(|error| panic!("{degree} {axis:?} {pressure}: {error}"));
                println!("degree {degree}, {axis:?}, from {pressure}: {} steps", solved.iterations());
                solved.fields
            };
            let [[_, found, _], [_, expected, _]] = [from(0.0), from(10.0)];
            let largest = expected.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(largest > 1.0, "{largest}");
            for (node, x) in traces.positions().iter().enumerate() {
                let [found, expected] = [&found, &expected].map(|m| &m.values()[2 * node..2 * node + 2]);
                let apart = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(apart < 1e-8 * largest, "{degree} {axis:?} {x:?}: {found:?} {expected:?}");
                let size = found[0].hypot(found[1]);
                assert!(x[0] > -0.2 || size < 1e-12, "{degree} {axis:?} {x:?}: {found:?}");
            }
        }
    }
}

#[test]
fn an_axis_has_the_length_one() {
    let mesh = mesh();
    let space = Space::vector(&mesh, 1).unwrap();
    let traces = multipliers(&mesh, "block bottom", 1, &[2]);
    let told = |axis: [f64; 2]| {
        let regions = law::Regions::default().touch(Pairing::onto("block bottom", "slab top"));
        let regions = regions.own("block bottom").gamma_n("block right");
        let model = law::Model { data: data().lambda(15.0).mu(10.0).gamma0(350.0).axis(axis), regions };
        let held = held(&space, 0.0);
        let refused = frictional_mortar_problem(&model, [&space, &traces], &held).err();
        refused.map(|error| error.to_string())
    };
    let expected = "form `direct`: the parameter `axis` has the length 2; it must be 1";
    assert_eq!(told([0.0, -2.0]).as_deref(), Some(expected));
    assert_eq!([[0.6, -0.8], [0.0; 2]].map(told), [None, None]);
}

#[test]
fn tangents_with_friction() {
    let mesh = mesh();
    for degree in [1, 2] {
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = multipliers(&mesh, "block bottom", degree, &[2]);
        let bent = |phase: f64| {
            let value = |x: &[f64; 2]| {
                let block = if x[1] > 1e-9 { 1.0 } else { 0.0 };
                let up = 0.02 * (3.0 * x[0] + x[1] + phase).sin();
                [block * 0.2 + 0.02 * (2.0 * x[1] + x[0] + phase).cos(), up - 0.03 * block]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let nodal = |phase: f64| {
            Field::interpolate(&traces, |x: &[f64; 2]| [2.0 + (4.0 * x[0] + phase).sin(), (5.0 * x[0]).cos()])
                .unwrap()
        };
        let base = data().lambda(LAMBDA).mu(MU).gamma0(100.0).friction(0.3);
        let regions = law::Regions::default()
            .touch(Pairing::onto("block bottom", "slab top").at(PairQuadrature::Pieces))
            .own("block bottom")
            .gamma_n("block right");
        let form = law::Model { data: base.displacement_before(Given::field(bent(0.1))), regions }.direct();
        let at = [&bent(0.4), &nodal(0.2), &nodal(0.9)];
        let along = [&bent(1.9), &nodal(2.2), &nodal(1.3)];
        check_tangent(&form, at, along, &format!("degree {degree}"));
    }
}
