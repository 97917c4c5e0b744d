//! Two nearly incompressible bodies that slide on each other: layers with known answers, tangents and adjoints, with a field for the mean
//! stress and with F-bar.

use forms_contact::ContactProblem;
use forms_contact::laws::averaged_bodies as averaged;
use forms_contact::laws::mixed_bodies::{self as laws, mixed_bodies as law};
use forms_contact::laws::mixed_nitsche::usual_gamma0;
use forms_fem::prelude::*;

use crate::rubber_block::{BULK, MU, layer_pressure};
use crate::setting::{check_tangent, close, wave};
use crate::two_bodies::{WIDTH, constraints, layers, pairings};

fn data<const D: usize>(bulk: f64, gamma0: f64, friction: f64, share: f64) -> law::Data<D> {
    law::data()
        .mu(MU)
        .bulk_modulus(bulk)
        .gamma0(gamma0)
        .friction(friction)
        .share(share)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]))
}

/// P2/P1 or Q2/P₋₁ or, in space, one pressure per hexahedron.
fn spaces<const D: usize>(mesh: &Mesh<D>, shape: CellShape) -> [Arc<Space<D>>; 2]
where
    Dim: Dimension<D>,
{
    let space = |elements, scope, parts: &[usize]| Space::of(mesh, elements, scope, parts).unwrap();
    let (degree, p) = match shape {
        CellShape::Triangle => (2, space(Elements::Lagrange(1), Scope::Nodes, &[])),
        CellShape::Quadrilateral => (2, space(Elements::LinearInSpace, Scope::Cell, &[])),
        _ => (1, space(Elements::Lagrange(0), Scope::Cell, &[])),
    };
    [space(Elements::Lagrange(degree), Scope::Nodes, &[D]), p]
}

fn model<const D: usize>(data: law::Data<D>, pairing: &Pairing) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().touch(pairing.clone()).gamma_n("upper top") }
}

fn check_tangents<const D: usize>(shape: CellShape)
where
    Dim: Dimension<D>,
{
    let mesh = layers::<D>(shape, [2, 3], 0.0);
    let [us, ps] = spaces(&mesh, shape);
    let (u, v) = (wave(&us, 0.01, 0.4), wave(&us, 0.01, 2.3));
    let scalar = |size: f64, phase: f64| {
        Field::interpolate(&ps, |x: &[f64; D]| size * (2.0 * x[0] - x[D - 1] + phase).sin()).unwrap()
    };
    let (p, q, j, r) = (scalar(20.0, 0.3), scalar(20.0, 1.7), scalar(0.05, 0.9), scalar(0.05, 2.1));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let (pairing, share) = &pairings()[0];
    let law = model(data(BULK, usual_gamma0(MU), 0.4, *share), pairing);
    check_tangent(&format!("{shape:?} u, p"), &assembler, &law.direct(), &[&u, &p], &[&v, &q]);
    let three = law.three_fields();
    check_tangent(&format!("{shape:?} u, p, j"), &assembler, &three, &[&u, &p, &j], &[&v, &q, &r]);
    if shape != CellShape::Triangle {
        let space = Space::vector(&mesh, 1).unwrap();
        let (u, v) = (wave(&space, 0.01, 0.4), wave(&space, 0.01, 2.3));
        let regions = averaged::Regions::default().touch(pairing.clone()).gamma_n("upper top");
        let law = averaged::Model { data: law.data.clone(), regions };
        check_tangent(&format!("{shape:?} F-bar"), &assembler, &law.direct(), &[&u], &[&v]);
    }
}

#[test]
fn tangents_are_exact() {
    check_tangents::<2>(CellShape::Triangle);
    check_tangents::<2>(CellShape::Quadrilateral);
    check_tangents::<3>(CellShape::Hexahedron);
}

/// F = [[1, k], [0, J]] in both bodies, sticking: the pressure whatever k is, by each surface and by both.
#[test]
fn layers_stick_with_known_stresses() {
    let (stretch, shear, bulk) = (0.95_f64, 0.1_f64, 100.0 * MU);
    let exact = |x: &[f64; 2]| [shear * x[1], (stretch - 1.0) * x[1]];
    // P₁₁ with tr C = 1 + k² + J² + 1 and P₀₁ = μ J^(−2/3) k.
    let scale = MU * stretch.powf(-2.0 / 3.0);
    let trace = 2.0 + shear * shear + stretch * stretch;
    let pressure = -(scale * (stretch - trace / (3.0 * stretch)) + bulk * (stretch - 1.0));
    let sideways = scale * shear;
    assert!((layer_pressure(bulk, stretch) / pressure - 1.0).abs() < 0.01);
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        let mesh = layers::<2>(shape, [3, 3], 0.0);
        let [us, ps] = spaces(&mesh, shape);
        for (pairing, share) in pairings() {
            let held = constraints(&us, shear, 1.0 - stretch);
            let start = Field::interpolate(&us, exact).unwrap();
            let level = Field::interpolate(&ps, |_| 0.9 * bulk * (stretch - 1.0)).unwrap();
            let law = model(data(bulk, usual_gamma0(MU), 0.3, share), &pairing);
            let solved = laws::mixed_problem(&law, [&us, &ps])
                .unwrap()
                .quadrature(Quadrature::Degree(4))
                .constrained(&held)
                .start([&start, &level])
                .solve()
                .unwrap();
            let reaction = solved.reaction_of(0, "upper top").unwrap();
            close(&format!("{shape:?} {pairing}: pressure"), -reaction[1] / WIDTH, pressure, 1e-9);
            close(&format!("{shape:?} {pairing}: shear"), reaction[0] / WIDTH, sideways, 1e-8);
        }
    }
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 3], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    for (pairing, share) in pairings() {
        let regions = averaged::Regions::default().touch(pairing.clone()).gamma_n("upper top");
        let gamma0 = forms_contact::threshold::usual_gamma0(bulk, MU);
        let law = averaged::Model { data: data(bulk, gamma0, 0.3, share), regions };
        let start = Field::interpolate(&space, exact).unwrap();
        let held = constraints(&space, shear, 1.0 - stretch);
        let problem = ContactProblem::new(&space, law, held).quadrature(Quadrature::Degree(4));
        let reaction =
            problem.direct().unwrap().start(&start).solve().unwrap().reaction("upper top").unwrap();
        close(&format!("F-bar {pairing}: pressure"), -reaction[1] / WIDTH, pressure, 1e-9);
        close(&format!("F-bar {pairing}: shear"), reaction[0] / WIDTH, sideways, 1e-8);
    }
}

/// dJ/dκ where the layers slip.
#[test]
fn adjoint_gradients_are_those_of_differences() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let [us, ps] = spaces(&mesh, CellShape::Quadrilateral);
    let held = constraints(&us, 0.06, 0.02);
    let (pairing, share) = &pairings()[0];
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let options = NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    let start = Field::interpolate(&us, |x| [0.06 * x[1], -0.02 * x[1]]).unwrap();
    let solve = |friction: f64| {
        let law = model(data(BULK, usual_gamma0(MU), friction, *share), pairing);
        let problem = laws::mixed_problem(&law, [&us, &ps]).unwrap().assembler(&assembler);
        let solved = problem
            .constrained(&held)
            .options(options.clone())
            .start([&start, &Field::zero(&ps)])
            .solve()
            .unwrap();
        (law, solved.fields)
    };
    let (law, [u, p]) = solve(0.2);
    let adjoint = law.discrete_adjoint(&u, &p);
    let solved = Problem::new(&adjoint, [&us, &ps]).assembler(&assembler).homogeneous(&held).solve().unwrap();
    let [z, s] = solved.fields;
    let gradient = assembler.functional(&law.by_friction(&u, &p, &z, &s)).unwrap();
    let value = |friction: f64| {
        let (law, [u, _]) = solve(friction);
        assembler.functional(&law.criterion(&u)).unwrap()
    };
    let step = 1e-4;
    let difference = (value(0.2 + step) - value(0.2 - step)) / (2.0 * step);
    close("dJ/dκ", gradient, difference, 1e-7);
}
