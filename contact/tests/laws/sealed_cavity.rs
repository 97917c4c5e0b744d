//! A ring with a filled cavity: the pressure in closed form, the kept volume, the symmetric tangent, and the adjoint state of the pressure.

use std::f64::consts::PI;

use forms_contact::laws::mixed_nitsche::usual_gamma0;
use forms_contact::laws::sealed_cavity::{self as laws, sealed_cavity as law};
use forms_contact::parameter_ranges::ParameterRanges;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::setting::{check_tangent, close, wave};

/// Radii, μ.
const INNER: f64 = 1.0;
const OUTER: f64 = 2.0;
const MU: f64 = 1.0;

/// The quarter of a ring: "bottom" and "top" are the inner and the outer arc, "left" and "right" on the axes x and y.
struct Ring {
    mesh: Mesh<2>,
    spaces: [Arc<Space<2>>; 3],
}

impl Ring {
    fn new(across: usize) -> Ring {
        let place = |[s, t]: [f64; 2]| {
            let (angle, radius) = (PI / 2.0 * s, INNER + t * (OUTER - INNER));
            [radius * angle.cos(), radius * angle.sin()]
        };
        // Counted against the clock from the first axis, radii grow to the right: the mirror makes cells positive.
        let mirrored = |[s, t]: [f64; 2]| place([1.0 - s, t]);
        let mesh = structured([2 * across, across], CellShape::Quadrilateral, 2, mirrored).unwrap();
        let space = |elements, scope, shape: &[usize]| Space::of(&mesh, elements, scope, shape).unwrap();
        let spaces = [
            space(Elements::Lagrange(2), Scope::Nodes, &[2]),
            space(Elements::LinearInSpace, Scope::Cell, &[]),
            space(Elements::Lagrange(0), Scope::Body, &[]),
        ];
        Ring { mesh, spaces }
    }

    fn spaces(&self) -> [&Arc<Space<2>>; 3] {
        self.spaces.each_ref()
    }

    fn symmetric(&self) -> Constraints<2> {
        let mut held = Constraints::new(&self.spaces[0]);
        held.fix_component("left", 0, |_| 0.0).unwrap();
        held.fix_component("right", 1, |_| 0.0).unwrap();
        held
    }
}

/// A tool on the second axis whose lowest point is at this height.
fn model(bulk: f64, ratio: f64, tool: f64) -> law::Model<2> {
    let data = law::data()
        .mu(MU)
        .bulk_modulus(bulk)
        .gamma0(usual_gamma0(MU))
        .volume_ratio(ratio)
        .centre([0.0, tool + 1.5])
        .radius(1.5);
    let regions = law::Regions::default().gamma_n("top").gamma_c("top").wall("bottom");
    law::Model { data, regions }
}

fn options() -> NewtonOptions {
    NewtonOptions {
        relative_tolerance: 1e-13,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    }
}

fn solve(ring: &Ring, bulk: f64, ratio: f64, tool: f64) -> [Field<2>; 3] {
    let held = ring.symmetric();
    let pressed = OUTER - tool;
    let steps = LoadSteps::uniform(3, 1.0);
    let path = steps.advance(ring.spaces().map(Field::zero), |step| {
        let at = |end: f64, start: f64| start + step.factor * (end - start);
        let form: Form<2> = model(bulk, at(ratio, 1.0), OUTER - at(pressed, 0.0)).energy().into();
        let problem = Problem::new(&form, ring.spaces()).constrained(&held).options(options());
        problem.increment(step).solve().map(|solved| solved.fields)
    });
    path.map_err(|error| error.to_string()).unwrap().state
}

/// r² = R² + c of an incompressible neo-Hookean ring in plane strain: p = μ ∫ (λ² − λ⁻²) R/r² dR, λ = r/R.
fn closed_form(c: f64) -> f64 {
    let steps = 4000;
    let width = (OUTER - INNER) / f64::from(steps);
    let at = |k: i32| {
        let squared = (INNER + (f64::from(k) + 0.5) * width).powi(2);
        let stretch = (squared + c) / squared;
        (stretch - 1.0 / stretch) * squared.sqrt() / (squared + c)
    };
    MU * (0..steps).map(at).sum::<f64>() * width
}

/// The cavity's area grows from π to π (1 + c), in an incompressible ring without the tool.
#[test]
fn a_filled_ring_has_the_pressure_of_the_closed_form() {
    let errors = [2, 4].map(|across| {
        let ring = Ring::new(across);
        let [u, _, filling] = solve(&ring, 1e7 * MU, 1.5, OUTER + 10.0);
        let volume = Assembler::new(&ring.mesh).functional(&model(1.0, 1.5, OUTER).volume(&u)).unwrap();
        assert!((volume / (1.5 * PI / 4.0) - 1.0).abs() < 1e-3, "{volume}");
        (filling.values()[0] / closed_form(0.5) - 1.0).abs()
    });
    println!("{errors:?}");
    assert!(errors[1] < 1e-4 && errors[1] < errors[0] / 6.0, "{errors:?}");
}

#[test]
fn the_volume_is_kept_under_a_tool() {
    let ring = Ring::new(4);
    let law = model(1000.0 * MU, 1.0, OUTER - 0.3);
    let [u, p, filling] = solve(&ring, 1000.0 * MU, 1.0, OUTER - 0.3);
    let assembler = Assembler::new(&ring.mesh);
    let [now, before] = [law.volume(&u), law.volume_at_rest()].map(|v| assembler.functional(&v).unwrap());
    println!("pressure {}, volume {now} of {before}", filling.values()[0]);
    assert!((now / before - 1.0).abs() < 1e-12, "{now} of {before}");
    assert!(filling.values()[0] > 0.01 * MU, "the tool presses what fills it");
    // The body's own volume: K times the mean of J − 1 is that of p.
    let tangent = assembler.tangent(&law.energy(), &[&u, &p, &filling], &ring.spaces()).unwrap();
    assert!(tangent.is_symmetric(1e-12).unwrap());
}

#[test]
fn the_tangent_is_exact() {
    let ring = Ring::new(2);
    let law = model(50.0 * MU, 1.1, OUTER - 0.3);
    let [us, ps, body] = ring.spaces();
    let scalar = |space: &Arc<Space<2>>, size: f64, phase: f64| {
        Field::interpolate(space, |x: &[f64; 2]| size * (x[0] - 1.3 * x[1] + phase).sin()).unwrap()
    };
    let unknowns = [wave(us, 0.05, 0.4), scalar(ps, 0.2, 0.1), scalar(body, 0.3, 1.0)];
    let directions = [wave(us, 0.05, 2.3), scalar(ps, 0.2, 1.1), scalar(body, 0.3, 2.0)];
    let assembler = Assembler::new(&ring.mesh).with_quadrature(Quadrature::Degree(5));
    let form: Form<2> = law.energy().into();
    check_tangent("sealed", &assembler, &form, &unknowns.each_ref(), &directions.each_ref());
    let refused = law::Model { data: law::Data { volume_ratio: 0.0, ..law.data.clone() }, ..law };
    assert!(laws::Model::check(&refused, "energy").unwrap_err().to_string().contains("volume_ratio"));
}

/// The pressure by the filling and by the tool's size.
#[test]
fn the_adjoint_of_the_pressure_is_that_of_differences() {
    let ring = Ring::new(3);
    let bulk = 200.0 * MU;
    let held = ring.symmetric();
    let assembler = Assembler::new(&ring.mesh).with_quadrature(Quadrature::Degree(5));
    let first = solve(&ring, bulk, 1.05, OUTER - 0.2);
    let solve = |change: [f64; 2]| {
        let mut law = model(bulk, 1.05 + change[0], OUTER - 0.2);
        law.data.radius += change[1];
        let form: Form<2> = law.energy().into();
        let solved = Problem::new(&form, ring.spaces())
            .assembler(&assembler)
            .constrained(&held)
            .options(options())
            .start(&first)
            .solve()
            .unwrap();
        let value = assembler.functional(&law.scaled_pressure(&solved.fields[2])).unwrap();
        (law, solved.fields, value)
    };
    let (law, [u, p, c], _) = solve([0.0; 2]);
    let adjoint = law.pressure_adjoint(&u, &p, &c);
    let solved =
        Problem::new(&adjoint, ring.spaces()).assembler(&assembler).homogeneous(&held).solve().unwrap();
    let [z, s, t] = solved.fields;
    let gradients = [law.by_volume_ratio(&u, &p, &c, &z, &s, &t), law.by_radius(&u, &p, &c, &z, &s, &t)];
    for (k, gradient) in gradients.iter().enumerate() {
        let gradient = assembler.functional(gradient).unwrap();
        let step = 1e-4;
        let along = |size: f64| std::array::from_fn(|i| if i == k { size } else { 0.0 });
        let value = |size: f64| solve(along(size)).2;
        let difference =
            (8.0 * (value(step) - value(-step)) - (value(2.0 * step) - value(-2.0 * step))) / (12.0 * step);
        close(["by volume", "by radius"][k], gradient, difference, 1e-7);
    }
}
