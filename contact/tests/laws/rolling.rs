//! A tyre of rubber on a rigid core that rolls along a flat, until all points in contact are others: where it sticks nothing slips, and the
//! core's force and moment are those of the tractions of the flat.

use forms_contact::ContactProblem;
use forms_contact::laws::finite_nitsche as law;
use forms_fem::prelude::*;

use crate::setting::{Friction, YOUNG, data};

#[forms(dimension = 2)]
mod rolled {
    use forms_contact::laws::finite_nitsche::obstacle_traction;
    pub use forms_contact::laws::finite_nitsche::{Data, GammaC};
    use forms_contact::laws::frictional_nitsche::{augmented, slip_limit};
    use forms_contact::operators::friction::tangential;
    use forms_contact::operators::neo_hookean::first_piola;

    fn pressure(w: Vector) -> Scalar {
        neg_part(dot(augmented(first_piola(w) * n, w), obstacle_normal))
    }
    /// One where the body presses and sticks.
    fn sticks(w: Vector) -> Scalar {
        let P = augmented(first_piola(w) * n, w);
        heaviside(pressure(w)) * heaviside(slip_limit(pressure(w)) - norm(tangential(P, obstacle_normal)))
    }
    /// The moment about the origin of what the flat does to the body.
    pub fn moment(u: State<Vector>) -> Functional {
        let y = x + u;
        let T = obstacle_traction(u);
        integral(GammaC, y[0] * T[1] - y[1] * T[0])
    }
    pub fn force(u: State<Vector>, axis: State<Vector>) -> Functional {
        integral(GammaC, dot(obstacle_traction(u), axis))
    }
    pub fn stick(u: State<Vector>) -> Functional {
        integral(GammaC, sticks(u))
    }
    pub fn slip_where_it_sticks(u: State<Vector>) -> Functional {
        integral(GammaC, sticks(u) * norm(tangential(u - displacement_before, obstacle_normal)))
    }
    pub fn contact(u: State<Vector>) -> Functional {
        integral(GammaC, heaviside(pressure(u)))
    }
}

const DOWN: f64 = 0.03;
/// The angle of a step, and how far the core goes along in it: nearly as a rigid wheel of the radius 1 would.
const ANGLE: f64 = 0.05;
const ALONG: f64 = 0.98 * ANGLE;
const STEPS: usize = 14;

#[test]
fn a_tyre_rolls_without_slip_where_it_sticks() {
    let mesh = annulus(0.5, 1.0, 3, 48, CellShape::Quadrilateral, 2).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
    let mut before = Field::zero(&space);
    for step in 0..=STEPS {
        let (sine, cosine) = (-ANGLE * step as f64).sin_cos();
        let centre = [ALONG * step as f64, -DOWN];
        let mut core = Constraints::new(&space);
        core.fix("inner", |x| {
            [cosine * x[0] - sine * x[1] + centre[0] - x[0], sine * x[0] + cosine * x[1] + centre[1] - x[1]]
        })
        .unwrap();
        let mut data = data::<2>(Friction::Coulomb(0.8), 0.0, 20.0 * YOUNG);
        data.gap = Given::function(|x: &[f64; 2]| x[1] + 1.0);
        data.displacement_before = Given::field(&before);
        let of_flat =
            rolled::Model { data: data.clone(), regions: rolled::Regions::default().gamma_c("outer") };
        let regions = law::Regions::default().gamma_n("outer").gamma_c("outer");
        let problem =
            ContactProblem::new(&space, law::Model { data, regions }, core).assembler(assembler.clone());
        let options = NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        let solved = problem.direct().unwrap().options(options).start(&before).solve();
        let solved = solved.unwrap_or_else(|error| panic!("step {step}: {error}"));
        let u = solved.field();
        let force = solved.reaction("inner").unwrap();
        let moment = solved.reaction_moment("inner", [0.0; 2]).unwrap()[0];
        let along = |axis: [f64; 2]| {
            let axis = Field::interpolate(&space, |_| axis).unwrap();
            solved.functional(&of_flat.force(u, &axis)).unwrap()
        };
        let (friction, pressed) = (along([1.0, 0.0]), along([0.0, 1.0]));
        let (held, of_tractions) = (moment, solved.functional(&of_flat.moment(u)).unwrap());
        let stick = solved.functional(&of_flat.stick(u)).unwrap();
        let contact = solved.functional(&of_flat.contact(u)).unwrap();
        let slip = solved.functional(&of_flat.slip_where_it_sticks(u)).unwrap() / stick;
        // About the core's centre: the arm is its height, and what is left is the pressure's, which is ahead of the centre.
        let about_centre = moment - centre[0] * force[1] + centre[1] * force[0];
        let ahead = ((1.0 - DOWN) * force[0] - about_centre) / pressed;
        println!(
            "step {step}: Newton {}, P {pressed:.4}, Q {friction:.4}, stick {stick:.4} of {contact:.4}, slip {slip:.1e}, {ahead:.4}",
            solved.iterations()
        );
        for (found, expected) in [(force[0], -friction), (force[1], -pressed), (held, -of_tractions)] {
            assert!((found - expected).abs() < 1e-9 * pressed, "step {step}: {found} is not {expected}");
        }
        assert!(friction.abs() <= 0.8 * pressed);
        if step > 0 {
            assert!(stick > 0.5 * contact, "step {step}: {stick} of {contact} sticks");
            assert!(slip < 0.01 * ALONG, "step {step}: {slip:e} where it sticks, on a way of {ALONG}");
            assert!(ahead.abs() < contact / 10.0, "step {step}: {ahead}");
        }
        before = u.clone();
    }
    // The whole contact is new: more than its length has been rolled over.
    assert!(ALONG * STEPS as f64 > 0.6);
}
