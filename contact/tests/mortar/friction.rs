//! Friction by multipliers: a block in simple shear on a rigid slab, which sticks and slides by closed forms, with no creep in many steps.

use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as law;
use forms_contact::laws::mortar_bodies::{data, frictional_mortar_problem};
use forms_fem::constraints::RigidMap;
use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::patch::{LAMBDA, MU};

const FRICTION: f64 = 0.3;
/// The stretch of the block, which is 1 high.
const STRETCH: f64 = 0.8;

fn mesh() -> Mesh<2> {
    let slab = rectangle([0.0, -0.4], [4.0, 0.0], [11, 1], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([0.3, 0.0], [1.3, 1.0], [4, 3], CellShape::Quadrilateral, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap()
}

/// The force of the slab on the block after some steps along, all of them equal, and the largest displacement sideways of the block's bottom.
fn drawn(degree: usize, along: f64, steps: usize) -> ([f64; 2], f64) {
    let mesh = mesh();
    let space = Space::vector(&mesh, degree).unwrap();
    let traces = Space::vector_on_facets(&mesh, "block bottom", degree).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2 * degree + 1));
    let pressure = MU * (1.0 / STRETCH - STRETCH) - LAMBDA * STRETCH.ln() / STRETCH;
    // Close to the slab, as it is pressed, so that the first step begins in contact.
    let mut u = Field::zero(&space);
    let mut m = Field::interpolate(&traces, |_| [pressure, 0.0]).unwrap();
    let mut force = [0.0; 2];
    for step in 0..=steps {
        let aside = along * step as f64 / steps as f64;
        let mut held = Constraints::new(&space);
        held.fix("slab", |_| [0.0; 2]).unwrap();
        held.fix("block top", |_| [aside, STRETCH - 1.0]).unwrap();
        held.periodic("block left", "block right", &RigidMap::translation([1.0, 0.0])).unwrap();
        let base = data().lambda(LAMBDA).mu(MU).gamma0(1000.0).friction(FRICTION);
        let base = base.displacement_before(Given::field(&u));
        let model = |direction: [f64; 2]| law::Model {
            data: base.clone().force_direction(Given::constant(direction)),
            regions: law::Regions::default()
                .touch(Pairing::onto("block bottom", "slab top").at(PairQuadrature::Pieces))
                .own("block bottom")
                .gamma_n("block right"),
        };
        let options = NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        let solved = frictional_mortar_problem(&model([0.0; 2]), [&space, &traces], &held)
            .unwrap()
            .assembler(&assembler)
            .options(options)
            .start([&u, &m])
            .solve()
            .unwrap_or_else(|error| panic!("step {step}: {error}"));
        [u, m] = solved.fields;
        let of = |direction| assembler.functional(&model(direction).contact_force(&u, &m)).unwrap();
        force = [of([1.0, 0.0]), of([0.0, 1.0])];
        assert!((force[1] / pressure - 1.0).abs() < 1e-9, "{force:?} is not {pressure}");
    }
    let mut moved = 0.0_f64;
    for facet in mesh.facet_region("block bottom").unwrap() {
        for node in space.cell_element(facet.cell as usize).facet_nodes(usize::from(facet.local)) {
            moved = moved.max(u.values()[2 * space.cell_nodes(facet.cell as usize)[node] as usize].abs());
        }
    }
    (force, moved)
}

/// τ = μ k for a shear k below κ p/μ = 0.260518, κ p above it; the slip of what sticks is 0, however many steps there are.
#[test]
fn a_block_in_simple_shear_sticks_and_slides() {
    for degree in [1, 2] {
        for steps in [1, 4, 13] {
            let (force, moved) = drawn(degree, 0.25, steps);
            assert!((force[0] / (0.25 * MU) + 1.0).abs() < 1e-9, "{force:?}");
            assert!(moved < 1e-10, "it creeps by {moved:e}");
            let (force, moved) = drawn(degree, 0.9, steps);
            let slips = FRICTION * force[1] / MU;
            assert!(
                (slips - 0.260518).abs() < 1e-6 && (force[0] + FRICTION * force[1]).abs() < 1e-8 * force[1]
            );
            assert!((moved - (0.9 - slips)).abs() < 1e-9, "{moved} {slips}");
        }
    }
}

#[test]
fn tangents_with_friction() {
    let mesh = mesh();
    for degree in [1, 2] {
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = Space::vector_on_facets(&mesh, "block bottom", degree).unwrap();
        let bent = |phase: f64| {
            let value = |x: &[f64; 2]| {
                let block = if x[1] > 1e-9 { 1.0 } else { 0.0 };
                let up = 0.02 * (3.0 * x[0] + x[1] + phase).sin();
                [block * 0.2 + 0.02 * (2.0 * x[1] + x[0] + phase).cos(), up - 0.03 * block]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let multipliers = |phase: f64| {
            Field::interpolate(&traces, |x: &[f64; 2]| [2.0 + (4.0 * x[0] + phase).sin(), (5.0 * x[0]).cos()])
                .unwrap()
        };
        let base = data().lambda(LAMBDA).mu(MU).gamma0(100.0).friction(FRICTION);
        let regions = law::Regions::default()
            .touch(Pairing::onto("block bottom", "slab top").at(PairQuadrature::Pieces))
            .own("block bottom")
            .gamma_n("block right");
        let form = law::Model { data: base.displacement_before(Given::field(&bent(0.1))), regions }.direct();
        let at = [&bent(0.4), &multipliers(0.2)];
        let along = [&bent(1.9), &multipliers(2.2)];
        let report = verification::tangent(&Assembler::new(&mesh), &form, &at, &along, 1e-4).unwrap();
        let order = report.second_order().unwrap();
        assert!((order - 2.0).abs() < 0.05, "{degree}: {report}");
    }
}
