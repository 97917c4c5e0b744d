//! The log barrier between two bodies.

use forms_contact::laws::barrier_bodies::{barrier_bodies as law, barrier_bodies_problem};
use forms_contact::laws::barrier_obstacle::stiffness;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::layer::{LAMBDA, MU, wave};

/// Squares on unlike meshes, with a small gap.
fn squares(gap: f64) -> Mesh<2> {
    let lower = rectangle([0.0; 2], [1.0; 2], [7, 5], CellShape::Quadrilateral, 1).unwrap();
    let upper = rectangle([0.0, 1.0 + gap], [1.0, 2.0 + gap], [5, 4], CellShape::Quadrilateral, 1).unwrap();
    Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap()
}

fn model(pairing: Pairing, share: f64, reach: f64) -> law::Model<2> {
    let data =
        law::data().barrier_stiffness(stiffness(0.1, reach)).activation_gap(reach).lambda(LAMBDA).mu(MU);
    let regions = law::Regions::default().touch(pairing).gamma_n("upper top");
    law::Model { data: data.share(share).traction([0.02, -0.1]), regions }
}

#[test]
fn a_uniform_pressure_is_reproduced_and_forces_balance() {
    let (gap, reach) = (0.004, 0.01);
    let mesh = squares(gap);
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix_component("lower bottom", 1, |_| 0.0).unwrap();
    held.fix_component("lower left", 0, |_| 0.0).unwrap();
    held.fix_component("upper left", 0, |_| 0.0).unwrap();
    let pairings = [
        (Pairing::onto("lower top", "upper bottom"), 1.0),
        (Pairing::between("lower top", "upper bottom"), 0.5),
    ];
    for (pairing, share) in pairings {
        let mut model = model(pairing, share, reach);
        model.data.traction = Given::constant([0.0, -0.1]);
        let solved = barrier_bodies_problem(&model, &space).unwrap().constrained(&held).solve().unwrap();
        let u = solved.field();
        assert!((solved.functional(&model.contact_force(u)).unwrap() - 0.1).abs() < 1e-11);
        // The pressure of κ belongs to half of ĝ: the upper body falls by the rest of the gap.
        let [top, bottom] =
            [[0.5, 1.0 + gap + 1e-12], [0.5, 1.0 - 1e-12]].map(|x| u.evaluate(&x).unwrap()[1]);
        assert!((gap + top - bottom - 0.5 * reach).abs() < 1e-10, "{top} {bottom}");
        let forces = solved.residual.iter().skip(1).step_by(2).sum::<f64>();
        assert!((forces - 0.1).abs() < 1e-12, "{forces}");
    }
}

#[test]
fn the_tangent_is_the_derivative() {
    let mesh = squares(0.02);
    let space = Space::vector(&mesh, 2).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let model = model(Pairing::between("lower top", "upper bottom"), 0.5, 0.03);
    let (u, direction) = (wave(&space, 0.003, 0.3), wave(&space, 0.003, 1.1));
    let report = verification::tangent(&assembler, &model.direct(), &[&u], &[&direction], 0.05).unwrap();
    assert!(report.second_order().unwrap() > 1.95, "{report}");
    let residual = assembler.residual(&model.direct(), &[&u], &[&space]).unwrap();
    // The load is all that does not balance.
    let [aside, down] = [0, 1].map(|k| residual.iter().skip(k).step_by(2).sum::<f64>());
    assert!((aside + 0.02).abs() < 1e-12 && (down - 0.1).abs() < 1e-12, "{aside} {down}");
}
