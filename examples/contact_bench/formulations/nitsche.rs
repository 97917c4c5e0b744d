//! Nitsche's method: θ = −1, 0, 1, over one surface, over both, and at points of whole facets.

use contact_bench::outcome::not_defined;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{
        distance, obstacle_distance, obstacle_stress, own_stiffness, own_stress, own_weight, stiffness,
        weight,
    };
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        theta: Param,
        share: Param,
    }
    pub fn pressure(u: Vector) -> Scalar {
        neg_part(obstacle_stress(u) + 13 * stiffness() * obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let consistent = theta / (13 * stiffness()) * (obstacle_stress(u) + pressure(u)) * obstacle_stress(v);
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

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::height;
    #[includes(contact_bench::volume::Data)]
    pub struct Data {
        theta: Param,
    }
    fn gamma() -> Scalar {
        200 / (h * h)
    }
    fn laplacian(u: Scalar) -> Scalar {
        div(grad(u))
    }
    pub fn force(u: Scalar) -> Scalar {
        neg_part(laplacian(u) + gamma() * height(u))
    }
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -force(u) * v - theta / gamma() * (laplacian(u) + force(u)) * laplacian(v))
    }
}

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance, nominal_stress, stiffness};
    #[includes(contact_bench::rubber::Data)]
    pub struct Data {
        theta: Param,
    }
    pub fn on_flat(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let gamma = 7 * stiffness();
        let stress = nominal_stress(u, p);
        let pressure = neg_part(stress + gamma * distance(u));
        let change = derivative(stress, u, v) + derivative(stress, p, q);
        let consistent = theta / gamma * (stress + pressure) * change;
        body(u, p, v, q) + integral(Surface, pressure * dot(v, obstacle_normal) - consistent)
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{allowed, balance};
    use forms_contact::operators::bodies::{own_gamma, own_traction};
    use forms_contact::operators::linear_elastic::stress;
    #[includes(contact_bench::two_bodies::bodies::Data)]
    pub struct Data {
        theta: Param,
        #[default(1)]
        part: Param,
    }
    pub fn traction(u: Vector) -> Vector {
        allowed(stress(u) * n, u)
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let consistent = theta / own_gamma() * dot(traction(u) - own_traction(u), own_traction(v));
        balance(u, v) + integral(Touch, part * (consistent - dot(traction(u), jump(v))))
    }
}

#[forms(dimension = 2)]
mod drawn {
    pub use contact_bench::sliding::{Omega, Touch};
    use contact_bench::sliding::{balance, own_stiffness, own_stress};
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {
        share: Param,
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = neg_part(own_stress(u) + 10 * own_stiffness() * gap);
        balance(u, v) + integral(Touch(u), share * pressure * dot(toward, jump(v)))
    }
}

/// Nitsche's method with a θ, over one surface or both.
pub struct Nitsche {
    theta: f64,
    sides: Sides,
}

/// θ = −1, 0 and 1 over the own surface and both, and θ = 0 at points of whole facets.
pub fn all() -> Vec<Nitsche> {
    let thetas = [-1.0, 0.0, 1.0].into_iter();
    let mut all: Vec<Nitsche> =
        thetas.flat_map(|theta| [Sides::Own, Sides::Both].map(|sides| Nitsche { theta, sides })).collect();
    all.push(Nitsche { theta: 0.0, sides: Sides::OwnWholeFacets });
    all
}

impl Nitsche {
    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        if self.sides == Sides::OwnWholeFacets {
            return Err(not_defined("written for pieces of facets"));
        }
        let data = |data| rough::data_from(data).theta(self.theta).part(self.sides.share());
        let (omega, touch) = (bodies.omega(), bodies.touch(self.sides));
        let form = |given| rough::between(&data(given), &omega, &touch);
        bodies.follow(13.0, form, |given, u| rough::traction(&data(given), u))
    }
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

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        if self.sides != Sides::Own {
            return Err(not_defined("an obstacle has no unknowns"));
        }
        let data = volume::data_from(membrane.data.clone()).theta(self.theta);
        membrane.newton(&volume::above(&data, &membrane.omega()), |u| volume::force(&data, u))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        if self.sides != Sides::Own {
            return Err(not_defined("a flat has no surface of its own"));
        }
        let data = |way: f64| rubber::data_from(ring.data(way)).theta(self.theta);
        ring.follow(|way| rubber::on_flat(&data(way), &ring.omega(), &ring.surface()))
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        if self.theta != 0.0 {
            return Err(not_defined("written for θ = 0: others need second derivatives of the stress"));
        }
        let data = drawn::data_from(bodies.data.clone()).share(self.sides.share());
        bodies.follow(&drawn::between(&data, &bodies.omega(), &bodies.touch(self.sides)))
    }
}
