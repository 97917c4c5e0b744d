//! The augmented Lagrangian with semismooth Newton steps: a multiplier on the own surface, of the displacement's degree.

use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Loaded, Omega, Surface, Touch};
    use contact_bench::body::{balance, distance, obstacle_distance, own_stiffness, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {}
    pub fn on_obstacle(u: Unknown<Vector>, l: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let gamma = 10 * young / h;
        let update = pos_part(l - gamma * obstacle_distance(u));
        let terms = l * dot(v, obstacle_normal) - (l - update) / gamma * q;
        balance(u, v) + integral(Surface, weight() * terms)
    }
    pub fn between(u: Unknown<Vector>, l: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let gamma = 10 * own_stiffness();
        let update = pos_part(this(l) - gamma * distance(u));
        let terms = this(l) * dot(toward, jump(v)) - (this(l) - update) / gamma * this(q);
        balance(u, v) + integral(Touch, own_weight() * terms)
    }
}

pub struct AugmentedLagrangian;

pub fn all() -> Vec<AugmentedLagrangian> {
    vec![AugmentedLagrangian]
}

impl Formulation for AugmentedLagrangian {
    fn name(&self) -> String {
        "augmented Lagrangian".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let (data, bodies, load) = (law::data_from(case.data.clone()), case.bodies(), case.load());
        let form = match case.contact {
            Contact::Obstacle(_) => law::on_obstacle(&data, &bodies, &load, &case.surface()),
            Contact::Bodies(_) => law::between(&data, &bodies, &load, &case.touch(Sides::Own)),
        };
        let (scalars, u) = (case.scalars()?, case.first());
        let guess = Field::zero(&scalars);
        let solved = case.mixed_problem(&form, &scalars).start([&u, &guess]).solve()?;
        let pressures = case.known_pressures(&solved.fields[1])?;
        Ok(Outcome::of(case, &solved, pressures)?.of_form(form))
    }
}
