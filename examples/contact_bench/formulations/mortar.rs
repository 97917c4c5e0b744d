//! Mortar: a multiplier of degree 1 on the own facets, as in `forms_contact::laws::mortar_bodies`, whose gap has the mean zero against each function.

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides, Slid, Sliding};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Loaded, Omega, Surface, Touch};
    use contact_bench::body::{balance, distance, own_stiffness, own_weight, weight};
    use forms_contact::operators::multipliers::normal_condition;
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        /// The part with which p = 0 counts on the own surface, so that what nothing faces has no pressure.
        #[default(0.000000000000000001)]
        uncovered: Param,
    }
    pub fn between(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let condition = normal_condition(this(p), distance(u), 10 * own_stiffness());
        balance(u, v) + integral(Touch, own_weight() * (this(p) * dot(toward, jump(v)) - condition * this(q)))
            - integral(Surface, weight() * uncovered * h / (10 * young) * p * q)
    }
}

#[forms(dimension = 2)]
mod drawn {
    pub use contact_bench::sliding::{Omega, Touch};
    use contact_bench::sliding::{balance, own_stiffness};
    use forms_contact::operators::multipliers::normal_condition;
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {
        #[default(0.000000000000000001)]
        uncovered: Param,
    }
    #[facets]
    pub struct Own;
    pub fn between(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let condition = normal_condition(this(p), gap, 10 * own_stiffness());
        balance(u, v) + integral(Touch(u), this(p) * dot(toward, jump(v)) - condition * this(q))
            - integral(Own, uncovered * h / (10 * young) * p * q)
    }
}

pub struct Mortar;

pub fn all() -> Vec<Mortar> {
    vec![Mortar]
}

impl Formulation for Mortar {
    fn name(&self) -> String {
        "mortar, degree 1".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if let Contact::Obstacle(_) = case.contact {
            return Err(not_defined("a rigid obstacle has no mesh: this is the augmented Lagrangian"));
        }
        let data = law::data_from(case.data.clone());
        let form =
            law::between(&data, &case.bodies(), &case.load(), &case.surface(), &case.touch(Sides::Own));
        let scalars = Space::on_facets(case.mesh(), case.own(), 1)?;
        let guess = Field::from_values(&scalars, vec![case.pressure; scalars.unknowns()])?;
        let u = case.first();
        let solved = case.mixed_problem(&form, &scalars).start([&u, &guess]).solve()?;
        let pressures = case.known_pressures(&solved.fields[1])?;
        Ok(Outcome::of(case, &solved, pressures)?.of_form(form))
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let own = drawn::Own::on(bodies.surfaces[0]);
        let form = drawn::between(
            &drawn::data_from(bodies.data.clone()),
            &own,
            &bodies.omega(),
            &bodies.touch(Sides::Own),
        );
        bodies.follow_pressure(&form, &bodies.scalars(1)?)
    }
}
