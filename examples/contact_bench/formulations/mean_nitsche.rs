//! Nitsche's method, θ = 0, with one pressure per own facet, or per vertex of it for displacements of degree 2.

use contact_bench::outcome::not_defined;
use contact_bench::solution::contact_forces;
use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides, Slid, Sliding};
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

/// Nitsche's method with means of gaps.
pub struct MeanNitsche;

/// The one variant.
pub fn all() -> Vec<MeanNitsche> {
    vec![MeanNitsche]
}

impl Formulation for MeanNitsche {
    fn name(&self) -> String {
        "mean gaps, nitsche θ = 0".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if let Contact::Obstacle(_) = case.contact {
            return Err(not_defined("means over facets exist on pairs only"));
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

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let (data, touch) = (drawn::data_from(bodies.data.clone()), bodies.touch(Sides::OwnWholeFacets));
        match bodies.space.degree() {
            1 => bodies.follow(&drawn::of_facets(&data, &bodies.omega(), &touch)),
            _ => bodies.follow(&drawn::of_vertices(&data, &bodies.omega(), &touch)),
        }
    }
}
