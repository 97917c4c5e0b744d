//! Nitsche's method: θ = −1, 0, 1, over one surface, over both, and at points of whole facets.

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{
        distance, obstacle_distance, obstacle_stress, own_stiffness, own_stress, own_weight, weight,
    };
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        theta: Param,
        share: Param,
    }
    fn gamma() -> Scalar {
        13 * young / h
    }
    pub fn pressure(u: Vector) -> Scalar {
        neg_part(obstacle_stress(u) + gamma() * obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let consistent = theta / gamma() * (obstacle_stress(u) + pressure(u)) * obstacle_stress(v);
        integral(Surface, weight() * (pressure(u) * dot(v, obstacle_normal) - consistent))
    }
    pub fn pair_pressure(u: Vector) -> Scalar {
        neg_part(own_stress(u) + 13 * own_stiffness() * distance(u))
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let consistent = theta / (13 * own_stiffness()) * (own_stress(u) + pair_pressure(u)) * own_stress(v);
        integral(Touch, share * own_weight() * (pair_pressure(u) * dot(toward, jump(v)) - consistent))
    }
}

pub struct Nitsche {
    theta: f64,
    sides: Sides,
}

pub fn all() -> Vec<Nitsche> {
    let thetas = [-1.0, 0.0, 1.0].into_iter();
    let mut all: Vec<Nitsche> =
        thetas.flat_map(|theta| [Sides::Own, Sides::Both].map(|sides| Nitsche { theta, sides })).collect();
    all.push(Nitsche { theta: 0.0, sides: Sides::OwnWholeFacets });
    all
}

impl Formulation for Nitsche {
    fn name(&self) -> String {
        let of_sides = match self.sides {
            Sides::Own => "",
            Sides::Both => ", unbiased",
            Sides::OwnWholeFacets => ", points of whole facets",
        };
        format!("nitsche θ = {}{of_sides}", self.theta)
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let data = law::data_from(case.data.clone()).theta(self.theta).share(self.sides.share());
        match case.contact {
            Contact::Obstacle(_) if self.sides != Sides::Own => {
                Err(not_defined("a rigid obstacle has no surface of its own"))
            }
            Contact::Obstacle(_) => {
                case.newton(&law::on_obstacle(&data, &case.surface()), |u| law::pressure(&data, u))
            }
            Contact::Bodies(_) => {
                case.newton(&law::between(&data, &case.touch(self.sides)), |u| law::pair_pressure(&data, u))
            }
        }
    }
}
