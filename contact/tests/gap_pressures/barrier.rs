//! The log barrier on a flat.

use forms_contact::ContactProblem;
use forms_contact::laws::barrier_obstacle::{barrier_obstacle as law, barrier_problem, stiffness};
use forms_contact::laws::frictional_nitsche as nitsche;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::layer::{GAP, LAMBDA, MODULUS, MU, balanced, below, held, plane, solid, wave};

fn model<const D: usize>(reach: f64, stiffness: f64) -> law::Model<D> {
    let data = law::data().lambda(LAMBDA).mu(MU).barrier_stiffness(stiffness).activation_gap(reach);
    let data = data.obstacle_normal(below()).gap(GAP);
    let weight = |x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]);
    law::Model {
        data: data.criterion_force(weight),
        regions: law::Regions::default().gamma_c("bottom").gamma_n("top"),
    }
}

/// −κ b′(g).
fn pressure(g: f64, reach: f64, stiffness: f64) -> f64 {
    if g >= reach {
        return 0.0;
    }
    stiffness * (2.0 * (g - reach) * (g / reach).ln() + (g - reach).powi(2) / g)
}

/// ipctk 1.6.1 has 7.797905781e-9 in squared lengths at half of ĝ = 0.01.
#[test]
fn the_barrier_is_that_of_incremental_potential_contact() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let data = law::data().lambda(1.0).mu(1.0).barrier_stiffness(1.0).activation_gap(1e-4);
    let regions = law::Regions::default().gamma_c("bottom").gamma_n("top");
    let law = law::Model { data: data.obstacle_normal([0.0, -1.0]).gap(2.5e-5), regions };
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2));
    let energy = assembler.functional(&law.stored(Field::zero(&space))).unwrap();
    assert!((energy / 7.797905781e-9 - 1.0).abs() < 1e-9, "{energy:e}");
    assert!((pressure(0.5, 1.0, stiffness(3.0, 1.0)) - 3.0).abs() < 1e-14);
}

fn layer<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 2).unwrap();
    let mut errors = vec![];
    for reach in [0.02, 0.01, 0.005] {
        let way = 0.08;
        let kappa = stiffness(MODULUS * (way - GAP), reach);
        let model = model::<D>(reach, kappa);
        let held = held(&space, way);
        let solved = barrier_problem(&model, &space).unwrap().constrained(&held).solve().unwrap();
        let gap = balanced(way, |g| pressure(g, reach, kappa));
        let found = solved.field().evaluate(&[0.4; D]).unwrap()[D - 1];
        // Linear between bottom and top.
        let bottom = gap - GAP;
        let expected = bottom + 0.4 * (-way - bottom);
        assert!((found - expected).abs() < 1e-11, "{D}D, {reach}: {found}, {expected}");
        errors.push(gap);
    }
    // The error of the place of the surface is of order ĝ.
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 1.0).abs() < 0.1, "{order}");
    }
}

#[test]
fn a_layer_has_the_gap_of_its_pressure() {
    layer(&plane());
    layer(&solid());
}

/// The top passes beyond the flat in the first step: whole steps would have gaps that are not positive.
#[test]
fn no_point_passes_through_the_flat() {
    let mesh = plane();
    let space = Space::vector(&mesh, 2).unwrap();
    let model = model::<2>(0.01, 1e3);
    let mut tilted = Constraints::new(&space);
    tilted.fix("top", |x| [0.05 * x[0], -0.3 + 0.2 * x[0]]).unwrap();
    let mut problem = barrier_problem(&model, &space).unwrap().constrained(&tilted);
    let solved = problem.solve().unwrap();
    assert!(solved.history.iter().any(|step| step.damping.is_some_and(|part| part < 1.0)));
    let gaps = solved.assembler().at_quadrature_points(
        &model.guarded_gap(solved.field()),
        Entity::Facets,
        "bottom",
        6,
    );
    let least = gaps.unwrap().values.iter().map(|gap| gap[0]).fold(f64::INFINITY, f64::min);
    assert!(least > 0.0, "{least}");
    // A start behind the flat is refused with the place.
    let behind = Field::interpolate(&space, |_| [0.0, -0.06]).unwrap();
    let error =
        barrier_problem(&model, &space).unwrap().constrained(&held(&space, 0.06)).start(&behind).solve();
    let error = error.unwrap_err().to_string();
    assert!(error.contains("the start itself is not feasible") && error.contains(", 0.0]"), "{error}");
}

fn derivatives<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1).unwrap();
    let model = model::<D>(0.06, 30.0);
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
    let (u, direction) = (wave(&space, 0.02, 0.3), wave(&space, 0.02, 1.1));
    let form = model.direct();
    let report = verification::tangent(&assembler, &form, &[&u], &[&direction], 0.05).unwrap();
    assert!(report.second_order().unwrap() > 1.95, "{report}");
    let matrix = assembler.tangent(&form, &[&u], &[&space]).unwrap();
    let (a, b) = (wave(&space, 1.0, 0.0), wave(&space, 1.0, 2.0));
    let product = |x: &Field<D>, y: &Field<D>| -> f64 {
        matrix.multiply(x.values()).unwrap().iter().zip(y.values()).map(|(kx, y)| kx * y).sum()
    };
    assert!((product(&a, &b) - product(&b, &a)).abs() < 1e-11 * product(&a, &a).abs());
    // The residual is the slope of the energy.
    let along = |t: f64| {
        let moved = Field::combination(&[(1.0, &u), (t, &direction)]).unwrap();
        assembler.functional(&model.stored(&moved)).unwrap()
    };
    let slope = (along(1e-4) - along(-1e-4)) / 2e-4;
    let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
    let found: f64 = residual.iter().zip(direction.values()).map(|(r, d)| r * d).sum();
    assert!((found - slope).abs() < 1e-6 * slope.abs(), "{found} {slope}");
}

#[test]
fn tangents_are_derivatives_of_the_energy() {
    derivatives(&plane());
    derivatives(&solid());
}

/// The criterion of a tilted block on the flat, solved on a mesh with a shear modulus.
fn solved(mesh: &Mesh<2>, mu: f64) -> (law::Model<2>, Assembler<2>, Constraints<2>, Field<2>, f64) {
    let space = Space::vector(mesh, 1).unwrap();
    let mut model = model::<2>(0.03, 200.0);
    model.data.mu = mu;
    model.data.criterion_force = Given::function_with_gradient(
        |x: &[f64; 2]| [0.3 + x[0] - 0.5 * x[0] * x[1], 0.2 * x[1]],
        |x: &[f64; 2]| [[1.0 - 0.5 * x[1], -0.5 * x[0]], [0.0, 0.2]],
    );
    // The flat stays where it is as the shape changes: the gap is y + GAP.
    model.data.gap = Given::function_with_gradient(|x: &[f64; 2]| x[1] + GAP, |_| [0.0, 1.0]);
    let mut held = Constraints::new(&space);
    held.fix("top", |_| [0.01, -0.1]).unwrap();
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
    let u = {
        let problem = barrier_problem(&model, &space).unwrap();
        problem.assembler(&assembler).constrained(&held).solve().unwrap().into_field()
    };
    let value = assembler.functional(&model.criterion(&u)).unwrap();
    (model, assembler, held, u, value)
}

#[test]
fn gradients_are_those_of_differences() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [6, 3], CellShape::Triangle, 1).unwrap();
    let (model, assembler, held, u, _) = solved(&mesh, MU);
    let adjoint = Problem::new(&model.discrete_adjoint(&u), u.space());
    let p = adjoint.homogeneous(&held).assembler(&assembler).solve().unwrap().into_field();
    let found = assembler.functional(&model.by_mu(&u, &p)).unwrap();
    let step = 1e-4;
    let difference = (solved(&mesh, MU + step).4 - solved(&mesh, MU - step).4) / (2.0 * step);
    assert!((found - difference).abs() < 1e-7 * difference.abs(), "{found} {difference}");

    let movements = Space::of_geometry(&mesh).unwrap();
    let along = Field::interpolate(&movements, |x| {
        [(1.0 - x[1]) * (0.7 * x[0]).cos(), (1.0 - x[1]) * ((x[0] + x[1]).sin() - 0.4)]
    })
    .unwrap();
    let gradient = assembler.linear_form(&model.shape_gradient(&u, &p), &movements).unwrap();
    let found: f64 = gradient.iter().zip(along.values()).map(|(g, t)| g * t).sum();
    let step = 1e-5;
    let moved = |step: f64| solved(&along.move_mesh(step).unwrap(), MU).4;
    let difference = (moved(step) - moved(-step)) / (2.0 * step);
    assert!((found - difference).abs() < 1e-7 * difference.abs(), "{found} {difference}");
}

/// A block that is pressed unevenly comes to the solution of Nitsche's method as ĝ falls.
#[test]
fn the_error_is_of_the_order_of_the_activation_gap() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [12, 6], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("top", |x| [0.0, -0.1 + 0.04 * x[0]]).unwrap();
    let base = forms_contact::forms::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(10.0 * MODULUS)
        .obstacle_normal([0.0, -1.0]);
    let data = nitsche::data_from(base.gap(GAP).theta(0.0));
    let regions = nitsche::Regions::default().gamma_c("bottom").gamma_n("right");
    let reference = ContactProblem::new(&space, nitsche::Model { data, regions }, held.clone());
    let exact = reference.direct().unwrap().solve().unwrap().into_field();
    let assembler = Assembler::new(&mesh);
    let (mut errors, mut u) = (vec![], Field::zero(&space));
    for reach in [0.02, 0.01, 0.005] {
        let model = model::<2>(reach, stiffness(0.1, reach));
        let solved = barrier_problem(&model, &space).unwrap().constrained(&held).start(&u).solve().unwrap();
        u = solved.into_field();
        errors.push(norms::l2_norm(&assembler, &u.minus(&exact).unwrap()).unwrap());
    }
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((0.8..1.3).contains(&order), "{order} {errors:?}");
    }
}
