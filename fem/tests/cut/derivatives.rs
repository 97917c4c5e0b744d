//! Derivatives by level set functions on quadrilaterals and hexahedra, compared with differences, and their Taylor tests: volumes, areas, a functional of the
//! interface with clipped facets, and the compliance of an elastic body.

use std::convert::Infallible;

use forms_fem::prelude::*;
use forms_fem::verification::{Sample, taylor};

use crate::levels;

#[forms(level_set_derivatives)]
mod hanging {
    pub struct Data {
        pub load: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Outer;
    #[interface]
    pub struct Gamma;
    #[interior_facets]
    pub struct Ghost;

    pub fn volume(t: Test<Scalar>) -> Form {
        integral(Omega, t)
    }
    pub fn area(t: Test<Scalar>) -> Form {
        integral(Gamma, t)
    }
    /// With facets that the interface crosses.
    pub fn on_boundary(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Gamma, (sqr(dot(grad(u) * n, n)) + u[0] * x[1]) * t) + integral(Outer, dot(u, n) * x[0] * t)
    }
    fn stress(w: Vector) -> Tensor {
        2 * eps(w) + div(w) * I
    }
    /// Equilibrium under the load, with a ghost penalty.
    pub fn equilibrium(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(load, v))
            + integral(Ghost, 0.3 * avg(h) * dot(jump(grad(u)) * n, jump(grad(v)) * n))
    }
    /// The work of the load.
    pub fn compliance(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, dot(load, u) * t)
    }
}

/// Compares the derivative of a number along a direction with a difference, and the order of its remainders with two. No node changes sides.
fn compare<const D: usize>(
    name: &str,
    [phi, direction]: [&Field<D>; 2],
    gradient: &[f64],
    value: impl Fn(&Assembler<D>) -> f64,
) {
    let slope: f64 = gradient.iter().zip(direction.values()).map(|(slope, w)| slope * w).sum();
    let moved = |step: f64| {
        let values = phi.values().iter().zip(direction.values()).map(|(phi, w)| phi + step * w);
        let moved = Field::from_values(phi.space(), values.collect()).unwrap();
        Assembler::new(phi.space().mesh()).cut_by(&moved).unwrap()
    };
    let central = |step: f64| (value(&moved(step)) - value(&moved(-step))) / (2.0 * step);
    let difference = (4.0 * central(1e-4) - central(2e-4)) / 3.0;
    let miss = (slope / difference - 1.0).abs();
    println!("{name}: {slope:.10} difference {difference:.10}, apart {miss:.1e}");
    assert!(miss < 1e-8, "{name}: {slope} is not {difference}");
    let report = taylor(1e-3, &[slope], |step| -> Result<Sample, Infallible> {
        let body = moved(step);
        let sides = body.cut().unwrap().sides().collect();
        Ok(Sample { value: vec![value(&body)], active_set: Some(sides) })
    });
    let report = report.unwrap();
    println!("{report}");
    let order = report.second_order().unwrap();
    assert!((order - 2.0).abs() < 0.05, "{name}: order {order}");
}

/// Orders for the half of an ellipsoid that hangs at the top of a square or cube.
fn check<const D: usize>(mesh: &Mesh<D>, degree: usize)
where
    Dim: Dimension<D>,
{
    let phi = levels(mesh, degree, |x| {
        let across: f64 =
            x[..D - 1].iter().zip([0.031, -0.017]).map(|(x, centre)| (x - centre).powi(2)).sum();
        across + 0.25 * (x[D - 1] - 1.0).powi(2) - 0.547
    });
    let direction = levels(mesh, degree, |x| 1.0 + (2.0 * x[0]).sin() * x[1] + x[D - 1]);
    let load: [f64; D] = std::array::from_fn(|k| [0.3, -1.0, 0.4][k]);
    let regions = hanging::Regions::default().ghost("ghost").outer("boundary");
    let model = hanging::Model { data: hanging::data().load(load), regions };
    let body = Assembler::new(mesh).cut_by(&phi).unwrap();
    let one = Field::interpolate(&Space::discontinuous_scalar(mesh, 0).unwrap(), |_| 1.0).unwrap();
    let space = Space::vector(mesh, 1).unwrap();
    let place =
        |x: &[f64; D]| -> [f64; D] { std::array::from_fn(|k| x[k] * x[D - 1] + [0.2, 0.4, -0.1][k] * x[0]) };
    let u = Field::interpolate(&space, place).unwrap();
    let sum = |body: &Assembler<D>, form: &Form<D>| -> f64 {
        body.linear_form(form, one.space()).unwrap().iter().sum()
    };
    for form in [model.volume(), model.area(), model.on_boundary(&u)] {
        let gradient = body.derivative_by_level_set(&form, &[], &[&one]).unwrap();
        compare(form.name(), [&phi, &direction], &gradient, |body| sum(body, &form));
    }
    let equilibrium = model.equilibrium();
    let solve = |body: &Assembler<D>| -> Field<D> {
        let mut held = Constraints::new(&space);
        held.fix("top", |_| [0.0; D]).unwrap();
        body.cut().unwrap().hold_outside(&mut held).unwrap();
        let mut problem = Problem::new(&equilibrium, &space).assembler(body).constrained(&held);
        problem.solve().unwrap().into_field()
    };
    // The adjoint state of the compliance is −u.
    let u = solve(&body);
    let p = Field::from_values(&space, u.values().iter().map(|value| -value).collect()).unwrap();
    let mut gradient = body.derivative_by_level_set(&model.compliance(&u), &[], &[&one]).unwrap();
    let of_state = body.derivative_by_level_set(&equilibrium, &[&u], &[&p]).unwrap();
    gradient.iter_mut().zip(of_state).for_each(|(sum, part)| *sum += part);
    compare("compliance", [&phi, &direction], &gradient, |body| sum(body, &model.compliance(solve(body))));
}

#[test]
fn remainders_by_the_level_set_function_are_of_second_order() {
    check(&rectangle([-1.0; 2], [1.0; 2], [7; 2], CellShape::Quadrilateral, 1).unwrap(), 2);
    for degree in [1, 2] {
        check(&cuboid([-1.0; 3], [1.0; 3], [4; 3], CellShape::Hexahedron, 1).unwrap(), degree);
    }
}
