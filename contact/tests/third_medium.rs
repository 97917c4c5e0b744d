//! Contact through a third medium: a C that closes, against the values of two other programs, and derivatives against differences.

use forms_contact::laws::third_medium::{
    MediumParameters, medium, third_medium as law, third_medium_problem,
};
use forms_fem::linear_algebra::vector::largest;
use forms_fem::prelude::*;

/// Parameters of the benchmark: μ and λ of the body, and the medium's part of them.
const MU: f64 = 5.0 / 14.0;
const LAMBDA: f64 = 5.0 / 3.0;
const SOFTNESS: f64 = 5e-6;
/// The way of the pressed node in each step.
const WAY: f64 = 0.031;

/// A C in its box: cells of 1/10 or smaller, biquadratic.
struct Closing {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    pressed: usize,
}

impl Closing {
    fn new(finer: usize) -> Self {
        let mut mesh =
            rectangle([0.0; 2], [1.1, 0.5], [11 * finer, 5 * finer], CellShape::Quadrilateral, 1).unwrap();
        let is_medium = |x: &[f64; 2]| x[0] > 1.0 || (x[0] > 0.1 && (x[1] - 0.25).abs() < 0.15);
        mesh.name_cells("medium", is_medium).unwrap();
        mesh.name_cells("body", |x| !is_medium(x)).unwrap();
        let space = Space::vector(&mesh, 2).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
        let pressed = space.nearest_node(&[1.0, 0.5]).unwrap();
        Closing { space, assembler, pressed }
    }

    fn model(&self, mu: f64) -> law::Model<2> {
        let MediumParameters { lambda: medium_lambda, mu: medium_mu, curvature_stiffness } =
            medium(LAMBDA, MU, SOFTNESS, 1.0);
        let data = law::data()
            .lambda(LAMBDA)
            .mu(mu)
            .medium_lambda(medium_lambda)
            .medium_mu(medium_mu)
            .curvature_stiffness(curvature_stiffness);
        law::Model { data, regions: law::Regions::default().omega("body").medium("medium").gamma_n("top") }
    }

    fn constraints(&self, way: f64) -> Constraints<2> {
        let mut held = Constraints::new(&self.space);
        held.fix("left", |_| [0.0; 2]).unwrap();
        held.fix_node(self.pressed, 1, -way).unwrap();
        held
    }

    /// The displacement 1 of the pressed node, against the way.
    fn lift(&self) -> Field<2> {
        let mut values = vec![0.0; self.space.unknowns()];
        values[2 * self.pressed + 1] = 1.0;
        Field::from_values(&self.space, values).unwrap()
    }

    fn force(&self, u: &Field<2>, mu: f64) -> f64 {
        -self.assembler.functional(&self.model(mu).force_along(u, self.lift())).unwrap()
    }

    fn step(&self, mu: f64, k: usize, start: &Field<2>, options: &NewtonOptions) -> Solved<2> {
        third_medium_problem(&self.model(mu), &self.space)
            .unwrap()
            .constrained(&self.constraints(WAY * k as f64))
            .assembler(&self.assembler)
            .start(start)
            .options(NewtonOptions { prescribed_values: PrescribedValues::ByTangent, ..options.clone() })
            .solve()
            .unwrap_or_else(|error| panic!("step {k}: {error}"))
    }
}

/// Forces of felupe and NGSolve, which agree to 2e-11, in steps 1, 5, 10 and 15.
const FORCES: [(usize, f64); 4] =
    [(1, 1.33196155e-5), (5, 6.73803462e-5), (10, 1.48316229e-4), (15, 3.08914658e-4)];

#[test]
fn a_closing_c_has_the_forces_of_other_programs() {
    let c = Closing::new(1);
    assert_eq!(c.space.unknowns(), 506);
    let mut u = Field::zero(&c.space);
    let (mut steps, mut counts) = (0, vec![]);
    for k in 1..=20 {
        let solved = c.step(MU, k, &u, &NewtonOptions::default());
        counts.push(solved.iterations());
        steps += solved.iterations();
        u = solved.into_field();
        let force = c.force(&u, MU);
        if let Some((_, known)) = FORCES.iter().find(|(step, _)| *step == k) {
            assert!((force / known - 1.0).abs() < 5e-9, "step {k}: {force:.9e}, {known:.9e}");
        }
    }
    // felupe takes 96.
    assert!(steps <= 96, "{steps}: {counts:?}");
}

#[test]
fn a_force_has_the_derivative_by_the_body_s_stiffness() {
    let c = Closing::new(1);
    let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
    let go = |mu: f64| (1..=12).fold(Field::zero(&c.space), |u, k| c.step(mu, k, &u, &options).into_field());
    let u = go(MU);
    let mut held = Constraints::new(&c.space);
    held.fix("left", |_| [0.0; 2]).unwrap();
    held.fix_node(c.pressed, 1, 1.0).unwrap();
    let model = c.model(MU);
    let adjoint = Problem::new(&model.force_adjoint(&u), &c.space)
        .constrained(&held)
        .assembler(&c.assembler)
        .solve()
        .unwrap()
        .into_field();
    let slope = -c.assembler.functional(&model.force_by_mu(&u, &adjoint)).unwrap();
    let step = 1e-4 * MU;
    let [a, b, d, e] = [-2.0, -1.0, 1.0, 2.0].map(|t| c.force(&go(MU + t * step), MU + t * step));
    let difference = (a - 8.0 * b + 8.0 * d - e) / (12.0 * step);
    assert!((slope / difference - 1.0).abs() < 1e-8, "{slope:e}, {difference:e}");
}

#[test]
fn the_tangent_is_symmetric_and_that_of_the_residual() {
    let c = Closing::new(1);
    let model = c.model(MU);
    let form = model.direct();
    let at = |t: f64| {
        Field::interpolate(&c.space, |x: &[f64; 2]| {
            let bend = |k: f64| 0.05 * (k * x[0] + 2.0 * x[1]).sin() * x[0];
            [(0.3 + t) * bend(2.0), (0.2 + t) * bend(3.0)]
        })
        .unwrap()
    };
    let (u, direction) = (at(0.0), at(1.0));
    let way: Vec<f64> = direction.values().iter().zip(u.values()).map(|(a, b)| a - b).collect();
    let tangent = c.assembler.tangent(&form, &[&u], &[&c.space]).unwrap();
    assert!(tangent.asymmetry().unwrap() < 1e-13);
    let residual = |t: f64| c.assembler.residual(&form, &[&at(t)], &[&c.space]).unwrap();
    let (before, slope) = (residual(0.0), tangent.multiply(&way).unwrap());
    let rest = |t: f64| {
        let after = residual(t);
        let rest = after.iter().zip(&before).zip(&slope).map(|((a, b), s)| a - b - t * s);
        largest(&rest.collect::<Vec<_>>())
    };
    let order = (rest(0.01) / rest(0.005)).log2();
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

/// One node that moves by a third of a cell: imposed at once it nearly turns cells inside out, which takes many steps to repair.
#[test]
fn prescribed_values_that_are_imposed_by_the_tangent_save_steps() {
    let c = Closing::new(1);
    let start = Field::zero(&c.space);
    let solve = |prescribed_values| {
        let solved = third_medium_problem(&c.model(MU), &c.space)
            .unwrap()
            .constrained(&c.constraints(WAY))
            .assembler(&c.assembler)
            .start(&start)
            .options(NewtonOptions { prescribed_values, ..NewtonOptions::default() })
            .solve()
            .unwrap();
        (solved.iterations(), solved.history.len(), solved.into_field())
    };
    let (at_once, _, u) = solve(PrescribedValues::AtOnce);
    let (by_tangent, entries, v) = solve(PrescribedValues::ByTangent);
    assert!(
        by_tangent <= 5 && by_tangent + 1 == entries && at_once > 2 * by_tangent,
        "{at_once} {by_tangent}"
    );
    let differences = u.values().iter().zip(v.values()).map(|(u, v)| (u - v).abs());
    assert!(differences.fold(0.0, f64::max) < 1e-9);
}
