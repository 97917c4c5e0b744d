//! Nitsche's method with means over own facets on pairs of fixed points, small strains, with every θ.

use forms_contact::ContactProblem;
use forms_contact::laws::mean_two_bodies as law;
use forms_contact::laws::two_bodies as at_points;
use forms_fem::prelude::*;

use crate::bodies::{
    LAMBDA, MU, apart, bent, check_tangent, constraints, direction, layers, layers_in_space, pairings,
};

const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

fn data<const D: usize>(friction: f64, theta: f64, share: f64) -> at_points::Data<D> {
    at_points::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(10.0 * (LAMBDA + 2.0 * MU))
        .theta(theta)
        .share(share)
        .friction(friction)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]))
}

fn model<const D: usize>(pairing: &Pairing, friction: f64, theta: f64, share: f64) -> law::Model<D> {
    let regions = law::Regions::default().touch(pairing.clone()).gamma_n("upper top");
    law::Model { data: data(friction, theta, share), regions }
}

/// p = (λ + 2μ) δ, and τ = μ U below κ p/μ, else κ p: exact on pieces, whatever the meshes.
fn patch<const D: usize>(mesh: &Mesh<D>, thetas: &[f64])
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1).unwrap();
    let area = crate::bodies::WIDTH.powi(D as i32 - 1);
    let pressure = (LAMBDA + 2.0 * MU) * 0.01;
    for (pairing, share) in pairings() {
        for &theta in thetas {
            for (aside, shear) in [(0.008, MU * 0.008), (0.02, 0.3 * pressure)] {
                let model = model::<D>(&pairing, 0.3, theta, share);
                let problem = ContactProblem::new(&space, model, constraints(&space, aside, 0.01));
                let solved = problem.direct().unwrap().solve().unwrap();
                let reaction = solved.reaction("upper top").unwrap();
                let found = [reaction[D - 1] / area, reaction[0] / area];
                for (found, expected) in found.into_iter().zip([-pressure, shear]) {
                    let error = (found - expected).abs() / pressure;
                    assert!(error < 1e-12, "theta {theta} {pairing}: {found} is not {expected}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn patches() {
    patch(&layers(CellShape::Quadrilateral, [3, 4], 0.0), &THETAS);
    patch(&layers(CellShape::Triangle, [3, 2], 0.0), &[0.0]);
    patch(&layers_in_space([2, 3]), &[0.0]);
}

#[test]
fn tangents_and_symmetry() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    for theta in THETAS {
        let form = model(&pairings()[0].0, 0.3, theta, 0.5).direct();
        check_tangent(&assembler, &form, &bent(&space, 0.01));
    }
    // Without friction θ = 1 is the variation of an energy.
    let tangent = model(&pairings()[0].0, 0.0, 1.0, 0.5).direct();
    let tangent = assembler.tangent(&tangent, &[&bent(&space, 0.01)], &[&space]).unwrap();
    let w = direction(&space);
    let [there, back] = [tangent.multiply(w.values()), tangent.multiply_transposed(w.values())];
    assert!(apart(&there.unwrap(), &back.unwrap()) < 1e-13);
}

/// One point per facet: the mean is the value.
#[test]
fn with_one_point_it_is_the_law_at_points() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (bent(&space, 0.01), direction(&space));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(1));
    let whole = pairings()[0].0.clone().at(forms_fem::contract::PairQuadrature::WholeFacets);
    for theta in THETAS {
        let regions = at_points::Regions::default().touch(whole.clone()).gamma_n("upper top");
        let pointwise = at_points::Model { data: data(0.3, theta, 0.5), regions }.direct();
        let forms = [model(&whole, 0.3, theta, 0.5).direct(), pointwise];
        let [r, s] = forms.each_ref().map(|form| assembler.residual(form, &[&u], &[&space]).unwrap());
        assert!(apart(&r, &s) < 1e-14);
        let [k, l] = forms.map(|form| assembler.tangent(&form, &[&u], &[&space]).unwrap());
        assert!(apart(&k.multiply(w.values()).unwrap(), &l.multiply(w.values()).unwrap()) < 1e-13);
    }
}

/// dJ/dκ by the adjoint against differences of solutions.
#[test]
fn the_adjoint_compared_with_differences() {
    let mesh = layers(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let problem = |friction: f64| {
        let mut held = Constraints::new(&space);
        held.fix("lower bottom", |_| [0.0; 2]).unwrap();
        held.fix("upper top", |_| [0.02, -0.01]).unwrap();
        ContactProblem::new(&space, model::<2>(&pairings()[0].0, friction, 1.0, 0.5), held)
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
