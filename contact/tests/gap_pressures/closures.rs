//! Exponential and tabulated pressures on a flat.

use forms_contact::ContactProblem;
use forms_contact::laws::exponential_obstacle as exponential;
use forms_contact::laws::tabulated_obstacle as tabulated;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::layer::{GAP, LAMBDA, MU, balanced, below, held, plane, solid, wave};

const CLOSED: f64 = 0.3;
const LENGTH: f64 = 0.004;

fn model<const D: usize>(length: f64) -> exponential::Model<D> {
    let data = exponential::data().lambda(LAMBDA).mu(MU).closed_pressure(CLOSED).closure_length(length);
    let weight = |x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]);
    let data = data.obstacle_normal(below()).gap(GAP).criterion_force(weight);
    exponential::Model { data, regions: exponential::Regions::default().gamma_c("bottom").gamma_n("top") }
}

fn table<const D: usize>(closure: Table) -> tabulated::Model<D> {
    let data = tabulated::data().lambda(LAMBDA).mu(MU).obstacle_normal(below()).gap(GAP).closure(closure);
    tabulated::Model { data, regions: tabulated::Regions::default().gamma_c("bottom").gamma_n("top") }
}

fn layers<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 2).unwrap();
    let way = 0.08;
    let check = |u: &Field<D>, gap: f64| {
        let bottom = gap - GAP;
        let found = u.evaluate(&[0.4; D]).unwrap()[D - 1];
        let expected = bottom + 0.4 * (-way - bottom);
        assert!((found - expected).abs() < 1e-11, "{D}D: {found}, {expected}");
    };
    let problem =
        ContactProblem::new(&space, model::<D>(LENGTH), held(&space, way)).quadrature(Quadrature::Degree(4));
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    check(&u, balanced(way, |g| CLOSED * (-g / LENGTH).exp()));
    // Pressures 0.4 at a gap of 0, 0.1 at 0.005, 0 from 0.02 on.
    let closure = Table::linear(&[[0.0, 0.4], [0.005, 0.1], [0.02, 0.0]]).unwrap().constant_outside();
    let problem =
        ContactProblem::new(&space, table::<D>(closure), held(&space, way)).quadrature(Quadrature::Degree(4));
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    check(
        &u,
        balanced(way, |g| if g < 0.005 { 0.4 - 60.0 * g } else { (0.1 - (g - 0.005) / 0.15).max(0.0) }),
    );
}

#[test]
fn layers_have_the_gap_of_their_pressure() {
    layers(&plane());
    layers(&solid());
}

#[test]
fn tangents_and_gradients() {
    let mesh = plane();
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let (u, direction) = (wave(&space, 0.02, 0.3), wave(&space, 0.02, 1.1));
    let smooth = Table::natural_spline(&[[0.0, 0.4], [0.02, 0.2], [0.05, 0.05], [0.1, 0.0]]).unwrap();
    for form in [model::<2>(0.02).direct(), table::<2>(smooth).direct()] {
        let report = verification::tangent(&assembler, &form, &[&u], &[&direction], 0.02).unwrap();
        assert!(report.second_order().unwrap() > 1.9, "{report}");
    }
    let mut tilted = Constraints::new(&space);
    tilted.fix("top", |x| [0.01, -0.08 + 0.03 * x[0]]).unwrap();
    let solve = |length: f64| {
        let problem =
            ContactProblem::new(&space, model::<2>(length), tilted.clone()).assembler(assembler.clone());
        let u = problem.direct().unwrap().solve().unwrap().into_field();
        let value = assembler.functional(&problem.law.criterion(&u)).unwrap();
        (problem, u, value)
    };
    let (problem, u, _) = solve(LENGTH);
    let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
    let found = assembler.functional(&problem.law.by_closure_length(&u, &p)).unwrap();
    let step = 1e-6;
    let difference = (solve(LENGTH + step).2 - solve(LENGTH - step).2) / (2.0 * step);
    assert!((found - difference).abs() < 1e-7 * difference.abs(), "{found} {difference}");
}
