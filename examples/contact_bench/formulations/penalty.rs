//! The penalty method: springs of 10, 100 and 10⁴ E/h.

use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{distance, obstacle_distance, own_stiffness, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        factor: Param,
    }
    pub fn pressure(u: Vector) -> Scalar {
        factor * young / h * neg_part(obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Surface, weight() * pressure(u) * dot(v, obstacle_normal))
    }
    pub fn pair_pressure(u: Vector) -> Scalar {
        factor * own_stiffness() * neg_part(distance(u))
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, own_weight() * pair_pressure(u) * dot(toward, jump(v)))
    }
}

pub struct Penalty {
    factor: f64,
}

pub fn all() -> Vec<Penalty> {
    [10.0, 100.0, 1e4].map(|factor| Penalty { factor }).into()
}

impl Formulation for Penalty {
    fn name(&self) -> String {
        format!("penalty {} E/h", self.factor)
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let data = law::data_from(case.data.clone()).factor(self.factor);
        match case.contact {
            Contact::Obstacle(_) => {
                case.newton(&law::on_obstacle(&data, &case.surface()), |u| law::pressure(&data, u))
            }
            Contact::Bodies(_) => {
                case.newton(&law::between(&data, &case.touch(Sides::Own)), |u| law::pair_pressure(&data, u))
            }
        }
    }
}
