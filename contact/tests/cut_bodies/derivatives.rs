//! Derivatives by the level set function, compared with differences of what is assembled.

use std::convert::Infallible;

use forms_contact::laws::cut_nitsche;
use forms_fem::cut::Cut;
use forms_fem::prelude::*;
use forms_fem::verification::{Sample, taylor};

use crate::{level, square};

#[forms(level_set_derivatives)]
mod measures {
    pub struct Data {
        pub weight: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Outer;
    #[interface]
    pub struct Gamma;

    pub fn volume(t: Test<Scalar>) -> Form {
        integral(Omega, t)
    }
    pub fn length(t: Test<Scalar>) -> Form {
        integral(Gamma, t)
    }
    /// With a field, its normal derivative, a function of position and a kink.
    pub fn on_interface(u: State<Scalar>, t: Test<Scalar>) -> Form {
        integral(Gamma, (sqr(dot(grad(u), n)) + u * x[1] * weight + pos_part(u - weight) * h) * t)
    }
    pub fn inside(u: State<Scalar>, t: Test<Scalar>) -> Form {
        integral(Omega, (dot(grad(u), grad(u)) + u * weight * x[0] + sqr(neg_part(u))) * t)
    }
    pub fn on_facets(u: State<Scalar>, t: Test<Scalar>) -> Form {
        integral(Outer, (sqr(u) * weight + dot(grad(u), n)) * t)
    }
}

/// The extrapolated central difference of a function at zero.
fn difference(f: impl Fn(f64) -> f64, step: f64) -> f64 {
    let central = |step: f64| (f(step) - f(-step)) / (2.0 * step);
    (4.0 * central(step) - central(2.0 * step)) / 3.0
}

fn moved<const D: usize>(phi: &Field<D>, direction: &Field<D>, step: f64) -> Field<D> {
    let values = phi.values().iter().zip(direction.values()).map(|(phi, w)| phi + step * w);
    Field::from_values(phi.space(), values.collect()).unwrap()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Each form's derivative along a direction and its difference.
fn check<const D: usize>(mesh: &Mesh<D>, phi: &Field<D>, direction: &Field<D>, forms: &[Form<D>], step: f64) {
    let one = Field::interpolate(&Space::discontinuous_scalar(mesh, 0).unwrap(), |_| 1.0).unwrap();
    for form in forms {
        let value = |step: f64| -> f64 {
            let body = Assembler::new(mesh).cut_by(&moved(phi, direction, step)).unwrap();
            body.linear_form(form, one.space()).unwrap().iter().sum()
        };
        let body = Assembler::new(mesh).cut_by(phi).unwrap();
        let gradient = body.derivative_by_level_set(form, &[], &[&one]).unwrap();
        let (found, expected) = (dot(&gradient, direction.values()), difference(value, step));
        let miss = (found - expected).abs() / expected.abs();
        println!("{}: {found:.12} difference {expected:.12}, apart {miss:.1e}", form.name());
        assert!(expected.abs() > 1e-3 && miss < 1e-8, "{}: {found} is not {expected}", form.name());
        let report = taylor(1e-2, &[found], |step| -> Result<Sample, Infallible> {
            let sides = Cut::by(&moved(phi, direction, step)).unwrap().sides().collect();
            Ok(Sample { value: vec![value(step)], active_set: Some(sides) })
        });
        let order = report.unwrap().second_order().unwrap();
        assert!((order - 2.0).abs() < 0.05, "{}: order {order}", form.name());
        // The same on other numbers of threads, to the last bit.
        let three = body.with_threads(Threads::new(3));
        assert_eq!(three.derivative_by_level_set(form, &[], &[&one]).unwrap(), gradient);
    }
}

#[test]
fn measures_and_functionals_have_exact_derivatives() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([-1.0; 2], [1.0; 2], [9, 9], shape, 1).unwrap();
        // Clipped by the square's sides.
        let phi = level(&mesh, |x| (x[0] - 0.43).hypot(x[1] + 0.371) - 0.713);
        let direction = level(&mesh, |x| 1.0 + (2.0 * x[0]).sin() * x[1]);
        let u = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), |x| x[0] * x[1] + 0.4 * x[0] - 0.1)
            .unwrap();
        let weight = Given::function_with_gradient(|x: &[f64; 2]| 0.3 + x[0] * x[1], |x| [x[1], x[0]]);
        let model = measures::Model::new(measures::data().weight(weight));
        let model = measures::Model { regions: model.regions.outer("boundary"), ..model };
        let forms =
            [model.volume(), model.length(), model.on_interface(&u), model.inside(&u), model.on_facets(&u)];
        check(&mesh, &phi, &direction, &forms, 1e-4);
    }
    let mesh = cuboid([-1.0; 3], [1.0; 3], [3; 3], CellShape::Tetrahedron, 1).unwrap();
    let phi = level(&mesh, |x| ((x[0] - 0.43).powi(2) + (x[1] + 0.371).powi(2) + x[2] * x[2]).sqrt() - 0.81);
    let direction = level(&mesh, |x| 1.0 + (2.0 * x[0]).sin() * x[1] + x[2]);
    let u =
        Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), |x| x[0] * x[1] + 0.4 * x[2] - 0.1).unwrap();
    let weight = Given::function_with_gradient(|x: &[f64; 3]| 0.3 + x[0] * x[1], |x| [x[1], x[0], 0.0]);
    let model = measures::Model::new(measures::data().weight(weight));
    let model = measures::Model { regions: model.regions.outer("boundary"), ..model };
    let forms =
        [model.volume(), model.length(), model.on_interface(&u), model.inside(&u), model.on_facets(&u)];
    check(&mesh, &phi, &direction, &forms, 1e-4);
}

/// Cells that are cut along heights, with clipped facets.
#[test]
fn curved_parts_have_exact_derivatives() {
    fn on<const D: usize>(mesh: &Mesh<D>, degree: usize, radius: f64, weight: Given<f64, D>)
    where
        Dim: Dimension<D>,
    {
        let levels = Space::scalar(mesh, degree).unwrap();
        let place =
            |x: &[f64; D]| -> f64 { x.iter().zip([0.43, -0.371, 0.07]).map(|(x, c)| (x - c).powi(2)).sum() };
        let phi = Field::interpolate(&levels, |x| place(x) - radius * radius).unwrap();
        let direction = Field::interpolate(&levels, |x| 1.0 + (2.0 * x[0]).sin() * x[1] + x[D - 1]).unwrap();
        let u = Field::interpolate(&Space::scalar(mesh, 2).unwrap(), |x| x[0] * x[1] + 0.4 * x[D - 1] - 0.1)
            .unwrap();
        let model = measures::Model::new(measures::data().weight(weight));
        let model = measures::Model { regions: model.regions.outer("boundary"), ..model };
        let forms =
            [model.volume(), model.length(), model.on_interface(&u), model.inside(&u), model.on_facets(&u)];
        // The same lines are cut at all places of the difference.
        let sides = |step: f64| -> Vec<u32> {
            let body = Assembler::new(mesh).cut_by(&moved(&phi, &direction, step)).unwrap();
            body.cut().unwrap().sides().collect()
        };
        let step = 4e-6;
        for factor in [-2.0, -1.0, 1.0, 2.0] {
            assert!(sides(factor * step) == sides(0.0), "points change");
        }
        check(mesh, &phi, &direction, &forms, step);
    }
    let square = rectangle([-1.0; 2], [1.0; 2], [9, 9], CellShape::Quadrilateral, 1).unwrap();
    let weight = Given::function_with_gradient(|x: &[f64; 2]| 0.3 + x[0] * x[1], |x| [x[1], x[0]]);
    on(&square, 2, 0.713, weight);
    let cube = cuboid([-1.0; 3], [1.0; 3], [3; 3], CellShape::Hexahedron, 1).unwrap();
    for degree in [1, 2] {
        let weight = Given::function_with_gradient(|x: &[f64; 3]| 0.3 + x[0] * x[1], |x| [x[1], x[0], 0.0]);
        on(&cube, degree, 0.81, weight);
    }
}

#[test]
fn data_without_gradients_are_refused() {
    let mesh = square(6);
    let body = Assembler::new(&mesh).cut_by(&level(&mesh, |x| x[0].hypot(x[1]) - 0.71)).unwrap();
    let model = measures::Model::new(measures::data().weight(|x: &[f64; 2]| x[0]));
    let one = Field::interpolate(&Space::discontinuous_scalar(&mesh, 0).unwrap(), |_| 1.0).unwrap();
    let u = Field::zero(one.space());
    let error = body.derivative_by_level_set(&model.inside(&u), &[], &[&one]).unwrap_err().to_string();
    assert!(error.contains("the derivative of `weight` in space is not known"), "{error}");
    let form = form!(|t: Test<Scalar>| integral(cells("all"), t));
    let error = body.derivative_by_level_set(&form, &[], &[&one]).unwrap_err().to_string();
    assert!(error.contains("has no kernels for derivatives by a level set function"), "{error}");
    let whole = Assembler::new(&mesh);
    assert!(whole.derivative_by_level_set(&model.volume(), &[], &[&one]).is_err());
}

/// The remedy for small cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Remedy {
    Penalty,
    Aggregates,
}

/// A body that hangs at the top of a square or cube and is pressed onto an obstacle below.
struct Pressed<const D: usize> {
    space: Arc<Space<D>>,
    law: cut_nitsche::Model<D>,
    remedy: Remedy,
}

impl<const D: usize> Pressed<D>
where
    Dim: Dimension<D>,
{
    fn new(mesh: &Mesh<D>, theta: f64, degree: usize, remedy: Remedy) -> Self {
        let space = Space::vector(mesh, degree).unwrap();
        let up: [f64; D] = std::array::from_fn(|k| if k == D - 1 { 1.0 } else { 0.0 });
        let pull: [f64; D] = up.map(|entry| 0.3 - 1.3 * entry);
        let gap = Given::function_with_gradient(|x: &[f64; D]| x[D - 1] + 0.62, move |_| up);
        let data = cut_nitsche::data()
            .lambda(1.0)
            .mu(1.0)
            .gamma0(30.0 * (degree * degree) as f64)
            .obstacle_normal(up.map(|entry| -entry))
            .gap(gap)
            .theta(theta)
            .body_force(up.map(|entry| -0.1 * entry))
            .criterion_force(pull);
        let regions = cut_nitsche::regions().gamma_c("all").gamma_d("all").gamma_n("boundary");
        Pressed { space, law: cut_nitsche::Model { data, regions }, remedy }
    }

    fn body(&self, phi: &Field<D>) -> (Assembler<D>, Constraints<D>) {
        let mut cut = Cut::by(phi).unwrap();
        if self.remedy == Remedy::Aggregates {
            cut = cut.aggregated().unwrap();
        }
        let body = Assembler::new(self.space.mesh()).with_cut(&cut).unwrap();
        let mut held = Constraints::new(&self.space);
        let pressed: [f64; D] = std::array::from_fn(|k| if k == D - 1 { -0.05 } else { 0.0 });
        held.fix("top", |_| pressed).unwrap();
        body.cut().unwrap().hold_outside(&mut held).unwrap();
        (body, held)
    }

    fn solve(&self, phi: &Field<D>) -> (f64, Field<D>, Option<Vec<u32>>) {
        let (body, held) = self.body(phi);
        let options = NewtonOptions::default();
        let problem = Problem::new(&self.law.direct(), &self.space).assembler(&body).constrained(&held);
        let u = problem.options(options).solve().unwrap().into_field();
        let criterion = body.functional(&self.law.criterion(&u)).unwrap();
        let active = body.active_set(&self.law.direct(), &[&u]).unwrap();
        (criterion, u, active)
    }

    fn gradient(&self, phi: &Field<D>, u: &Field<D>) -> Vec<f64> {
        let (body, held) = self.body(phi);
        let problem = Problem::new(&self.law.discrete_adjoint(u), &self.space).assembler(&body);
        let p = problem.homogeneous(&held).solve().unwrap().into_field();
        self.law.level_set_gradient(&body, u, &p).unwrap()
    }
}

/// J and its derivative along a direction, by a difference with a step, and the order of the remainder.
fn check_criterion<const D: usize>(
    problem: &Pressed<D>,
    (phi, direction): (&Field<D>, &Field<D>),
    (step, name): (f64, &str),
) where
    Dim: Dimension<D>,
{
    let (_, u, active) = problem.solve(phi);
    let (body, _) = problem.body(phi);
    assert!(body.functional(&problem.law.contact_force(&u)).unwrap() > 1e-3);
    let slope = dot(&problem.gradient(phi, &u), direction.values());
    let expected = difference(
        |step| {
            let (criterion, _, there) = problem.solve(&moved(phi, direction, step));
            assert!(there == active, "{name}: the active set changes");
            criterion
        },
        step,
    );
    let miss = (slope - expected).abs() / expected.abs();
    println!("{name}: {slope:.10} difference {expected:.10}, apart {miss:.1e}");
    assert!(miss < 1e-8, "{name}: {slope} is not {expected}");
    let report = taylor(1e-3, &[slope], |step| -> Result<Sample, Infallible> {
        let phi = moved(phi, direction, step);
        let (value, _, active) = problem.solve(&phi);
        let mut switches = active.unwrap_or_default();
        let body = problem.body(&phi).0;
        let cut = body.cut().unwrap();
        let mut ghost = cut.ghost_facets().to_vec();
        ghost.sort_unstable();
        switches.extend(ghost.iter().flatten().flat_map(|facet| [facet.cell, u32::from(facet.local)]));
        switches.extend(cut.sides());
        Ok(Sample { value: vec![value], active_set: Some(switches) })
    });
    let order = report.unwrap().second_order().unwrap();
    assert!((order - 2.0).abs() < 0.05, "{name}: order {order}");
}

#[test]
fn contact_criterion_has_an_exact_derivative() {
    let (penalty, aggregates) = (Remedy::Penalty, Remedy::Aggregates);
    let (triangles, quadrilaterals) = (CellShape::Triangle, CellShape::Quadrilateral);
    for (cells, theta, degree, remedy, curved) in [
        (triangles, -1.0, 1, penalty, 1),
        (triangles, 1.0, 1, penalty, 1),
        (triangles, 0.0, 2, penalty, 1),
        (triangles, 1.0, 1, aggregates, 1),
        (triangles, -1.0, 2, aggregates, 1),
        (quadrilaterals, -1.0, 1, penalty, 1),
        (quadrilaterals, 0.0, 1, penalty, 2),
        (quadrilaterals, 1.0, 2, penalty, 2),
        (quadrilaterals, -1.0, 2, aggregates, 2),
    ] {
        let mesh = rectangle([-1.0; 2], [1.0; 2], [10; 2], cells, 1).unwrap();
        // A body below the top side whose lower end is round and presses.
        let shape = |x: &[f64; 2]| {
            let below = -0.613 + 0.3 * x[0] * x[0] - x[1];
            below.max(x[0].abs() - 0.747)
        };
        let levels = Space::scalar(&mesh, curved).unwrap();
        let phi = Field::interpolate(&levels, shape).unwrap();
        let direction = Field::interpolate(&levels, |x| 0.5 + 0.4 * (2.0 * x[0] + x[1]).sin()).unwrap();
        let problem = Pressed::new(&mesh, theta, degree, remedy);
        let name = format!("{cells:?}, θ = {theta} P{degree} {remedy:?}, φ of degree {curved}");
        check_criterion(&problem, (&phi, &direction), (2e-5, &name));
    }
}

#[test]
fn contact_criterion_has_an_exact_derivative_in_space() {
    let (penalty, aggregates) = (Remedy::Penalty, Remedy::Aggregates);
    let (tetrahedra, hexahedra) = (CellShape::Tetrahedron, CellShape::Hexahedron);
    for (cells, theta, remedy, curved) in [
        (tetrahedra, 1.0, penalty, 1),
        (hexahedra, -1.0, penalty, 1),
        (hexahedra, 1.0, aggregates, 1),
        (hexahedra, 0.0, penalty, 2),
    ] {
        let mesh = cuboid([-1.0; 3], [1.0; 3], [4; 3], cells, 1).unwrap();
        // The lower end is round; the sides are those of the cube.
        let levels = Space::scalar(&mesh, curved).unwrap();
        let phi = Field::interpolate(&levels, |x| {
            -0.613 + 0.3 * ((x[0] - 0.031).powi(2) + (x[1] + 0.017).powi(2)) - x[2]
        });
        let direction = Field::interpolate(&levels, |x| 0.5 + 0.4 * (2.0 * x[0] + x[1]).sin());
        let problem = Pressed::new(&mesh, theta, 1, remedy);
        let name = format!("{cells:?}, θ = {theta} {remedy:?}, φ of degree {curved}");
        check_criterion(&problem, (&phi.unwrap(), &direction.unwrap()), (2e-6, &name));
    }
}
