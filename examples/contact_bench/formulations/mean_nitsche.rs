//! Nitsche's method, θ = 0, with one pressure per own facet, or per vertex of it for displacements of degree 2.

use contact_bench::outcome::not_defined;
use contact_bench::solution::contact_forces;
use contact_bench::two_bodies::SolvedLoad;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding, TwoBodies,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::Touch;
    use contact_bench::body::{distance, own_stiffness, own_stress, own_weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {}
    fn augmented(u: Vector) -> Scalar {
        own_weight() * (own_stress(u) + 13 * own_stiffness() * distance(u))
    }
    pub fn of_facets(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch, 0, neg_part(mean(augmented(u))) * mean(dot(toward, jump(v))))
    }
    pub fn of_vertices(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch, 1, neg_part(mean(augmented(u))) * mean(dot(toward, jump(v))))
    }
}

#[forms(dimension = 2)]
mod drawn {
    pub use contact_bench::sliding::{Omega, Touch};
    use contact_bench::sliding::{balance, own_stiffness, own_stress};
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {}
    fn augmented(u: Vector) -> Scalar {
        own_stress(u) + 10 * own_stiffness() * gap
    }
    pub fn of_facets(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) + means(Touch(u), 0, neg_part(mean(augmented(u))) * mean(dot(toward, jump(v))))
    }
    pub fn of_vertices(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) + means(Touch(u), 1, neg_part(mean(augmented(u))) * mean(dot(toward, jump(v))))
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{balance, separation};
    use forms_contact::operators::bodies::{own_gamma, own_traction};
    use forms_contact::operators::friction::{augmented_traction, ball_projection, slip_limit, tangential};
    #[includes(contact_bench::two_bodies::bodies::Data)]
    pub struct Data {}
    fn augmented(w: Vector) -> Vector {
        let slip = jump(w - displacement_before);
        augmented_traction(own_traction(w), separation(w), slip, own_gamma(), toward)
    }
    fn power(w: Vector, e: Vector) -> Scalar {
        let pressure = neg_part(mean(dot(augmented(w), toward)));
        let held = ball_projection(mean(tangential(augmented(w), toward)), slip_limit(pressure));
        dot(held, mean(tangential(e, toward))) - pressure * mean(dot(e, toward))
    }
    pub fn of_facets(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) - means(Touch, 0, power(u, jump(v)))
    }
    pub fn of_vertices(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) - means(Touch, 1, power(u, jump(v)))
    }
}

const RIGID: &str = "means over facets exist on pairs only";

/// Nitsche's method with means of gaps.
pub struct MeanNitsche;

/// The one variant.
pub fn all() -> Vec<MeanNitsche> {
    vec![MeanNitsche]
}

impl MeanNitsche {
    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        let (omega, touch) = (bodies.omega(), bodies.touch(Sides::Own));
        bodies.follow_by(13.0, [Field::zero(&bodies.space)], |given, load, [u]| {
            let data = rough::data_from(given);
            let form = match bodies.space.degree() {
                1 => rough::of_facets(&data, &omega, &touch),
                _ => rough::of_vertices(&data, &omega, &touch),
            };
            let solved = bodies.problem(&form, load).start(u).solve()?;
            let traction = bodies.traction_of_forces(&solved)?;
            Ok(SolvedLoad::of(solved, traction))
        })
    }
}

impl Formulation for MeanNitsche {
    fn name(&self) -> String {
        "mean gaps, nitsche θ = 0".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if let Contact::Obstacle(_) = case.contact {
            return Err(not_defined(RIGID));
        }
        let (data, touch) = (law::data_from(case.data.clone()), case.touch(Sides::Own));
        let form = match case.space.degree() {
            1 => law::of_facets(&data, &touch),
            _ => law::of_vertices(&data, &touch),
        };
        let solved = case.problem(&form).solve()?;
        let forces = contact_forces(case, &solved)?;
        Ok(Outcome::of(case, &solved, case.pressures_of_forces(&forces)?)?.of_form(&case.balance() + &form))
    }

    fn press(&self, _ring: &Rubber) -> Result<Pressed, Refusal> {
        Err(not_defined(RIGID))
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let (data, touch) = (drawn::data_from(bodies.data.clone()), bodies.touch(Sides::OwnWholeFacets));
        match bodies.space.degree() {
            1 => bodies.follow(&drawn::of_facets(&data, &bodies.omega(), &touch)),
            _ => bodies.follow(&drawn::of_vertices(&data, &bodies.omega(), &touch)),
        }
    }
}
