//! The penalty method with means over own facets.

use forms_contact::ContactProblem;
use forms_contact::laws::mean_penalty_bodies as law;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::bodies::{
    LAMBDA, MU, Moments, apart, bent, check_balance, check_tangent, constraints, direction, layers, pairings,
};

fn model(pairing: &Pairing, friction: f64, gamma0: f64, share: f64) -> law::Model<2> {
    let data = law::data().lambda(LAMBDA).mu(MU).gamma0(gamma0).share(share).friction(friction);
    law::Model { data, regions: law::Regions::default().touch(pairing.clone()).gamma_n("upper top") }
}

#[test]
fn tangents_and_the_energy() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.07);
    let space = Space::vector(&mesh, 1).unwrap();
    let u = bent(&space, 0.03);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
    let pairing = &pairings()[0].0;
    check_tangent(&assembler, &model(pairing, 0.3, 1e3, 0.5).direct(), &u);
    let energy = model(pairing, 0.0, 1e3, 0.5).stored();
    let form: Form<2> = energy.clone().into();
    check_tangent(&assembler, &form, &u);
    let (residual, w) = (assembler.residual(&form, &[&u], &[&space]).unwrap(), direction(&space));
    let slope: f64 = residual.iter().zip(w.values()).map(|(a, b)| a * b).sum();
    let report = verification::taylor(1e-4, &[slope], |step| {
        let values = u.values().iter().zip(w.values()).map(|(a, b)| a + step * b);
        let moved = Field::from_values(&space, values.collect()).unwrap();
        assembler.energy(&energy, &[&moved]).map(verification::Sample::from)
    });
    assert!(report.unwrap().second_order().unwrap() > 1.95);
    let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
    let back = tangent.multiply_transposed(w.values()).unwrap();
    assert!(apart(&tangent.multiply(w.values()).unwrap(), &back) < 1e-13);
}

/// Forces of the energy on parallel surfaces: those of the law.
#[test]
fn the_energy_of_parallel_surfaces() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.07);
    let space = Space::vector(&mesh, 1).unwrap();
    let pressed = |x: &[f64; 2]| [0.02 * x[1], if x[1] > 0.5 { -0.01 - 0.1 * (x[1] - 0.5) } else { 0.0 }];
    let u = Field::interpolate(&space, pressed).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
    let law = model(&pairings()[0].0, 0.0, 1e3, 0.5);
    let forms: [Form<2>; 2] = [law.direct(), law.stored().into()];
    let [r, s] = forms.map(|form| assembler.residual(&form, &[&u], &[&space]).unwrap());
    assert!(apart(&r, &s) < 1e-13);
}

#[test]
fn forces_and_moments_balance() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.07);
    let space = Space::vector(&mesh, 1).unwrap();
    let u = bent(&space, 0.03);
    let form = model(&pairings()[0].0, 0.0, 1e3, 0.5).direct();
    let residual =
        Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5)).residual(&form, &[&u], &[&space]);
    check_balance(&residual.unwrap(), &u, Moments::Vanish);
}

/// A layer of two bodies with springs between them, nodes that meet: the pressure p solves J + p h/(γ₀ H) = 1 − δ/H.
#[test]
fn layers_whose_nodes_meet() {
    let mesh = layers(CellShape::Quadrilateral, [4, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let (pairing, share) = &pairings()[1];
    let gamma0 = 100.0 * (LAMBDA + 2.0 * MU);
    let problem =
        ContactProblem::new(&space, model(pairing, 0.0, gamma0, *share), constraints(&space, 0.0, 0.01));
    let solved = problem.quadrature(Quadrature::Degree(4)).direct().unwrap().solve().unwrap();
    let found = -solved.reaction("upper top").unwrap()[1] / crate::bodies::WIDTH;
    let diameter = (0.375_f64.powi(2) + 0.25_f64.powi(2)).sqrt();
    let pressure = |stretch: f64| MU * (1.0 / stretch - stretch) - LAMBDA * stretch.ln() / stretch;
    // Bisection for the stretch of both layers.
    let (mut low, mut high) = (0.9, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let shortened = 1.0 - middle + pressure(middle) * diameter / gamma0;
        if shortened > 0.01 { low = middle } else { high = middle }
    }
    assert!((found / pressure(low) - 1.0).abs() < 1e-9, "{found} {}", pressure(low));
}
