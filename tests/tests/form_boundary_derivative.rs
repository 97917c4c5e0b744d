//! The boundary form of the shape derivative on loaded, free and clamped circles against a closed form: a ring (Lamé's
//! problem in plane strain) with u = w(a) e_r on its inner circle, σ n = q(b) e_r on its outer one, and the criterion
//! J = ∫ F·u + ∫_∂Ω ½ c |u|², F = e_r and c following r. dJ/da and dJ/db hold each term that a plane or constant case does
//! not have: κ N, ∂_n N, κ p·g_N, ∂_n(p·g_N), ∂_n u_D.

use std::f64::consts::PI;

use forms_contact::boundary_form::boundary_form;
use forms_contact::forms;
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::prelude::*;

use crate::convergence::{digits, order};

const LAMBDA: f64 = 1.3;
const MU: f64 = 0.8;
const INNER: f64 = 1.0;
const OUTER: f64 = 2.0;

/// The load on the outer circle is q0 + q1 r, the imposed displacement w0 + w1 r, the criterion's weight c0 + c1 r.
#[derive(Clone, Copy)]
struct Ring {
    load: [f64; 2],
    imposed: [f64; 2],
    weight: [f64; 2],
}

fn along([constant, slope]: [f64; 2], r: f64) -> f64 {
    constant + slope * r
}

impl Ring {
    /// J of the ring between two radii: u_r = A r + B/r.
    fn criterion(&self, inner: f64, outer: f64) -> f64 {
        let (w, q) = (along(self.imposed, inner), along(self.load, outer));
        // A a + B/a = w, 2(λ+μ) A − 2μ B/b² = q.
        let (stretch, shear) = (2.0 * (LAMBDA + MU), 2.0 * MU / (outer * outer));
        let a = (q + shear * inner * w) / (stretch + shear * inner * inner);
        let b = inner * (w - a * inner);
        let u = |r: f64| a * r + b / r;
        let on_circle = |r: f64| r * along(self.weight, r) / 2.0 * u(r).powi(2);
        let inside = a * (outer.powi(3) - inner.powi(3)) / 3.0 + b * (outer - inner);
        2.0 * PI * (inside + on_circle(inner) + on_circle(outer))
    }

    /// dJ/da and dJ/db, by differences of fourth order of the closed form.
    fn derivatives(&self) -> [f64; 2] {
        let slope = |j: &dyn Fn(f64) -> f64| {
            let central = |step: f64| (j(step) - j(-step)) / (2.0 * step);
            (4.0 * central(1e-3) - central(2e-3)) / 3.0
        };
        [slope(&|s| self.criterion(INNER + s, OUTER)), slope(&|s| self.criterion(INNER, OUTER + s))]
    }

    /// The same from discrete states on `radial` cells across: the boundary form on both circles, each moving outwards.
    fn boundary_form(&self, radial: usize) -> [f64; 2] {
        let mesh = annulus(INNER, OUTER, radial, 8 * radial, CellShape::Quadrilateral, 2).unwrap();
        let space = Space::vector(&mesh, 2).unwrap();
        let imposed = self.imposed;
        let mut constraints = Constraints::new(&space);
        constraints.fix("inner", move |x| radially(imposed, x)).unwrap();
        let data = forms::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(10.0)
            .obstacle_normal([0.0, -1.0])
            .gap(1e6)
            .theta(0.0)
            .traction(given(self.load))
            .criterion_force(given([1.0, 0.0]))
            .criterion_weight({
                let [constant, slope] = self.weight;
                Given::function_with_gradient(
                    move |x| constant + slope * x[0].hypot(x[1]),
                    move |x| x.map(|v| slope * v / x[0].hypot(x[1])),
                )
            });
        let regions = forms::Regions::default().gamma_n("outer").gamma_c("outer");
        let problem = ContactProblem::new(&space, forms::Model { data, regions }, constraints)
            .quadrature(Quadrature::Degree(8));
        let mut solver = TangentSolver::default();
        let u = problem.direct().unwrap().solver(&mut solver).solve().unwrap();
        let u = u.into_field();
        let p = problem.solve_adjoint(Adjoint::Consistent, &u, &mut solver).unwrap().into_field();
        let outwards = Field::interpolate(&space, |x| radially([1.0, 0.0], x)).unwrap();
        let data = boundary_form::data_from(problem.law.data.clone()).imposed(given(self.imposed));
        let clamped = boundary_form::Clamped::on("inner");
        let inner = boundary_form::on_clamped(&data, &clamped, &u, &p, &outwards);
        let loaded = boundary_form::Loaded::on("outer");
        let outer = boundary_form::on_loaded(&data, &loaded, &u, &p, &outwards);
        let outer = problem.assembler.functional(&outer).unwrap();
        if self.load == [0.0; 2] {
            // Without a load it is a free boundary as well.
            let free = boundary_form::Free::on("outer");
            let form = boundary_form::on_free(&data, &free, &u, &p, &outwards);
            let found = problem.assembler.functional(&form).unwrap();
            assert!((found - outer).abs() <= 1e-13 * outer.abs(), "{found} and {outer}");
            let form = boundary_form::gradient_on_free(&data, &free, &u, &p);
            let gradient = problem.assembler.linear_form(&form, &space).unwrap();
            let found: f64 = gradient.iter().zip(outwards.values()).map(|(g, v)| g * v).sum();
            assert!((found - outer).abs() <= 1e-12 * outer.abs(), "{found} and {outer}");
        }
        [problem.assembler.functional(&inner).unwrap(), outer]
    }
}

fn radially(coefficients: [f64; 2], x: &[f64; 2]) -> [f64; 2] {
    let r = x[0].hypot(x[1]);
    x.map(|v| along(coefficients, r) * v / r)
}

/// (constant + slope r) e_r with its gradient.
fn given([constant, slope]: [f64; 2]) -> Given<[f64; 2], 2> {
    Given::function_with_gradient(
        move |x| radially([constant, slope], x),
        move |x| {
            let r = x[0].hypot(x[1]);
            // constant (I/r − x⊗x/r³) + slope I.
            [0, 1].map(|i| {
                [0, 1].map(|j| {
                    let same = if i == j { 1.0 } else { 0.0 };
                    constant * (same / r - x[i] * x[j] / r.powi(3)) + slope * same
                })
            })
        },
    )
}

/// The stresses of degree 1 on the boundary converge with order 2. A term too many or too few leaves an error that does not.
fn approaches(name: &str, ring: Ring) {
    const RADIAL: [usize; 3] = [6, 12, 24];
    let exact = ring.derivatives();
    let found = RADIAL.map(|radial| ring.boundary_form(radial));
    for (circle, name_of_circle) in ["inner", "outer"].iter().enumerate() {
        let errors = found.map(|found| ((found[circle] - exact[circle]) / exact[circle]).abs());
        println!("{name}, {name_of_circle}: {:.6}, errors {}", exact[circle], digits(&errors));
        assert!(errors[2] < 3e-3, "{name}, {name_of_circle}: {}", digits(&errors));
        assert!(order(&RADIAL, &errors) > 1.8, "{name}, {name_of_circle}: {}", digits(&errors));
    }
}

#[test]
fn a_load_that_follows_the_position() {
    approaches("load", Ring { load: [0.4, 0.3], imposed: [0.0, 0.0], weight: [0.0, 0.0] });
}

#[test]
fn an_imposed_displacement_that_follows_the_position() {
    approaches("imposed", Ring { load: [0.0, 0.0], imposed: [0.1, -0.25], weight: [0.0, 0.0] });
}

#[test]
fn a_criterion_on_the_boundary_whose_weight_follows_the_position() {
    approaches("weight", Ring { load: [0.0, 0.0], imposed: [0.2, 0.1], weight: [2.0, -0.7] });
}

#[test]
fn all_of_these_at_once() {
    approaches("all", Ring { load: [0.4, -0.3], imposed: [0.2, 0.15], weight: [1.0, 0.5] });
}
