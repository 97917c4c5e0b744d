//! A shallow arch that snaps through onto a soft floor: contact begins between two smooth limit points.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::solve::{EventKind, Inertia};

use crate::limit_points::Outcome;

#[forms(dimension = 2)]
mod arch {
    pub struct Data {
        pub load: Param,
        pub distribution: Given<Scalar>,
        pub bed: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;
    #[facets]
    pub struct Bottom;

    fn density(u: Vector) -> Scalar {
        let E = (grad(u) + transpose(grad(u)) + transpose(grad(u)) * grad(u)) / 2;
        1.5 * sqr(tr(E)) + inner(E, E)
    }
    /// Below the line between the supports, in the middle half.
    fn sinking(u: Vector) -> Scalar {
        neg_part(x[1] + u[1] + 40 * pos_part(sqr(x[0]) - 0.25))
    }
    pub fn potential(u: Unknown<Vector>) -> Energy {
        integral(Omega, density(u))
            + integral(Bottom, bed * sqr(sinking(u)) / 2)
            + integral(Top, load * distribution * u[1])
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(potential(u), u, v)
    }
    pub fn by_load(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), load, 1)
    }
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, density(u)) + integral(Bottom, bed * sqr(sinking(u)) / 2)
    }
    pub fn floor_force(u: State<Vector>) -> Functional {
        integral(Bottom, bed * sinking(u))
    }
    pub fn deflection(u: State<Vector>) -> Functional {
        integral(Top, -distribution * u[1])
    }
}

const SPAN: f64 = 1.0;
const RISE: f64 = 0.25;
const THICKNESS: f64 = 0.06;

fn model(load: f64, bed: f64) -> arch::Model<2> {
    let distribution = |x: &[f64; 2]| match x[0].abs() < 0.6 {
        true => (1.0 + (PI * x[0] / 0.6).cos()) / 1.2,
        false => 0.0,
    };
    let data = arch::data().load(load).distribution(distribution).bed(bed);
    arch::Model { data, regions: arch::Regions::default().top("top").bottom("bottom") }
}

/// [deflection, force of the floor, stored energy].
type Measured = [f64; 3];

#[test]
fn contact_begins_between_two_limit_points() -> Outcome {
    let radius = (SPAN * SPAN + RISE * RISE) / (2.0 * RISE);
    let half_angle = (SPAN / radius).asin();
    let mesh = structured([20, 1], CellShape::Quadrilateral, 2, |[s, t]| {
        let (angle, r) = ((2.0 * s - 1.0) * half_angle, radius + (t - 0.5) * THICKNESS);
        [r * angle.sin(), r * angle.cos() - (radius - RISE)]
    })?;
    let space = Space::vector(&mesh, 2)?;
    let mut clamps = Constraints::new(&space);
    clamps.fix("left", |_| [0.0; 2])?;
    clamps.fix("right", |_| [0.0; 2])?;
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
    let mut second_limits = vec![];
    for bed in [0.0, 0.003] {
        let forms = move |load: f64| [model(load, bed).balance(), model(load, bed).by_load()];
        let measure = |u: &Field<2>| -> Result<Measured, AssemblyError> {
            let model = model(0.0, bed);
            let of = |functional: &Functional<2>| assembler.functional(functional);
            Ok([of(&model.deflection(u))?, of(&model.floor_force(u))?, of(&model.stored(u))?])
        };
        let branch = Continuation::new(&space, forms)
            .constrained(&clamps)
            .assembler(&assembler)
            .step(1e-4)
            .between_steps(1.0 / 1024.0, 2.0)
            .points(120)
            .within(0.0..=8e-4)
            .run(|_, solved| Ok(measure(solved.field())?))?;
        let limits: Vec<_> =
            branch.events.iter().filter(|event| matches!(event.kind, EventKind::LimitPoint)).collect();
        for event in &branch.events {
            println!("{bed}: {:?} at {} ± {:.0e}", event.kind, event.parameter, event.uncertainty);
        }
        let [first, second] = limits[..] else { return Err("not two limit points".into()) };
        assert!(first.uncertainty < 1e-9 && second.uncertainty < 1e-9);
        let touches = |point: usize| branch.points[point].measured[1] > 0.0;
        assert!(!touches(first.after + 1), "contact at the first limit point");
        assert_eq!(touches(second.after), bed > 0.0);
        // Loads are stable before the first and after the second limit point, work is stored.
        let stable = |point: usize| branch.points[point].inertia == Inertia::NegativeEigenvalues(0);
        assert!(stable(1) && stable(branch.points.len() - 1) && !stable(second.after));
        let work: f64 = branch
            .points
            .windows(2)
            .map(|p| 0.5 * (p[0].parameter + p[1].parameter) * (p[1].measured[0] - p[0].measured[0]))
            .sum();
        let stored = branch.points.last().map_or(0.0, |last| last.measured[2]);
        assert!((work / stored - 1.0).abs() < 0.01, "{work} {stored}");
        // At a limit point the load is stationary along the branch: the points around it are above.
        let around = [&branch.points[second.after], &branch.points[second.after + 1]];
        assert!(around.iter().all(|point| point.parameter >= second.parameter));
        second_limits.push(second.parameter);
    }
    assert!(second_limits[1] > 1.02 * second_limits[0], "{second_limits:?}");
    Ok(())
}
