//! Nitsche's method with means over own facets whose points slide.

use forms_contact::ContactProblem;
use forms_contact::laws::mean_sliding_bodies as law;
use forms_contact::laws::mean_sliding_bodies::mean_sliding_bodies_of_degree_two as quadratic;
use forms_contact::laws::sliding_bodies as at_points;
use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;

use crate::bodies::{
    LAMBDA, MU, Moments, apart, bent, check_balance, check_tangent, constraints, direction, layers,
    layers_in_space, pairings,
};

fn data<const D: usize>(friction: f64, share: f64) -> at_points::Data<D> {
    at_points::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(10.0 * (LAMBDA + 2.0 * MU))
        .share(share)
        .friction(friction)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]))
}

fn linear<const D: usize>(pairing: &Pairing, friction: f64, share: f64) -> law::Model<D> {
    let regions = law::Regions::default().touch(pairing.clone()).gamma_n("upper top");
    law::Model { data: data(friction, share), regions }
}

#[test]
fn tangents() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.07);
    let rule = Quadrature::Degree(5);
    let assembler = Assembler::new(&mesh).with_quadrature(rule.clone());
    let on_segments = pairings().map(|(pairing, share)| (pairing.at(PairQuadrature::Pieces), share));
    for (pairing, share) in pairings().into_iter().chain(on_segments) {
        let space = Space::vector(&mesh, 1).unwrap();
        check_tangent(&assembler, &linear(&pairing, 0.3, share).direct(), &bent(&space, 0.03));
        let space = Space::vector(&mesh, 2).unwrap();
        let regions = quadratic::Regions::default().touch(pairing.clone()).gamma_n("upper top");
        let form = quadratic::Model { data: data(0.3, share), regions }.direct();
        check_tangent(&assembler, &form, &bent(&space, 0.03));
    }
    let mesh = layers_in_space([2, 3]);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
    check_tangent(&assembler, &linear(&pairings()[0].0, 0.3, 0.5).direct(), &bent(&space, 0.03));
}

#[test]
fn forces_and_moments_balance() {
    let mesh = layers(CellShape::Triangle, [3, 4], 0.07);
    let space = Space::vector(&mesh, 1).unwrap();
    let u = bent(&space, 0.03);
    for (friction, moments) in [(0.0, Moments::Vanish), (0.3, Moments::HaveGaps)] {
        let form = linear::<2>(&pairings()[0].0, friction, 0.5).direct();
        let residual =
            Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5)).residual(&form, &[&u], &[&space]);
        check_balance(&residual.unwrap(), &u, moments);
    }
}

/// One point per facet: the mean is the value.
#[test]
fn with_one_point_it_is_the_law_at_points() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.07);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (bent(&space, 0.03), direction(&space));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(1));
    let regions = at_points::Regions::default().touch(pairings()[0].0.clone()).gamma_n("upper top");
    let pointwise = at_points::Model { data: data(0.3, 0.5), regions }.direct();
    let forms = [linear(&pairings()[0].0, 0.3, 0.5).direct(), pointwise];
    let [r, s] = forms.each_ref().map(|form| assembler.residual(form, &[&u], &[&space]).unwrap());
    assert!(apart(&r, &s) < 1e-14);
    let [k, l] = forms.map(|form| assembler.tangent(&form, &[&u], &[&space]).unwrap());
    assert!(apart(&k.multiply(w.values()).unwrap(), &l.multiply(w.values()).unwrap()) < 1e-13);
}

/// The uniform state on meshes whose nodes meet, and on segments whatever the meshes. On others the points of whole facets break it, with
/// means or without.
#[test]
fn patches() {
    let solve = |degree: usize, points: PairQuadrature| {
        let upper = if points == PairQuadrature::Pieces { 3 } else { 4 };
        let mesh = layers(CellShape::Quadrilateral, [4, upper], 0.0);
        let space = Space::vector(&mesh, degree).unwrap();
        let held = constraints(&space, 0.0, 0.01);
        let (pairing, share) = &pairings()[0];
        let pairing = &pairing.clone().at(points);
        let u = match degree {
            1 => {
                let problem = ContactProblem::new(&space, linear(pairing, 0.0, *share), held);
                problem.quadrature(Quadrature::Degree(4)).direct().unwrap().solve().unwrap().into_field()
            }
            _ => {
                let regions = quadratic::Regions::default().touch(pairing.clone()).gamma_n("upper top");
                let law = quadratic::Model { data: data(0.0, *share), regions };
                let problem = ContactProblem::new(&space, law, held);
                problem.quadrature(Quadrature::Degree(4)).direct().unwrap().solve().unwrap().into_field()
            }
        };
        let stretch = 0.99_f64;
        let pressure = MU * (1.0 / stretch - stretch) - LAMBDA * stretch.ln() / stretch;
        let stress = linear::<2>(pairing, 0.0, *share).first_piola(&u);
        let found = Assembler::new(&mesh).at_quadrature_points(&stress, Entity::Cells, "all", 4).unwrap();
        found.values.iter().fold(0.0, |worst: f64, value| worst.max((value[3] + pressure).abs() / pressure))
    };
    let errors = [1, 2].map(|degree| {
        [PairQuadrature::WholeFacets, PairQuadrature::Pieces].map(|points| solve(degree, points))
    });
    let errors = errors.as_flattened();
    assert!(errors.iter().all(|error| *error < 1e-10), "{errors:?}");
}

/// dJ/dκ by the adjoint against differences of solutions.
#[test]
fn the_adjoint_compared_with_differences() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.07);
    let space = Space::vector(&mesh, 1).unwrap();
    let problem = |friction: f64| {
        let law = linear::<2>(&pairings()[0].0, friction, 0.5);
        let mut held = Constraints::new(&space);
        held.fix("lower bottom", |_| [0.0; 2]).unwrap();
        held.fix("upper top", |_| [0.02, -0.01]).unwrap();
        ContactProblem::new(&space, law, held).quadrature(Quadrature::Degree(5))
    };
    let criterion = |friction: f64| {
        let problem = problem(friction);
        let u = problem.direct().unwrap().solve().unwrap().into_field();
        problem.assembler.functional(&problem.law.criterion(&u)).unwrap()
    };
    let at = problem(0.3);
    let u = at.direct().unwrap().solve().unwrap().into_field();
    let p = at.adjoint(&u).unwrap().solve().unwrap().into_field();
    let slope = at.assembler.functional(&at.law.by_friction(&u, &p)).unwrap();
    let step = 1e-4;
    let difference = (criterion(0.3 + step) - criterion(0.3 - step)) / (2.0 * step);
    assert!(difference.abs() > 1e-6 && (slope / difference - 1.0).abs() < 1e-6, "{slope} {difference}");
}
